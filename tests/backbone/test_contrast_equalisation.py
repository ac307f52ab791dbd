"""Motions of evened images: the face inside a rim counts as much as the rim."""

import numpy as np
import pytest

from geotlm_lm.backbone.alignment import align, small
from geotlm_lm.backbone.alignment_images import AlignmentImages
from geotlm_lm.backbone.contrast_equalisation import (
    EQUALISED_SHAPE,
    equalise_contrast,
    equalised_motions,
)
from geotlm_lm.backbone.rigid import SIDE, Rigid
from geotlm_lm.backbone.stem import measure_clip
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS
from geotlm_lm.simulation.series import simulate_series

AXIS = np.arange(SIDE) - (SIDE - 1) / 2
X, Y = np.meshgrid(AXIS, AXIS)
RADIUS = np.hypot(X, Y)
RIM = np.exp(-((RADIUS - 18) ** 2) / 8).astype(np.float32)
RIM[Y < 0] *= 0.7  # as lights on one side shade it, which does not turn either
CROSS = ((np.minimum(abs(X), abs(Y)) < 2) * (RADIUS < 12) * (X + Y > -6)).astype(np.float32)


def test_contrast_is_alike_where_it_was_not():
    rng = np.random.default_rng(0)
    texture = rng.normal(0, 3, size=(SIDE, SIDE)).astype(np.float32)
    texture[:, SIDE // 2 :] *= 8
    left, right = np.split(equalise_contrast(small(texture)), 2, axis=1)
    assert right[:, 18:].std() / left[:, :-18].std() == pytest.approx(1, abs=0.3)


@pytest.mark.parametrize("turn_deg", [-15.0, 8.0, 20.0])
def test_a_face_that_turns_inside_a_rim_that_does_not_is_found(turn_deg):
    turned = Rigid(np.radians(turn_deg)).moved(0.3 * CROSS)
    rng = np.random.default_rng(0)
    before, after = (
        small(2 * RIM + face + rng.normal(0, 0.02, RIM.shape).astype(np.float32))
        for face in (0.3 * CROSS, turned)
    )
    found = np.degrees(align(equalise_contrast(before), equalise_contrast(after)).turn_rad)
    assert found == pytest.approx(turn_deg, rel=0.25)
    assert abs(found - turn_deg) < abs(np.degrees(align(before, after).turn_rad) - turn_deg)


def test_what_is_far_fainter_than_an_imprint_stays_faint():
    noise = np.random.default_rng(0).normal(0, 0.01, (SIDE, SIDE)).astype(np.float32)
    assert equalise_contrast(noise).std() < 0.05


@pytest.mark.parametrize("level", [0.0, 1e-20, 1e4])
def test_blank_and_extreme_images_stay_finite(level):
    image = level * np.random.default_rng(0).normal(size=(SIDE, SIDE)).astype(np.float32)
    assert np.isfinite(equalise_contrast(image)).all()


def test_simulated_turns_are_measured_and_pairs_repeat_what_they_repeat():
    made = next(iter(simulate_series(3, 1, objects=EVERYDAY_OBJECTS, motions=[Motion.CLOCKWISE])))
    clip = made.clip.select([0, 1, 2, 3])
    found = equalised_motions(measure_clip(clip).alignment_images)
    assert found.shape == EQUALISED_SHAPE
    turns = np.degrees(found[-1, :, :, 0])
    assert np.median(turns) == pytest.approx(made.label.rotation_deg, rel=0.3)
    pair = equalised_motions(measure_clip(clip.select([0, 0, 3, 3])).alignment_images)
    assert not pair[0].any()
    np.testing.assert_array_equal(pair[1], pair[2])


def test_an_untouched_gel_does_not_move():
    gel = np.full((4, 224, 224, 3), 110, np.uint8)
    assert not equalised_motions(measure_clip(Clip(gel, background=gel[0])).alignment_images).any()


def face_at(x, y, turn_rad=0.0):
    """A lopsided face around a place, turned about its own middle."""
    cos, sin = np.cos(turn_rad), np.sin(turn_rad)
    right, down = X - x, Y - y
    across, along = cos * right + sin * down, cos * down - sin * right
    bar = np.exp(-(across**2) / 50 - along**2 / 8)
    spot = np.exp(-((across - 3) ** 2 + (along + 5) ** 2) / 6)
    return small((bar + spot).astype(np.float32))


def traces_between(before, after, pixel_px):
    images = [before, after]
    return AlignmentImages(images, images, places=[0, 0, 1, 1], aspect=1.0, pixel_px=pixel_px)


def test_a_way_is_told_in_pixels_of_the_whole_picture():
    traces = traces_between(face_at(0, 0), face_at(3, -2), pixel_px=2.5)
    ways = equalised_motions(traces)[-1, ..., 1:3].reshape(-1, 2)
    assert ways == pytest.approx(np.tile([7.5, -5.0], (4, 1)), abs=0.5)


def test_a_face_beside_the_middle_that_turns_about_itself_goes_no_way():
    traces = traces_between(face_at(14, -4), face_at(14, -4, turn_rad=0.2), pixel_px=1.0)
    found = equalised_motions(traces)[-1].reshape(-1, 4)
    assert found[:, 0] == pytest.approx(0.2, rel=0.2)
    # Taken at the view's middle the way would be 2.9; what hardly changed draws it a little there.
    assert np.hypot(found[:, 1], found[:, 2]).max() < 1.6
