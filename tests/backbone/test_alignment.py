"""Laws of the rigid alignment: it finds what moved an image, over turns, shifts and channels."""

import cv2
import numpy as np
import pytest

from geotlm_lm.backbone.alignment import CHANNELS, align, align_sequence, alignment, small
from geotlm_lm.backbone.rigid import SIDE, Rigid

AXIS = np.arange(SIDE) - (SIDE - 1) / 2
X, Y = np.meshgrid(AXIS, AXIS)
IMPRINT = (
    np.exp(-((X - 4) ** 2 + 3 * (Y + 2) ** 2) / 60)
    + 0.5 * np.exp(-((X + 7) ** 2 + (Y - 6) ** 2) / 8)
).astype(np.float32)


def sensor_noise(seed, grey=0.02):
    return np.random.default_rng(seed).normal(0, grey, (SIDE, SIDE)).astype(np.float32)


@pytest.mark.parametrize(
    "motion",
    [
        Rigid(0.02, 0.3, -0.2),
        Rigid(-0.15, 2.0, 1.0),
        Rigid(0.6, 0.0, 0.0),
        Rigid(-0.5, -5, 4),
        Rigid(0.0, 9.4, 0.0),
        Rigid(0.3, 2.0, 1.0, aspect=4 / 3),
        Rigid(-0.4, 0.0, -3.0, aspect=0.75),
    ],
)
def test_a_known_motion_is_found_again(motion):
    after = 0.9 * motion.moved(IMPRINT) + 0.05 + sensor_noise(1)
    found = align(IMPRINT + sensor_noise(2), after, aspect=motion.aspect)
    assert found.turn_rad == pytest.approx(motion.turn_rad, abs=0.02)
    assert (found.x_px, found.y_px) == pytest.approx((motion.x_px, motion.y_px), abs=0.15)


@pytest.mark.parametrize("aspect", [1.0, 4 / 3])
def test_motions_follow_each_other_as_the_images_do(aspect):
    first, second = Rigid(0.3, 2.0, -1.0, aspect), Rigid(-0.1, 1.0, 3.0, aspect)
    twice = second.moved(first.moved(IMPRINT))
    once = second.after(first).moved(IMPRINT)
    assert np.abs(once - twice)[8:-8, 8:-8].max() < 0.05


def test_displacement_is_how_far_the_point_under_a_patch_has_come():
    moved = Rigid(0.1).displacement()
    assert moved[0, :, 0].min() > 0  # clockwise: the top goes right
    assert moved[:, -1, 1].min() > 0  # and the right side down
    shifted = Rigid(0.0, 3.0, -2.0).displacement()
    assert shifted.reshape(-1, 2) == pytest.approx(np.tile([3.0, -2.0], (196, 1)))


def test_a_round_outline_squashed_to_an_ellipse_may_turn_in_itself():
    """The round head of a screw: its rim stays where it is, its slot turns."""
    aspect = 4 / 3

    def squashed_head(turn_rad):
        x, y = X * aspect, Y
        across = x * np.cos(turn_rad) + y * np.sin(turn_rad)
        rim = 3.0 * np.exp(-((np.hypot(x, y) - 20) ** 2) / 8)
        slot = np.exp(-(across**2) / 8) * (np.hypot(x, y) < 17)
        return (rim + slot).astype(np.float32)

    before = squashed_head(0.2) + sensor_noise(6)
    after = squashed_head(0.35) + sensor_noise(7)
    assert align(before, after, aspect=aspect).turn_rad == pytest.approx(0.15, rel=0.1)
    assert align(before, after).turn_rad < 0.12


def test_displacement_of_a_turn_is_one_on_the_gel():
    motion = Rigid(0.2, aspect=4 / 3)
    moved = motion.displacement() * (4 / 3, 1)
    plain = Rigid(0.2).displacement()
    # A column is 4/3 as wide on the gel: its patches lie farther out, those of the rows do not.
    assert moved[..., 0][:, 7] == pytest.approx(plain[..., 0][:, 7], abs=0.3)
    sizes = np.hypot(*np.moveaxis(moved, -1, 0))
    x, y = np.meshgrid((np.arange(14) - 6.5) * 4 * 4 / 3, (np.arange(14) - 6.5) * 4)
    assert sizes == pytest.approx(2 * np.sin(0.1) * np.hypot(x, y), rel=1e-4)


def test_the_same_image_twice_has_not_moved():
    assert align(IMPRINT, IMPRINT.copy()) == Rigid()


def test_of_two_equal_matches_the_shorter_way_is_taken():
    stripes = np.tile(np.sin(2 * np.pi * X / 8), 1).astype(np.float32)
    moved = np.sin(2 * np.pi * (X - 1) / 8).astype(np.float32)
    assert align(stripes, moved).x_px == pytest.approx(1, abs=0.1)


def test_channels_tell_the_motion_from_the_first_frame_and_what_it_explains():
    frames = [Rigid(0.0, 2.0 * k, 0.0).moved(IMPRINT) for k in range(3)]
    told = alignment(*([small(scale * frame) for frame in frames] for scale in (1, 5)))
    assert told.shape == (3, 14, 14, 2 * CHANNELS)
    assert not told[0, ..., : CHANNELS - 1].any()
    for start in (0, CHANNELS):
        for found in (start, start + 2):
            assert told[2, ..., found] == pytest.approx(np.full((14, 14), 4.0 * 4), abs=0.5)
        assert told[1:, 4:10, 4:10, start + 4].mean() > 0.3
        assert told[1:, ..., start + 5].min() > 0.98


def test_steps_add_up_to_what_is_laid_on_the_first_frame_directly():
    frames = [Rigid(0.0, 1.0 * k, -0.5 * k).moved(IMPRINT) for k in range(4)]
    before = Rigid()
    for k, [found] in enumerate(align_sequence([frames]), start=1):
        assert found.summed == found.step.after(before)
        for total in (found.direct, found.summed):
            assert (total.x_px, total.y_px) == pytest.approx((k, -0.5 * k), abs=0.2)
        before = found.summed


def test_what_is_now_at_a_point_came_from_where_the_motion_began():
    motion = Rigid(np.pi / 2, 3.0, 1.0)
    # The middle turns about itself and is carried along; what was right of it is now below.
    assert motion.way_to(np.float32([3.0, 1.0])) == pytest.approx([3.0, 1.0], abs=1e-5)
    assert motion.way_to(np.float32([3.0, 11.0])) == pytest.approx([-7.0, 11.0], abs=1e-5)


@pytest.mark.parametrize("level", [0.0, 1e-20, 1e4])
def test_blank_and_extreme_images_give_finite_channels(level):
    rng = np.random.default_rng(0)
    frames = [level * rng.normal(size=(SIDE, SIDE)).astype(np.float32) for _ in range(4)]
    assert np.isfinite(alignment(frames, frames)).all()


def test_an_outline_that_stands_still_does_not_hold_back_a_turn():
    """A flat object on a domed pad: its contact's outline is the pad's, its face turns."""
    rng = np.random.default_rng(3)
    outline = (1.2 / (1 + np.exp((np.hypot(X, Y) - 16) / 1.5))).astype(np.float32)
    face = cv2.GaussianBlur(rng.normal(0, 2.5, (SIDE, SIDE)).astype(np.float32), (0, 0), 2.5)
    turn = Rigid(0.1)
    before = outline * (1 + face) + sensor_noise(4)
    after = outline * (1 + turn.moved(face)) + sensor_noise(5)
    assert align(before, after).turn_rad == pytest.approx(0.1, rel=0.2)


@pytest.mark.parametrize("aspect", [1.0, 4 / 3, 0.75])
def test_ways_back_follow_each_other_in_the_other_order(aspect):
    first, second = Rigid(0.3, 20.0, -10.0, aspect), Rigid(-0.4, 1.0, 3.0, aspect)
    back, before = second.way_back(), first.way_back()
    came_from = before[:, :2] @ back
    came_from[:, 2] += before[:, 2]
    assert second.after(first).way_back() == pytest.approx(came_from, abs=1e-4)


@pytest.mark.parametrize("seed", range(3))
def test_a_spoilt_frame_between_spoils_only_the_sum_of_the_steps(seed):
    rng = np.random.default_rng(seed)
    spoilt = Rigid(0.0, 1.0, 0.0).moved(IMPRINT) + rng.normal(0, 0.5, IMPRINT.shape)
    frames = [IMPRINT, spoilt.astype(np.float32), Rigid(0.0, 2.0, 0.0).moved(IMPRINT)]
    *_, [last] = align_sequence([[small(frame) for frame in frames]])
    assert (last.direct.x_px, last.direct.y_px) == pytest.approx((2.0, 0.0), abs=0.05)
    assert abs(last.summed.x_px - 2.0) > 0.2


@pytest.mark.parametrize("aspect", [0.6, 0.75, 1.0, 4 / 3])
@pytest.mark.parametrize("turn_rad", [-0.15, -0.07, 0.05, 0.2])
def test_a_turn_is_found_from_rest_whatever_the_shape_of_a_pixel(aspect, turn_rad):
    rest, motion = Rigid(aspect=aspect), Rigid(turn_rad, 1.0, -2.0, aspect)
    after = motion.moved(IMPRINT) + sensor_noise(2)
    found = align(IMPRINT + sensor_noise(1), after, rest, aspect=aspect)
    assert found.turn_rad == pytest.approx(turn_rad, abs=0.01)
    assert (found.x_px, found.y_px) == pytest.approx((1.0, -2.0), abs=0.12)
