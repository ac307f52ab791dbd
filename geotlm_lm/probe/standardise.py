"""Standardisation of features with statistics of the training split only; knows no labels."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor


@dataclass(frozen=True, eq=False)
class Standardiser:
    """Shift and scale of each feature, fixed once fitted."""

    mean: Tensor  # mean of each feature over the training rows, shape (d,)
    # Standard deviation of each feature, shape (d,); 1 where the feature never varied.
    scale: Tensor

    @classmethod
    def fit(cls, features: Tensor) -> Standardiser:
        """Measure mean and standard deviation of the training rows.

        Features are (n, d), n >= 1: rows of the training split and of no other.
        """
        if features.ndim != 2 or not len(features):
            raise ValueError(f"expected features (n, d) with n >= 1, found {tuple(features.shape)}")
        # Sums in float64: a large common offset would otherwise leave rounding noise as "variance".
        wide = features.double()
        mean = wide.mean(dim=0)
        scale = wide.std(dim=0, unbiased=False)
        varies = scale > RELATIVE_FLOOR * mean.abs().clamp(min=1.0)
        scale = torch.where(varies, scale, torch.ones_like(scale))
        return cls(mean.to(features.dtype), scale.to(features.dtype))

    def apply(self, features: Tensor) -> Tensor:
        """Return features (..., d) shifted and scaled; a constant feature becomes its offset."""
        return (features - self.mean) / self.scale

    def state(self) -> dict[str, Tensor]:
        """Return what `from_state` reads."""
        return {"mean": self.mean, "scale": self.scale}

    @classmethod
    def from_state(cls, state: dict[str, Tensor]) -> Standardiser:
        """Rebuild a standardiser from `state`."""
        return cls(state["mean"], state["scale"])


RELATIVE_FLOOR = 1e-6
"""A spread below this share of the mean is float32 rounding (2^-24 = 6e-8), not signal."""
