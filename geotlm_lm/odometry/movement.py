"""What tells how far an imprint moved: the rigid motions of its flow, alignments and learned shear.

Only sizes are kept, no directions: a clip and its mirror image moved as far.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

from geotlm_lm.backbone.contrast_equalisation import EQUALISED_SHAPE
from geotlm_lm.backbone.stem import (
    ALIGNED_AT,
    CELLS,
    FLOW_CHANNELS,
    FLOW_SCALE_PX,
    LAST_STEP,
    MAGNIFICATION_AT,
)
from geotlm_lm.core.geometry import IMAGE_SIDE, REGIONS, pixel_aspect
from geotlm_lm.dgr.encoder import Geometry

RESIDUAL_CHANNELS = 3 * CELLS**2

ALIGNMENTS = (0, 2, 6, 8)
"""Places of the displacements behind `ALIGNED_AT`: laid on the first frame and summed over the
steps, of the relief and of the residual."""

FLOWS = (RESIDUAL_CHANNELS, RESIDUAL_CHANNELS + FLOW_CHANNELS)
"""Places of the optical flow of the residual and of the relief."""

FLOOR = 0.3
"""Degrees or pixels below which all amounts are alike."""

SQUARE_ASPECT = pixel_aspect(IMAGE_SIDE, IMAGE_SIDE)
"""Of the simulator's pictures."""

_EQUALISED_DIM = math.prod(EQUALISED_SHAPE[:-1]) * 3
MOVEMENT_DIM = 2 * (1 + 2 * len(ALIGNMENTS) + len(FLOWS)) + 2 * len(LAST_STEP) + 2 + _EQUALISED_DIM
"""Numbers that describe how far a clip's imprint moved."""


def movement(
    inputs: Tensor, geometry: Geometry, equalised: Tensor, aspect: float = SQUARE_ASPECT
) -> Tensor:
    """Describe how far each clip's imprint moved, (b, MOVEMENT_DIM).

    First the logarithms of turn and travel of every rigid motion, the learned shear's first, in
    degrees and pixels of the 224-pixel image; then how well the alignments fit, the logarithm of
    the view's side, relative to the image's, and the contact mass; last turn, travel and fit of
    the contrast-equalised images' alignments.

    Early time-bins are among them: what is told is the way to the last frame, a bin is a mean of
    two, and frames do not follow each other evenly. Without these and the sums over the steps 0.83
    of the turns and 0.85 of the slides of objects kept from training are told within their
    tolerance, with them 0.86 and 0.90; flow, fits and view make that 0.88 and 0.91. Evened images
    make 0.805 of the turns in 3,500 clips of objects kept from training 0.828, the slides stay.

    Args:
        inputs: What the stem made of the clips, (b, 2, 14, 14, PATCH_INPUT_DIM).
        geometry: What DGR made of their tokens.
        equalised: How their contrast-equalised images are laid on each other,
            (b, *EQUALISED_SHAPE).
        aspect: Width of a pixel over its height.
    """
    inputs = inputs.float()
    side = (-inputs[:, 0, 0, 0, MAGNIFICATION_AT]).exp()
    # Patches count as much as they differ from the idle gel.
    changed = inputs[..., :RESIDUAL_CHANNELS].abs().mean(dim=(1, 4))
    motions = [rigid_motions(geometry.shear_change.float(), geometry.mask.float(), aspect)]
    for place in ALIGNMENTS:
        at = ALIGNED_AT + place
        for time_bin in (1, 0):
            motions.append(rigid_motions(inputs[:, time_bin, :, :, at : at + 2], changed, aspect))
    for at in FLOWS:
        motions.append(rigid_motions(inputs[:, 1, :, :, at : at + 2], changed, aspect))
    turns, travels = zip(*motions, strict=True)
    turn_deg = torch.stack(turns, dim=1).rad2deg().abs()
    travel_px = torch.stack(travels, dim=1).norm(dim=2) * side[:, None]
    sizes = torch.stack([turn_deg, travel_px], dim=2).flatten(1)
    fits = [inputs[..., place].mean(dim=(2, 3)) for place in LAST_STEP]
    mass = geometry.region_mass[:, REGIONS.index("global")].float()
    whole = torch.stack([side.log(), mass], dim=1)
    return torch.cat([_log(sizes), *fits, whole, _equalised_sizes(equalised.float())], dim=1)


def _equalised_sizes(equalised: Tensor) -> Tensor:
    turn_rad, way_px, fit = equalised.split([1, 2, 1], dim=-1)
    travel_px = way_px.norm(dim=-1, keepdim=True)
    sizes = [_log(turn_rad.rad2deg().abs()), _log(travel_px), fit]
    return torch.cat(sizes, dim=-1).flatten(1)


def _log(sizes: Tensor) -> Tensor:
    return (FLOOR + sizes).log()


def way_of_slide(inputs: Tensor) -> tuple[float, float]:
    """Return which way one clip's imprint slid, right and down, as a vector of length 1.

    By the stem's alignments: what DGR learns on a released encoder is no displacement. Where
    nothing moved, to the right.

    Args:
        inputs: What the stem made of the clip, (1, 2, 14, 14, PATCH_INPUT_DIM).
    """
    inputs = inputs.float()
    changed = inputs[..., :RESIDUAL_CHANNELS].abs().mean(dim=(1, 4))
    places = (ALIGNED_AT + ALIGNMENTS[0], ALIGNED_AT + ALIGNMENTS[2])
    slides = [rigid_motions(inputs[:, 1, :, :, at : at + 2], changed)[1][0] for at in places]
    way = torch.stack(slides).sum(dim=0)
    if not way.any():
        return 1.0, 0.0
    right, down = (way / way.norm()).tolist()
    return right, down


def rigid_motions(
    field: Tensor, weight: Tensor, aspect: float = SQUARE_ASPECT
) -> tuple[Tensor, Tensor]:
    """Fit a turn and a slide to each displacement field, by weighted least squares.

    The same closed form as `probe.rigid_fit.fit_rigid`, for many fields at once.

    Args:
        field: Displacement in units of `FLOW_SCALE_PX`, (b, gh, gw, 2), x right, y down.
        weight: (b, gh, gw), not negative.
        aspect: Width of a pixel over its height: a turn is rigid on the gel.

    Returns:
        Turns in rad, (b,), positive clockwise as drawn, and slides in pixels of the view, (b, 2).
        Zeros where there is no weight.
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
