"""The linear probe: the paper's own read-out of the fused token, restricted to the asked motions.

Knows nothing of how the token was made, standardised, or how the probe is trained.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import torch
from torch import Tensor, nn

from geotlm_lm.core.labels import Motion


class LinearProbe(nn.Module):
    """One linear layer over fused tokens, or over global tokens as the ablation.

    Args:
        width: Width d of a token.
        labels: The motions the probe tells apart, in the order of its outputs.

    Raises:
        ValueError: If fewer than two labels are given, or one of them twice.
    """

    def __init__(self, width: int, labels: Sequence[Motion]) -> None:
        super().__init__()
        if len(labels) < 2 or len(set(labels)) != len(labels):
            raise ValueError(f"a probe tells at least two different motions apart, found {labels}")
        self.labels = tuple(Motion(label) for label in labels)
        self.head = nn.Linear(width, len(self.labels))

    def forward(self, tokens: Tensor) -> Tensor:
        """Return logits (b, labels) of tokens (b, d)."""
        return self.head(tokens)

    @torch.no_grad()
    def probabilities(self, tokens: Tensor, among: Iterable[Motion] | None = None) -> Tensor:
        """Return softmax probabilities over `among`, in the order given.

        Args:
            tokens: Fused tokens, shape (b, d).
            among: The motions in question; None means all labels of the probe.

        Returns:
            Shape (b, len(among)), rows summing to 1.

        Raises:
            ValueError: If `among` is empty or names a motion the probe was not trained on.
        """
        return self(tokens)[:, self._columns(among)].softmax(dim=-1)

    @torch.no_grad()
    def predict(self, tokens: Tensor, among: Iterable[Motion] | None = None) -> list[Motion]:
        """Return the most probable of `among` for each token; arguments as in `probabilities`."""
        columns = self._columns(among)
        best = self(tokens)[:, columns].argmax(dim=-1)
        return [self.labels[columns[index]] for index in best.tolist()]

    def _columns(self, among: Iterable[Motion] | None) -> list[int]:
        if among is None:
            return list(range(len(self.labels)))
        asked = [Motion(motion) for motion in among]
        unknown = [motion.value for motion in asked if motion not in self.labels]
        if unknown or not asked:
            known = ", ".join(label.value for label in self.labels)
            raise ValueError(f"the probe tells apart {known}; asked among {unknown or 'nothing'}")
        return [self.labels.index(motion) for motion in asked]
