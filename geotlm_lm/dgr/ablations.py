"""DGR with parts taken out, or with the differential operators put in: the paper's ablations."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from geotlm_lm.core.geometry import REGION_COUNT, REGIONS, SHEAR_CHANNEL_COUNT
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.dgr.regions import pool_regions

OPERATORS = ("curl", "divergence", "stretch", "shear_strain")
"""What is computed, in this order. The paper names curl, divergence and strain; the two components
of strain that change no area are the ones divergence leaves."""


@dataclass(frozen=True)
class DGRParts:
    """Which parts of DGR there are; those of the paper by default."""

    regions: bool = True  # seven regions; without them the mean over the whole grid alone
    mask: bool = True  # the learned contact mask; without it every patch weighs the same
    operators: bool = False  # curl, divergence and strains of the shear change are pooled beside it

    @property
    def descriptor_dim(self) -> int:
        """Length of the descriptor."""
        fields = SHEAR_CHANNEL_COUNT + len(OPERATORS) * self.operators
        return fields * (REGION_COUNT if self.regions else 1)


class AblatedDGR(DGR):
    """DGR of chosen parts; with the parts of the paper it is `DGR`."""

    def __init__(self, width: int, feature_width: int | None, parts: DGRParts) -> None:
        super().__init__(width, feature_width)
        self.parts = parts
        self.to_feature = nn.Linear(parts.descriptor_dim, feature_width or width)
        if not parts.mask:
            del self.to_mask  # what is not there is not counted, nor trained

    def contact_mask(self, patches: Tensor) -> Tensor:
        """Return the contact mask, 1 everywhere where there is none; shape (b, gh, gw)."""
        if self.parts.mask:
            return super().contact_mask(patches)
        return torch.ones_like(patches[:, 0, ..., 0])

    def describe(self, shear_change: Tensor, mask: Tensor) -> Tensor:
        """Return the pooled fields, shape (b, descriptor_dim): each field's regions in a row."""
        fields = shear_change
        if self.parts.operators:
            fields = torch.cat([fields, differential_operators(shear_change)], dim=-1)
        pooled = [pool_regions(field, mask) for field in fields.unbind(dim=-1)]
        if not self.parts.regions:
            whole = REGIONS.index("global")
            pooled = [values[..., whole : whole + 1] for values in pooled]
        return torch.cat(pooled, dim=-1)


def differential_operators(shear_change: Tensor) -> Tensor:
    """Return `OPERATORS` of a field (b, gh, gw, 2) per patch step, (b, gh, gw, 4).

    Components are x right, y down; differences are central, at the border one-sided. Curl is
    positive where the field turns clockwise as drawn.
    """
    x, y = shear_change.unbind(dim=-1)
    x_down, x_right = torch.gradient(x, dim=(1, 2))
    y_down, y_right = torch.gradient(y, dim=(1, 2))
    fields = (y_right - x_down, x_right + y_down, x_right - y_down, x_down + y_right)
    return torch.stack(fields, dim=-1)
