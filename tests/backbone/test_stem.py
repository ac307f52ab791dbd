"""Expected values: shifts and turns applied to a synthetic imprint by OpenCV's warp.

Laws of mirrors: turned-over inputs are those of the turned-over clip, and a second mirror undoes
the first.
"""

from dataclasses import replace

import cv2
import numpy as np
import pytest
import torch

from geotlm_lm.backbone import imprint
from geotlm_lm.backbone.motions import MEASURED, MOTION_NUMBERS
from geotlm_lm.backbone.relief import SHADE_X, SHADE_Y
from geotlm_lm.backbone.stem import (
    ALIGNED_AT,
    ALIGNED_DIM,
    FLOW_SCALE_PX,
    LOCAL_AT,
    MAGNIFICATION_AT,
    PATCH_INPUT_DIM,
    RELIEF_AT,
    Mirror,
    measure_clip,
    mirrored_inputs,
)
from geotlm_lm.backbone.view import MIN_VIEW_PX, View, contact_view
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.simulation.simulate import simulate_series

ALIGNED = slice(ALIGNED_AT, ALIGNED_AT + ALIGNED_DIM)
CONTRAST = LOCAL_AT + 3


def moving_clip(shift_px=(0.0, 0.0), turn_deg=0.0, noise_grey=1.0):
    """Four frames of a textured imprint that moves evenly from the first frame to the last."""
    rng = np.random.default_rng(0)
    texture = cv2.GaussianBlur(rng.normal(size=(224, 224)).astype(np.float32), (0, 0), 3)
    rows, columns = np.mgrid[:224, :224]
    window = np.exp(-(((rows - 112) ** 2 + (columns - 112) ** 2) / (2 * 45**2)))
    imprint = (texture / texture.std() * window * 30).astype(np.float32)
    frames = []
    for share in (0, 1 / 3, 2 / 3, 1):
        # OpenCV counts angles counterclockwise as drawn; ours are clockwise.
        matrix = cv2.getRotationMatrix2D((112, 112), -turn_deg * share, 1.0)
        matrix[:, 2] += np.array(shift_px) * share
        moved = cv2.warpAffine(imprint, matrix, (224, 224))
        noise = rng.normal(size=(224, 224, 3)) * noise_grey
        frames.append(np.clip(110 + moved[..., None] + noise, 0, 255).astype(np.uint8))
    return Clip(np.stack(frames), background=np.full((224, 224, 3), 110, np.uint8))


def moved_px(inputs, time_bin, way="green_chained"):
    start = ALIGNED_AT + 2 * MEASURED.index(way)
    return inputs[time_bin, 4:10, 4:10, start : start + 2].mean(axis=(0, 1)) * FLOW_SCALE_PX


@pytest.mark.parametrize("shift", [(3.0, 0.0), (-3.0, 0.0), (0.0, 6.0), (1.0, -1.0)])
def test_each_time_bin_tells_the_mean_displacement_of_its_frames(shift):
    inputs, view, _ = measure_clip(moving_clip(shift))
    shift, zoom = np.array(shift), IMAGE_SIDE / view.side_px
    # Frames sit at 0, 1/3 | 2/3, 1 of the way: means 1/6 and 5/6.
    for way in ("green_chained", "green_direct"):
        assert moved_px(inputs, 0, way) / zoom == pytest.approx(shift / 6, abs=0.1)
        assert moved_px(inputs, 1, way) / zoom == pytest.approx(shift * 5 / 6, abs=0.15)


def test_a_clockwise_turn_moves_the_top_right_and_the_right_side_down():
    inputs, _, motions = measure_clip(moving_clip(turn_deg=6.0))
    right, down = inputs[1, ..., ALIGNED_AT], inputs[1, ..., ALIGNED_AT + 1]
    assert min(right[4, 6:8].mean(), -right[9, 6:8].mean()) > 0.3
    assert min(down[6:8, 9].mean(), -down[6:8, 4].mean()) > 0.3
    assert motions.twists[0, 0] > 0


def test_repeated_frames_carry_no_motion():
    clip = moving_clip((4.0, 0.0))
    still = measure_clip(clip.select([0, 0, 0, 0])).inputs
    assert np.abs(still[..., ALIGNED]).max() == np.abs(still[..., LOCAL_AT:CONTRAST]).max() == 0
    pair, view, _ = measure_clip(clip.select([0, 0, 3, 3]))
    assert np.abs(pair[0, ..., ALIGNED]).max() == 0
    zoom = IMAGE_SIDE / view.side_px
    assert moved_px(pair, 1)[0] / zoom == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize("numbers", [(0, 0, 3, 3), (0, 2, 2, 3), (1, 1, 1, 1)])
def test_a_repeated_frame_is_looked_at_once_and_tells_the_same(numbers, monkeypatch):
    clip = moving_clip((4.0, 1.0), turn_deg=6.0).select(numbers)
    looks, residual = [], imprint._residual
    monkeypatch.setattr(imprint, "_residual", lambda *one: looks.append(one) or residual(*one))
    inputs, view, _ = measure_clip(clip)
    assert len(looks) == len(set(numbers))
    monkeypatch.setattr(imprint, "_distinct", lambda frames: (list(frames), [0, 1, 2, 3]))
    expected, other, _ = measure_clip(clip)
    assert len(looks) == len(set(numbers)) + 4
    assert view == other
    # Aligned with the first frame once more, a repeated one may end a step nearer.
    deviation = np.abs(inputs - expected) / (np.abs(expected).mean(axis=(0, 1, 2)) + 1e-3)
    # How surely the first frame lies on itself is not measured.
    assert deviation[..., :-MOTION_NUMBERS].max() < 0.1


def test_contrast_is_higher_where_the_imprint_is():
    contrast = measure_clip(moving_clip()).inputs[..., CONTRAST]
    assert contrast[:, 6:8, 6:8].min() > contrast[:, 0, 0].max() + 0.5


def test_inputs_do_not_depend_on_the_recorded_size_beyond_resampling():
    clip = moving_clip((3.0, 0.0), noise_grey=0.0)
    twice = [cv2.resize(frame, (640, 480)) for frame in clip.frames]
    large = Clip(np.stack(twice), background=np.full((480, 640, 3), 110, np.uint8))
    small, large = measure_clip(clip).inputs, measure_clip(large).inputs
    assert small.shape == large.shape == (2, 14, 14, PATCH_INPUT_DIM)
    assert moved_px(large, 1) == pytest.approx(moved_px(small, 1), abs=0.1)


def test_a_clip_without_background_is_refused():
    clip = Clip(np.zeros((4, 32, 32, 3), np.uint8))
    with pytest.raises(ValueError, match="the stem reads 4 frames and a background, found 4"):
        measure_clip(clip)


def imprint_at(x, y, sigma_px):
    rng = np.random.default_rng(0)
    texture = cv2.GaussianBlur(rng.normal(size=(224, 224)).astype(np.float32), (0, 0), 2)
    rows, columns = np.mgrid[:224, :224]
    window = np.exp(-((rows - y) ** 2 + (columns - x) ** 2) / (2 * sigma_px**2))
    frame = 110 + texture / texture.std() * window * 30
    noisy = frame[None, ..., None] + rng.normal(size=(4, 224, 224, 3))
    background = np.full((224, 224, 3), 110, np.uint8)
    return Clip(np.clip(noisy, 0, 255).astype(np.uint8), background=background)


@pytest.mark.parametrize(("x", "y"), [(60, 150), (170, 70), (112, 112)])
def test_the_view_is_laid_around_the_imprint_and_every_patch_knows_how_large(x, y):
    inputs, view, _ = measure_clip(imprint_at(x, y, sigma_px=12))
    assert (view.centre_x_px, view.centre_y_px) == pytest.approx((x, y), abs=6)
    assert MIN_VIEW_PX <= view.side_px < 130
    assert inputs[..., MAGNIFICATION_AT] == pytest.approx(np.log(224 / view.side_px), rel=1e-5)


def test_an_untouched_gel_is_looked_at_as_a_whole():
    rng = np.random.default_rng(0)
    frames = (110 + rng.normal(size=(4, 224, 224, 3))).astype(np.uint8)
    assert (
        measure_clip(Clip(frames, background=np.full((224, 224, 3), 110, np.uint8))).view == View()
    )


def shaded_clip(shift_px=(0.0, 0.0)):
    """Four camera pictures of a twisted dent that slides, under the usual lights."""
    y, x = np.mgrid[:240, :320]
    frames = []
    for share in (0, 1 / 3, 2 / 3, 1):
        right, down = x - 150 - shift_px[0] * share, y - 130 - shift_px[1] * share
        bar = np.exp(-((right - down) ** 2) / 900 - (right + down) ** 2 / 4000)
        dent = bar + 0.8 * np.exp(-((right - 25) ** 2 + (down - 8) ** 2) / 90)
        slope_y, slope_x = (-one for one in np.gradient(150 * dent))
        shade = np.stack(
            [-0.5 * SHADE_Y * slope_y, SHADE_X * slope_x, 0.5 * SHADE_Y * slope_y], axis=-1
        )
        frames.append(np.clip(np.rint(120 + shade), 0, 255).astype(np.uint8))
    return Clip(np.stack(frames), background=np.full((240, 320, 3), 120, np.uint8))


def turned_clip(clip, quarters):
    """Turn a recording counterclockwise, lights and all."""
    frames = np.ascontiguousarray(np.rot90(clip.frames, quarters, (1, 2)))
    return Clip(frames, background=np.ascontiguousarray(np.rot90(clip.background, quarters)))


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_recording_turned_by_quarters_shows_dents_as_dents_and_their_motion(quarters):
    inputs, view, _ = measure_clip(turned_clip(shaded_clip((9.0, 0.0)), quarters))
    relief = inputs[1, ..., RELIEF_AT]
    assert relief.max() > 3 * abs(relief.min())
    # What goes right as recorded goes up after one quarter counterclockwise.
    way = np.array([(1, 0), (0, -1), (-1, 0), (0, 1)][quarters])
    own = (320, 240) if quarters == 2 else (240, 320)
    pixels = np.array([view.picture_width_px, view.picture_height_px]) / own
    expected = way * 9.0 * 5 / 6 * pixels * IMAGE_SIDE / view.side_px
    for kind in MEASURED:
        found = moved_px(inputs, 1, kind)
        assert found == pytest.approx(expected, abs=0.1 * np.abs(expected).max()), kind


def test_a_portrait_picture_keeps_its_shape_and_the_view_says_what_it_fills():
    portrait = turned_clip(shaded_clip(), 1)
    _, view, _ = measure_clip(portrait)
    assert (view.picture_height_px, view.picture_width_px) == (224, 126)
    # The dent is at (150, 130) of 320 x 240: turned, 130 to the right and 320 - 150 down.
    x = (view.centre_x_px - (224 - 126) / 2) / 126 * 240
    assert (x, view.centre_y_px / 224 * 320) == pytest.approx((130, 170), abs=12)


def test_the_whole_view_cuts_nothing_and_a_half_view_magnifies_twice():
    image = np.arange(224 * 224, dtype=np.float32).reshape(224, 224)
    assert np.array_equal(View().cut(image), image)
    quarter = View(56, 56, 112).cut(image)
    # The image is a ramp; the view's second pixel lies a quarter past the image's first.
    assert np.array_equal(quarter[1:-1:2, 1:-1:2], image[:111, :111] + 0.25 * (224 + 1))


@pytest.mark.parametrize("corner", [(-130, 40), (40, -130), (240, 40), (40, 240)])
def test_nothing_is_seen_beside_the_image(corner):
    cut = View(corner[0] + 50, corner[1] + 50, 100).cut(np.ones((224, 224, 3), np.float32))
    assert cut.shape == (224, 224, 3)
    assert not cut.any()


def test_a_view_lies_on_whole_pixels():
    energy = np.zeros((28, 28), np.float32)
    energy[5:12, 9:17] = np.random.default_rng(0).uniform(50, 900, (7, 8))
    view = contact_view([energy])
    corner = (view.centre_x_px - view.side_px / 2, view.centre_y_px - view.side_px / 2)
    assert all(float(length).is_integer() for length in (*corner, view.side_px))
    assert (view.centre_x_px, view.centre_y_px) == pytest.approx((104, 68), abs=8)


@pytest.mark.parametrize("noise", [0.0, 5.0, 40.0])
def test_noise_that_is_everywhere_moves_no_view(noise):
    energy = np.zeros((28, 28), np.float32)
    energy[5:9, 18:22] = 900
    seen = contact_view([energy + np.float32(noise)])
    # Of four cells of eight pixels: the middle, and less than the smallest view.
    assert (seen.centre_x_px, seen.centre_y_px, seen.side_px) == (160, 56, 96)


def seen(clip):
    return torch.from_numpy(measure_clip(clip).inputs)[None]


def turned_over(clip, mirror):
    frames = np.flip(clip.frames, 1 + mirror.value)
    background = np.flip(clip.background, mirror.value)
    return replace(
        clip, frames=np.ascontiguousarray(frames), background=np.ascontiguousarray(background)
    )


@pytest.fixture(scope="module")
def clips():
    # Grey shading under the usual lights tells no slope down the image, so that lights above and
    # below are alike; the relief of coloured shading finds out by itself that left and right are
    # swapped.
    coloured = next(iter(simulate_series(3, 1, objects=("key",)))).clip
    return {
        Mirror.TOP_AND_BOTTOM: moving_clip((3.0, 2.0), turn_deg=5.0),
        Mirror.LEFT_AND_RIGHT: coloured,
    }


@pytest.fixture
def usual_lights(monkeypatch):
    """Grey shading is not taken for that of one light."""
    found = imprint.lights_of
    monkeypatch.setattr(imprint, "lights_of", lambda *seen: replace(found(*seen), are_one=False))


@pytest.mark.usefixtures("usual_lights")
@pytest.mark.parametrize("mirror", Mirror)
def test_turned_over_inputs_are_those_of_the_turned_over_clip(clips, mirror):
    expected = seen(turned_over(clips[mirror], mirror))
    found = mirrored_inputs(seen(clips[mirror]), mirror)
    error, size = (one.abs().mean(dim=(0, 1, 2, 3)) for one in (found - expected, expected))
    # Of the strongest two fifths of the gradients ties are taken in another order.
    assert (error / (size + 1e-3)).max() < 0.01


@pytest.mark.usefixtures("usual_lights")
@pytest.mark.parametrize("mirror", Mirror)
def test_a_second_mirror_undoes_the_first(clips, mirror):
    inputs = seen(clips[mirror])
    once = mirrored_inputs(inputs, mirror)
    assert not torch.equal(once, inputs)
    assert torch.equal(mirrored_inputs(once, mirror), inputs)
