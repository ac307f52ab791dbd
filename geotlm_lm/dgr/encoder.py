"""The Differentiable Geometric Representation: patch tokens in, named geometry out (Eqs. 2-8).

The paper also calls it the Differentiable Physics Encoder; here it is DGR throughout.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from geotlm_lm.core.geometry import DESCRIPTOR_DIM, SHEAR_CHANNEL_COUNT, TIME_BIN_COUNT
from geotlm_lm.dgr.regions import pool_regions, region_mass


@dataclass(frozen=True, eq=False)
class Geometry:
    """Every intermediate of DGR, so that probes, figures and answers need no hooks."""

    shear: Tensor  # learned shear per time-bin, shape (b, k, gh, gw, 2), unitless (Eq. 2)
    shear_change: Tensor  # late bin minus early bin, shape (b, gh, gw, 2) (Eq. 3)
    mask: Tensor  # contact mask, mean over bins, shape (b, gh, gw), in [0, 1] (Eq. 4)
    region_mass: Tensor  # mean mask of each region, shape (b, 7), in [0, 1]
    descriptor: Tensor  # the 14 numbers r: seven regions of x, then of y, shape (b, 14)
    feature: Tensor  # geometric feature g, shape (b, d) (Eq. 8)


class DGR(nn.Module):
    """Pool a learned shear change into a feature of the backbone's width (Eqs. 2-8).

    The feature's width, None for that of a patch token, is the global token's: they differ where it
    is made of the whole grid. At a width of 768 the three projections hold 13,827 parameters.
    """

    def __init__(self, width: int, feature_width: int | None = None) -> None:
        super().__init__()
        self.to_shear = nn.Linear(width, SHEAR_CHANNEL_COUNT)
        self.to_mask = nn.Linear(width, 1)
        self.to_feature = nn.Linear(DESCRIPTOR_DIM, feature_width or width)

    def forward(self, patches: Tensor) -> Geometry:
        """Compute the geometry of clips' patch tokens (b, 2, gh, gw, d), early time-bin first."""
        if patches.ndim != 5 or patches.shape[1] != TIME_BIN_COUNT:
            raise ValueError(f"patches are (b, 2, gh, gw, d), found {tuple(patches.shape)}")
        shear = self.to_shear(patches)  # Eq. 2
        shear_change = shear[:, 1] - shear[:, 0]  # Eq. 3
        return self.pool(shear, shear_change, self.contact_mask(patches))

    def contact_mask(self, patches: Tensor) -> Tensor:
        """Return the contact confidence of each patch, mean over bins, (b, gh, gw) (Eq. 4)."""
        return torch.sigmoid(self.to_mask(patches)).squeeze(-1).mean(dim=1)

    def pool(self, shear: Tensor, shear_change: Tensor, mask: Tensor) -> Geometry:
        """Pool a shear change and a mask into the descriptor and the feature (Eqs. 5-8)."""
        descriptor = self.describe(shear_change, mask)
        return Geometry(
            shear=shear,
            shear_change=shear_change,
            mask=mask,
            region_mass=region_mass(mask),
            descriptor=descriptor,
            feature=self.to_feature(descriptor.to(self.to_feature.weight.dtype)),
        )

    def describe(self, shear_change: Tensor, mask: Tensor) -> Tensor:
        """Return the descriptor r: seven regions of x, then of y, shape (b, 14) (Eqs. 5-8)."""
        regions = [pool_regions(shear_change[..., axis], mask) for axis in range(2)]
        return torch.cat(regions, dim=-1)
