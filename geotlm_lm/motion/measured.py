"""What is measured of a clip's motion: candidates for its twist, and what tells which to trust.

The rigid motions that the stem found, and the one in the learned shear, all about the middle of the
contact mask; beside them how well each fits, how much is touched, and the fused token.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import interpolate

from geotlm_lm.backbone.motions import MOTION_NUMBERS
from geotlm_lm.backbone.stem import LOCAL_AT, MAGNIFICATION_AT, RELIEF_AT, RESIDUAL_DIM
from geotlm_lm.core.geometry import (
    DESCRIPTOR_DIM,
    FLOW_SCALE_PX,
    IMAGE_SIDE,
    REGIONS,
    pixel_aspect,
)
from geotlm_lm.dgr.encoder import Geometry

SQUARE_ASPECT = pixel_aspect(IMAGE_SIDE, IMAGE_SIDE)
"""Of the simulator's pictures."""

CANDIDATES = 5
"""The stem's four rigid motions, and the learned shear's."""

SHEAR_NOISE_PX = 0.1
"""Path of the learned shear, turn or travel, below which 95 of 100 held imprints stay, about."""

LEAST_RADIUS_PX = 4.0

SHEAR_SHARE = 1.5
"""A motion over its change between the time-bins' means, where four frames follow evenly."""


@dataclass(frozen=True, eq=False)
class Measured:
    """What is measured of each of b clips."""

    # Candidates, (b, CANDIDATES, 3): turn at the contact's radius, clockwise positive, and travel
    # of the contact's middle to the right and down; pixels of the 224-pixel image.
    paths: Tensor
    # Deviations of the candidates by white noise alone, likewise, (b, CANDIDATES, 3); of the shear
    # what 95 of 100 held imprints stay below.
    white: Tensor
    is_measured: Tensor  # whether there is such a candidate at all, (b, CANDIDATES)
    growth: Tensor  # log of the imprint's contrast in the late time-bin over the early one, (b,)
    radius_px: Tensor  # radius of the contact, pixels of the 224-pixel image, (b,)
    hints: Tensor  # what tells which candidate to trust, and what none of them does, (b, hints)

    def only(self, rows: Tensor | slice) -> Measured:
        """Return what is measured of some of the clips."""
        return Measured(*(value[rows] for value in vars(self).values()))

    def to(self, device: str) -> Measured:
        """Return it on a device."""
        return Measured(*(value.to(device) for value in vars(self).values()))

    @classmethod
    def joined(cls, parts: Sequence[Measured]) -> Measured:
        """Return what is measured of several batches, one behind the other."""
        columns = zip(*(vars(part).values() for part in parts), strict=True)
        return cls(*map(torch.cat, columns))


def measured(
    inputs: Tensor,
    motions: Tensor,
    geometry: Geometry,
    fused_token: Tensor,
    aspect: float = SQUARE_ASPECT,
) -> Measured:
    """Lay out what is measured of b clips.

    Inputs are (b, 2, 14, 14, PATCH_INPUT_DIM); motions, to the last frame, (b, 4, 7), as
    `Motions.numbers` has them; the fused token is z, (b, d); `aspect` is the width of a pixel over
    its height: a turn is rigid on the gel.
    """
    inputs, motions = inputs.float(), motions.float()
    side = IMAGE_SIDE * (-inputs[:, 0, 0, 0, MAGNIFICATION_AT]).exp()
    mask = geometry.mask.float()
    middle, radius = _contact(mask, side)
    turn, way = motions[..., 0], motions[..., 1:3]
    travel = _travel(turn, way, middle, aspect)
    stem = torch.cat([turn[..., None] * radius[:, None, None], travel], dim=-1)
    shear_turn, shear_way = rigid_motions(geometry.shear_change.float(), mask, aspect)
    # The view magnifies: its pixels are those of the image but for that.
    shear = torch.cat([(shear_turn * radius)[:, None], shear_way * (side / IMAGE_SIDE)[:, None]], 1)
    paths = torch.cat([stem, SHEAR_SHARE * shear[:, None]], dim=1)
    # Mean residual of each time-bin, as a log, and how much that grows from early to late.
    contrast = inputs[..., :RESIDUAL_DIM].abs().mean(dim=(2, 3, 4)).add(0.02).log()
    growth = contrast[:, 1] - contrast[:, 0]
    hints = torch.cat(
        [
            *(torch.asinh(4 * paths).flatten(1), torch.log(paths.abs() + 0.1).flatten(1)),
            _sureness(motions, radius),
            _whole(inputs, contrast, geometry, side, radius),
            fused_token.float(),
        ],
        dim=1,
    )
    white = torch.full_like(paths, SHEAR_NOISE_PX)
    white[:, :-1] = _white(motions, radius, middle)
    is_measured = torch.ones(paths.shape[:2], dtype=torch.bool)
    is_measured[:, :-1] = motions[..., 6] > 0
    return Measured(paths, white, is_measured, growth, radius, hints)


def _contact(mask: Tensor, side: Tensor) -> tuple[Tensor, Tensor]:
    """Return the middle of each contact, (b, 2), and its radius, (b,), of the 224-pixel image.

    The middle is told from the middle of the view. Of the squared mask: of 133 simulated contacts
    it lies 9 pixels from the true middle (median), 24 in one of ten.
    """
    weight = mask.square()
    weight = weight / weight.sum(dim=(1, 2), keepdim=True).clamp(min=1e-6)
    rows, columns = mask.shape[1:]
    x = (torch.arange(columns) + 0.5) / columns - 0.5
    y = (torch.arange(rows) + 0.5) / rows - 0.5
    across, down = weight.sum(dim=1), weight.sum(dim=2)
    middle = torch.stack([across @ x, down @ y], dim=1)
    spread = across @ x.square() + down @ y.square() - middle.square().sum(dim=1)
    radius = (spread.clamp(min=0).sqrt() * side).clamp(min=LEAST_RADIUS_PX)
    return middle * side[:, None], radius


def _travel(turn: Tensor, way: Tensor, middle: Tensor, aspect: float) -> Tensor:
    """Return how far what is now at the middle has come, (b, k, 2)."""
    stretch = torch.tensor([aspect, 1.0])
    place = (middle * stretch)[:, None]
    from_axis = place - way * stretch
    cos, sin = turn.cos(), turn.sin()
    x, y = from_axis.unbind(dim=-1)
    was = torch.stack([cos * x + sin * y, -sin * x + cos * y], dim=-1)
    return (place - was) / stretch


def _white(motions: Tensor, radius: Tensor, middle: Tensor) -> Tensor:
    """Return the deviations of the paths by white noise, (b, k, 3)."""
    turn = motions[..., 3]
    arm = middle.flip(1).abs()[:, None] * turn[..., None]
    way = torch.hypot(motions[..., 4:6], arm)
    return torch.cat([(turn * radius[:, None])[..., None], way], dim=-1)


def _sureness(motions: Tensor, radius: Tensor) -> Tensor:
    deviations, alike = motions[..., 3:6], motions[..., 6]
    at_radius = torch.cat([deviations[..., :1] * radius[:, None, None], deviations[..., 1:]], -1)
    return torch.cat([(at_radius + 1e-3).log().flatten(1), alike], dim=1)


def _whole(
    inputs: Tensor, contrast: Tensor, geometry: Geometry, side: Tensor, radius: Tensor
) -> Tensor:
    """Return what the whole view tells of contact, pressing and sureness, (b, n)."""
    bins = inputs.mean(dim=(2, 3))
    mask = _on_grid_of(inputs, geometry.mask.float())[:, None, :, :, None]
    touched = (inputs[..., RELIEF_AT : RELIEF_AT + 1] * mask).mean(dim=(2, 3, 4))
    mass = geometry.region_mass[:, REGIONS.index("global")].float()[:, None]
    spread = _divergence(inputs, geometry)
    return torch.cat(
        [
            contrast,
            contrast[:, 1:] - contrast[:, :1],
            touched,
            touched[:, 1:] - touched[:, :1],
            bins[:, :, -MOTION_NUMBERS:].flatten(1),
            bins[:, :, RELIEF_AT + 2 : -MOTION_NUMBERS].flatten(1),
            mass,
            side.log()[:, None],
            radius.log()[:, None],
            spread,
            geometry.descriptor.float().reshape(len(inputs), DESCRIPTOR_DIM),
        ],
        dim=1,
    )


def _divergence(inputs: Tensor, geometry: Geometry) -> Tensor:
    """Return how much what lies beyond the rigid motion, and the shear, spread from the middle."""
    mask = geometry.mask.float()
    local = inputs[:, 1, :, :, LOCAL_AT : LOCAL_AT + 2]
    fields = [(local, _on_grid_of(inputs, mask)), (geometry.shear_change.float(), mask)]
    return torch.stack([_outward(*pair) for pair in fields], dim=1)


def _outward(field: Tensor, mask: Tensor) -> Tensor:
    rows, columns = mask.shape[1:]
    x = (torch.arange(columns) - (columns - 1) / 2) / columns
    y = (torch.arange(rows) - (rows - 1) / 2) / rows
    total = mask.sum(dim=(1, 2)).clamp(min=1e-6)
    return ((field[..., 0] * x + field[..., 1] * y[:, None]) * mask).sum(dim=(1, 2)) / total


def _on_grid_of(inputs: Tensor, mask: Tensor) -> Tensor:
    """Return a mask on the stem's own grid; that of a released encoder may be another."""
    size = inputs.shape[2:4]
    if mask.shape[1:] == size:
        return mask
    return interpolate(mask[:, None], size, mode="bilinear").squeeze(1)


def rigid_motions(
    field: Tensor, weight: Tensor, aspect: float = SQUARE_ASPECT
) -> tuple[Tensor, Tensor]:
    """Fit a turn and a slide to each displacement field, by weighted least squares.

    The same closed form as `probe.rigid_flow.fit_rigid`, for many fields at once.

    Fields are in units of `FLOW_SCALE_PX`, (b, gh, gw, 2), x right, y down; weights (b, gh, gw) are
    not negative. Turns are in rad, (b,), positive clockwise as drawn, and slides in pixels of the
    view, (b, 2); zeros where there is no weight.
    """
    share = weight / weight.sum(dim=(1, 2), keepdim=True).clamp(min=1e-6)
    step_x, step_y = (field * FLOW_SCALE_PX).unbind(dim=-1)
    step_x = step_x * aspect
    rows, columns = weight.shape[1:]
    x, y = _centres(columns)[None, None, :] * aspect, _centres(rows)[None, :, None]

    def mean(values: Tensor) -> Tensor:
        return (share * values).sum(dim=(1, 2), keepdim=True)

    slide_x, slide_y = mean(step_x), mean(step_y)
    arm_x, arm_y = x - mean(x), y - mean(y)
    moved_x, moved_y = arm_x + step_x - slide_x, arm_y + step_y - slide_y
    across = mean(arm_x * moved_y - arm_y * moved_x)
    along = mean(arm_x * moved_x + arm_y * moved_y)
    slides = torch.cat([slide_x / aspect, slide_y], dim=1).squeeze(-1)
    return torch.atan2(across, along).flatten(), slides


def _centres(count: int) -> Tensor:
    """Return where the centres of so many patches in a row lie, pixels from the view's middle."""
    return (torch.arange(count) - (count - 1) / 2) * (IMAGE_SIDE / count)
