"""Logistic regression to its minimum: a linear probe of a few hand-made features."""

from __future__ import annotations

from collections.abc import Sequence

import torch
import torch.nn.functional as F
from torch import Tensor

from geotlm_lm.core.labels import Motion
from geotlm_lm.probe.linear import LinearProbe

MOST_STEPS = 500
"""Bound of the search; a few features need some tens of steps."""


def fit_logistic(
    features: Tensor, motions: Sequence[Motion], labels: Sequence[Motion], *, penalty: float = 1.0
) -> LinearProbe:
    """Return the probe with the least sum of losses plus penalty / 2 times its squared weights.

    Args:
        features: Standardised features of the training rows, shape (n, d).
        motions: The motion of each row.
        labels: The motions to tell apart.
        penalty: Weight of the squared weights; the offsets are free.

    Raises:
        ValueError: If a motion is not among the labels.
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
