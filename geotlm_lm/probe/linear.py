"""The linear probe: the paper's own read-out of the fused token, restricted to the asked motions.

In training it learns on tokens; fitted by logistic regression it reads a few hand-made features.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from geotlm_lm.core.labels import Motion

MOST_STEPS = 500
"""Bound of the search; a few features need some tens of steps."""


class LinearProbe(nn.Module):
    """One linear layer over fused tokens, or over global tokens as the ablation.

    The labels are the motions it tells apart, two or more, in the order of its outputs.
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
        """Return softmax probabilities (b, len(among)) of tokens (b, d), in the order given.

        The motions are some that the probe was trained on; None means all of them.
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


def fit_logistic(
    features: Tensor, motions: Sequence[Motion], labels: Sequence[Motion], *, penalty: float = 1.0
) -> LinearProbe:
    """Return the probe with the least sum of losses plus penalty / 2 times its squared weights.

    Features are those of the training rows, standardised, (n, d); every motion is one of the
    labels. The offsets are free.
    """
    targets = torch.tensor([list(labels).index(motion) for motion in motions])
    wide = features.double()
    weight = torch.zeros(len(labels), wide.shape[1], dtype=torch.float64, requires_grad=True)
    bias = torch.zeros(len(labels), dtype=torch.float64, requires_grad=True)
    search = torch.optim.LBFGS(
        [weight, bias],
        max_iter=MOST_STEPS,
        tolerance_grad=1e-8,
        tolerance_change=1e-14,
        line_search_fn="strong_wolfe",
    )

    def loss() -> Tensor:
        search.zero_grad()
        misfit = F.cross_entropy(wide @ weight.T + bias, targets, reduction="sum")
        total = misfit + penalty / 2 * weight.square().sum()
        total.backward()
        return total

    search.step(loss)
    probe = LinearProbe(wide.shape[1], labels)
    with torch.no_grad():
        probe.head.weight.copy_(weight)
        # Only differences of offsets count; around zero, the search is free to leave them.
        probe.head.bias.copy_(bias - bias.mean())
    return probe
