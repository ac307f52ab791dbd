"""Muon: momentum whose matrices are made orthogonal before each step (Jordan et al. 2024).

torch's own rounds to bfloat16, which processors without it emulate slowly; this one keeps single
precision. Vectors and embeddings take AdamW's steps, in the same `step()`.
"""

from __future__ import annotations

from collections.abc import Iterable

import torch
from torch import Tensor

COEFFICIENTS = (3.4445, -4.7750, 2.0315)
"""Of the quintic whose five turns bring every singular value near 1 (Jordan et al. 2024)."""
TURNS = 5
MOMENTUM = 0.95


def orthogonal(matrices: Tensor) -> Tensor:
    """Return the nearest matrices (n, a, b) whose singular values are all about 1 (0.7 to 1.2)."""
    a, b, c = COEFFICIENTS
    is_tall = matrices.shape[1] > matrices.shape[2]
    x = matrices.mT if is_tall else matrices
    x = x / x.norm(dim=(1, 2), keepdim=True).clamp(min=1e-7)
    for _ in range(TURNS):
        gram = x @ x.mT
        x = torch.baddbmm(x, torch.baddbmm(gram, gram, gram, beta=b, alpha=c), x, beta=a)
    return x.mT if is_tall else x


class Muon(torch.optim.AdamW):
    """AdamW but for the groups marked `is_orthogonal`, whose matrices take Muon's steps.

    Muon's steps are scaled to the size of AdamW's (Liu et al. 2025, 2.2), so that both go by one
    learning rate.
    """

    def __init__(self, groups: Iterable[dict], betas: tuple[float, float]) -> None:
        super().__init__(groups, betas=betas)

    @torch.no_grad()
    def step(self, closure: None = None) -> None:
        """Take one step."""
        orthogonals = [group for group in self.param_groups if group.get("is_orthogonal")]
        for group in orthogonals:
            alike: dict[tuple[int, ...], list[Tensor]] = {}
            for weight in group["params"]:
                if weight.grad is not None:
                    alike.setdefault(tuple(weight.shape), []).append(weight)
            for weights in alike.values():
                self._turn(weights, group)
        super().step(closure)

    def _turn(self, weights: list[Tensor], group: dict) -> None:
        """Take a step of matrices of one shape, all at once: on a GPU few calls are fast ones."""
        momenta = [self._momentum(weight) for weight in weights]
        grads = torch.stack([weight.grad for weight in weights])
        steps = orthogonal(grads.lerp(torch.stack(momenta), MOMENTUM))
        for weight, step in zip(weights, steps, strict=True):
            weight.mul_(1 - group["lr"] * group["weight_decay"])
            weight.add_(step, alpha=-0.2 * max(weight.shape) ** 0.5 * group["lr"])
            weight.grad = None

    def _momentum(self, weight: Tensor) -> Tensor:
        """Return a weight's momentum, its gradient added."""
        state = self.state[weight]
        state.setdefault("step", torch.tensor(0.0))  # AdamW looks for it when a state is loaded
        momentum = state.setdefault("momentum", torch.zeros_like(weight))
        return momentum.lerp_(weight.grad, 1 - MOMENTUM)
