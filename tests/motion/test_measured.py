"""What is measured: rigid motions about the contact's middle, in pixels of the 224-pixel image."""

import numpy as np
import pytest
import torch

from geotlm_lm.backbone.motions import MOTIONS_SHAPE
from geotlm_lm.backbone.stem import MAGNIFICATION_AT, PATCH_INPUT_DIM
from geotlm_lm.core.geometry import FLOW_SCALE_PX
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.motion.measured import (
    CANDIDATES,
    LEAST_RADIUS_PX,
    SHEAR_SHARE,
    SQUARE_ASPECT,
    measured,
    rigid_motions,
)
from geotlm_lm.probe.rigid_flow import fit_rigid

AT = (np.arange(14) - 6.5) * 16


def turned(degrees, x_px=0.0, y_px=0.0, aspect=SQUARE_ASPECT):
    """The displacement of a turn about the middle, then a slide, in units of the stem."""
    x, y = np.meshgrid(AT * aspect, AT)
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    moved_x, moved_y = (cos - 1) * x - sin * y, sin * x + (cos - 1) * y
    field = np.stack([moved_x / aspect + x_px, moved_y + y_px], axis=-1)
    return torch.from_numpy(field / FLOW_SCALE_PX).float()


@pytest.mark.parametrize("degrees", [-40.0, -2.0, 0.0, 7.0, 30.0])
def test_a_rigid_motion_is_found_again(degrees):
    turn, _ = rigid_motions(turned(degrees, 3.0, -5.0)[None], torch.rand(1, 14, 14) + 0.5)
    assert turn.rad2deg().item() == pytest.approx(degrees, abs=1e-3)
    # The slide is that of the weight's centre, which the turn carries along.
    _, even = rigid_motions(turned(degrees, 3.0, -5.0)[None], torch.ones(1, 14, 14))
    assert even[0].tolist() == pytest.approx([3.0, -5.0], abs=1e-3)


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


def looked_at(mask, motion=(0.0, 0.0, 0.0), shear=None, magnification=1.0):
    """What is measured of one clip whose four alignments agree on `motion`: rad, px, px."""
    field = torch.zeros(14, 14, 2) if shear is None else shear
    both = torch.stack([torch.zeros_like(field), field])[None]
    with torch.no_grad():
        geometry = DGR(4).pool(both, both[:, 1] - both[:, 0], mask)
    inputs = torch.zeros(1, 2, 14, 14, PATCH_INPUT_DIM)
    inputs[..., MAGNIFICATION_AT] = np.log(magnification)
    motions = torch.zeros(1, *MOTIONS_SHAPE)
    motions[..., :3] = torch.tensor(motion)
    return measured(inputs, motions, geometry, torch.zeros(1, 4))


def disc(x, y, radius=2.5):
    """A contact about (x, y), patches from the middle of the view."""
    places = torch.arange(14) - 6.5
    return ((places - x).square() + (places[:, None] - y).square() < radius**2).float()[None]


def test_a_turn_is_told_at_the_contacts_radius_and_a_slide_as_it_is():
    # A disc's radius of gyration is its radius over the root of two.
    found = looked_at(disc(0.0, 0.0, 5.0), (0.1, 3.0, -2.0), magnification=2.0)
    radius = found.radius_px.item()
    assert radius == pytest.approx(5.0 * 16 / 2**0.5 / 2, rel=0.05)
    assert found.paths.shape == (1, CANDIDATES, 3)
    assert found.paths[0, :4, 0].tolist() == pytest.approx([0.1 * radius] * 4)
    for path in found.paths[0, :4, 1:]:
        # The middle of the contact is carried round the middle of the view, where it now is not.
        assert path.tolist() == pytest.approx([3.0, -2.0], abs=0.4)


def test_a_contact_beside_the_axis_travels_as_the_turn_carries_it():
    # Now 4 patches to the right of the axis: a small clockwise turn brought it down.
    found = looked_at(disc(4.0, 0.0), (0.05, 0.0, 0.0))
    right, down = found.paths[0, 0, 1:].tolist()
    assert down == pytest.approx(np.sin(0.05) * 64 * SQUARE_ASPECT, rel=1e-3)
    assert right == pytest.approx((1 - np.cos(0.05)) * 64, rel=1e-3)


def test_in_a_mirror_all_candidates_turn_and_go_the_other_way():
    field = turned(6.0, 4.0, 2.0)
    mirrored = field.flip(1) * torch.tensor([-1.0, 1.0])
    own = looked_at(disc(3.0, -2.0), (0.1, 5.0, 2.0), field)
    seen = looked_at(disc(-3.0, -2.0), (-0.1, -5.0, 2.0), mirrored)
    expected = own.paths * torch.tensor([-1.0, -1.0, 1.0])
    torch.testing.assert_close(seen.paths, expected, atol=1e-3, rtol=1e-4)


def test_the_shears_motion_is_the_last_candidate_in_pixels_of_the_image():
    found = looked_at(disc(0.0, 0.0), shear=turned(6.0, 4.0, 2.0), magnification=2.0)
    turn, right, down = (found.paths[0, -1] / SHEAR_SHARE).tolist()
    assert turn == pytest.approx(np.radians(6.0) * found.radius_px.item(), rel=1e-3)
    assert (right, down) == pytest.approx((2.0, 1.0), abs=1e-3)


def test_an_untouched_gel_has_a_radius_and_finite_hints():
    found = looked_at(torch.zeros(1, 14, 14))
    assert found.radius_px.item() == LEAST_RADIUS_PX
    assert not found.paths.any()
    assert bool(found.hints.isfinite().all())


def test_a_contact_on_another_grid_is_the_same_contact():
    fine = looked_at(disc(3.0, -2.0), (0.1, 5.0, 2.0))
    with torch.no_grad():
        mask = torch.nn.functional.interpolate(disc(3.0, -2.0)[:, None], (28, 28))[:, 0]
        geometry = DGR(4).pool(torch.zeros(1, 2, 28, 28, 2), torch.zeros(1, 28, 28, 2), mask)
    inputs, motions = torch.zeros(1, 2, 14, 14, PATCH_INPUT_DIM), torch.zeros(1, *MOTIONS_SHAPE)
    motions[..., :3] = torch.tensor((0.1, 5.0, 2.0))
    other = measured(inputs, motions, geometry, torch.zeros(1, 4))
    torch.testing.assert_close(other.paths, fine.paths, rtol=0.03, atol=0.03)
    torch.testing.assert_close(other.hints, fine.hints, rtol=0.05, atol=0.05)
