"""What describes a movement: rigid motions in degrees and pixels, whatever the way."""

import numpy as np
import pytest
import torch

from geotlm_lm.backbone.contrast_equalisation import EQUALISED_SHAPE
from geotlm_lm.backbone.mirror import Mirror, mirrored_inputs
from geotlm_lm.backbone.stem import ALIGNED_AT, FLOW_SCALE_PX, MAGNIFICATION_AT, PATCH_INPUT_DIM
from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.odometry.movement import (
    FLOOR,
    MOVEMENT_DIM,
    SQUARE_ASPECT,
    movement,
    rigid_motions,
)
from geotlm_lm.probe.rigid_fit import fit_rigid

AT = (np.arange(14) - 6.5) * 16


def turned(degrees, x_px=0.0, y_px=0.0, aspect=SQUARE_ASPECT):
    """The displacement of a turn about the middle, then a slide, in units of the stem."""
    x, y = np.meshgrid(AT * aspect, AT)
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    moved_x, moved_y = (cos - 1) * x - sin * y, sin * x + (cos - 1) * y
    field = np.stack([moved_x / aspect + x_px, moved_y + y_px], axis=-1)
    return torch.from_numpy(field / FLOW_SCALE_PX).float()


STILL = torch.zeros(1, *EQUALISED_SHAPE)


def geometry(field, mask=None):
    shear = torch.stack([torch.zeros_like(field), field])[None]
    mask = torch.ones(1, 14, 14) if mask is None else mask
    with torch.no_grad():
        return DGR(4).pool(shear, shear[:, 1] - shear[:, 0], mask)


@pytest.mark.parametrize("degrees", [-40.0, -2.0, 0.0, 7.0, 30.0])
def test_a_rigid_motion_is_found_again(degrees):
    turn, slide = rigid_motions(turned(degrees, 3.0, -5.0)[None], torch.rand(1, 14, 14) + 0.5)
    assert turn.rad2deg().item() == pytest.approx(degrees, abs=1e-3)
    # The slide is that of the weight's centre, which the turn carries along.
    _, even = rigid_motions(turned(degrees, 3.0, -5.0)[None], torch.ones(1, 14, 14))
    assert even[0].tolist() == pytest.approx([3.0, -5.0], abs=1e-3)
    assert slide.shape == (1, 2)


def test_many_fits_are_those_of_the_fit_of_one():
    rng = np.random.default_rng(0)
    fields, weights = rng.normal(size=(5, 14, 14, 2)), rng.random((5, 14, 14))
    turns, slides = rigid_motions(torch.from_numpy(fields), torch.from_numpy(weights), 1.0)
    for i, (field, weight) in enumerate(zip(fields, weights, strict=True)):
        one = fit_rigid((field * FLOW_SCALE_PX).astype(np.float32), weight, grid_px=16.0)
        assert (turns[i].item(), *slides[i].tolist()) == pytest.approx(one, abs=1e-4)


def test_without_weight_nothing_moves():
    turn, slide = rigid_motions(turned(20.0, 4.0)[None], torch.zeros(1, 14, 14))
    assert (turn.item(), *slide[0].tolist()) == (0.0, 0.0, 0.0)


def test_grids_of_other_sizes_span_the_same_view():
    x = (torch.arange(7) - 3) * (IMAGE_SIDE / 7) * SQUARE_ASPECT
    y = (torch.arange(5) - 2) * (IMAGE_SIDE / 5)
    field = torch.stack([-0.1 * y[:, None].expand(5, 7) / SQUARE_ASPECT, 0.1 * x.expand(5, 7)], -1)
    turn, _ = rigid_motions(field[None] / FLOW_SCALE_PX, torch.ones(1, 5, 7))
    assert turn.item() == pytest.approx(np.arctan(0.1), abs=1e-5)


def inputs(field, magnification=1.0):
    made = torch.zeros(1, 2, 14, 14, PATCH_INPUT_DIM)
    made[..., :48] = 1.0
    made[..., MAGNIFICATION_AT] = np.log(magnification)
    made[:, 1, :, :, ALIGNED_AT : ALIGNED_AT + 2] = field
    return made


def test_the_first_numbers_are_the_shears_turn_and_travel_in_the_whole_image():
    found = movement(inputs(turned(0.0)), geometry(turned(12.0, 6.0, 8.0)), STILL)[0]
    assert found.shape == (MOVEMENT_DIM,)
    assert (found[:2].exp() - FLOOR).tolist() == pytest.approx([12.0, 10.0], abs=1e-2)
    # In a view magnified twice, the same field is half as far on the image.
    near = movement(inputs(turned(0.0), 2.0), geometry(turned(12.0, 6.0, 8.0)), STILL)[0]
    assert (near[:2].exp() - FLOOR).tolist() == pytest.approx([12.0, 5.0], abs=1e-2)


def test_the_reliefs_alignment_follows():
    found = movement(inputs(turned(9.0, 3.0, 4.0)), geometry(turned(0.0)), STILL)[0]
    assert (found[2:4].exp() - FLOOR).tolist() == pytest.approx([9.0, 5.0], abs=1e-2)


@pytest.mark.parametrize("mirror", list(Mirror))
def test_a_mirror_image_moves_as_far(mirror):
    rng = torch.Generator().manual_seed(0)
    made = torch.rand(1, 2, 14, 14, PATCH_INPUT_DIM, generator=rng)
    made[..., MAGNIFICATION_AT] = 0.3
    still = geometry(turned(0.0))
    flipped = mirrored_inputs(made, mirror)
    evened = torch.rand(1, *EQUALISED_SHAPE, generator=rng)
    # Turned the other way round, and left and right exchanged.
    opposite = evened * torch.tensor([-1.0, -1.0, 1.0, 1.0])
    assert movement(flipped, still, opposite)[0].tolist() == pytest.approx(
        movement(made, still, evened)[0].tolist(), abs=1e-4
    )


def test_the_last_numbers_are_turn_travel_and_fit_of_the_evened_images():
    evened = torch.zeros(1, *EQUALISED_SHAPE)
    evened[0, -1, -1, -1] = torch.tensor([np.radians(-25.0), 3.0, -4.0, 0.9])
    found = movement(inputs(turned(0.0)), geometry(turned(0.0)), evened)[0]
    assert (found[-3:-1].exp() - FLOOR).tolist() == pytest.approx([25.0, 5.0], abs=1e-2)
    assert found[-1].item() == pytest.approx(0.9)
