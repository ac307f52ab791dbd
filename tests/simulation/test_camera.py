"""Expected light and noise: what was measured on GelSight Minis and their lossy recordings."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from geotlm_lm.core.numbers import generator_for
from geotlm_lm.simulation.camera import (
    CODED_BLUR_PX,
    Recorder,
    coded_noise,
    idle_frame,
)
from geotlm_lm.simulation.scene import GELSIGHT_MINI, Optics, VideoCodec

GREY = np.full((3, 224, 224), 100.4, np.float32)
STEADY = Optics(drift_grey=0.0)
VIDEO = replace(STEADY, video=VideoCodec())


def test_idle_frames_stay_near_the_measured_light():
    means = np.mean([idle_frame(seed).mean(axis=(1, 2)) for seed in range(40)], axis=0)
    assert np.all(np.abs(means - GELSIGHT_MINI.levels.mean(axis=(1, 2))) < 22)


def test_the_sides_of_the_lights_are_never_swapped():
    # Measured: the top of a whole view is bluer than the bottom.
    frames = [idle_frame(seed) for seed in range(40)]
    top = np.mean([frame[2, :40].mean() for frame in frames])
    bottom = np.mean([frame[2, -40:].mean() for frame in frames])
    assert top > bottom + 10


def degree_rms(image, degrees):
    """Return the RMS of an image's part of the given total degrees, fitted up to degree 8."""
    small = cv2.resize(image, (56, 56), interpolation=cv2.INTER_AREA).ravel()
    axis = np.linspace(-1, 1, 56)
    powers = np.polynomial.legendre.legvander2d(*np.meshgrid(axis, axis), [8, 8]).reshape(-1, 81)
    total = np.add(*np.divmod(np.arange(81), 9))
    left = [
        small - powers[:, total <= top] @ np.linalg.lstsq(powers[:, total <= top], small)[0]
        for top in (degrees[0] - 1, degrees[1])
    ]
    return float(np.sqrt(np.square(left[0]).mean() - np.square(left[1]).mean()))


@pytest.mark.parametrize(("channel", "low", "high"), [(0, 2.5, 6.1), (1, 0.9, 1.6), (2, 1.9, 4.4)])
def test_the_field_of_degrees_5_and_6_is_as_strong_as_real_ones(channel, low, high):
    # Bounds: 30 recordings and two sets of stills, measured the same way.
    sizes = [degree_rms(idle_frame(seed)[channel], (5, 6)) for seed in range(30)]
    assert low < np.median(sizes) < high


def test_corners_are_as_dark_as_real_ones():
    frames = np.stack([idle_frame(seed) for seed in range(60)])
    ends = (slice(None, 28), slice(-28, None))
    corners = np.mean([frames[:, :, r, c].mean((2, 3)) for r in ends for c in ends], axis=0)
    share = np.median(corners / frames[:, :, 98:126, 98:126].mean((2, 3)), axis=0)
    # Four real sources: 0.20 to 0.28, 0.61 to 0.71, 0.47 to 0.52; medians of 60 vary by 0.02.
    assert share == pytest.approx((0.25, 0.66, 0.49), abs=0.06)


def test_a_codecs_noise_is_as_soft_along_rows_as_across_them():
    noise = np.stack([coded_noise(np.random.default_rng(seed))[0] for seed in range(8)])
    along = np.corrcoef(noise[:, :, 1:].ravel(), noise[:, :, :-1].ravel())[0, 1]
    across = np.corrcoef(noise[:, 1:].ravel(), noise[:, :-1].ravel())[0, 1]
    # White noise behind a Gaussian correlates as exp(-d^2 / 4 sigma^2) over a distance d.
    expected = np.exp(-1 / (4 * CODED_BLUR_PX**2))
    assert (along, across) == pytest.approx((expected, expected), abs=0.01)


def recorder(optics, seed=0):
    return Recorder(optics, generator_for(seed, "recording"))


def frames_of(optics, count, seed=0):
    taking = recorder(optics, seed)
    return np.stack([taking.next(GREY) for _ in range(count)]).astype(float)


def changes(optics, count):
    return np.diff(frames_of(optics, count), axis=0)


def test_a_cameras_noise_is_new_in_every_frame_and_pixel():
    change = changes(STEADY, 6)
    sizes = change.std(axis=(0, 1, 2)) / np.sqrt(2)
    # Rounding to whole grey levels adds a twelfth to the variance.
    assert sizes == pytest.approx(np.sqrt(np.square(STEADY.noise_grey) + 1 / 12), rel=0.03)
    assert abs((change[:, :, 1:] * change[:, :, :-1]).mean()) < 0.02 * np.square(change).mean()


def test_a_videos_noise_stands_still_until_a_frame_is_stored_whole():
    still = replace(VIDEO, video=replace(VIDEO.video, predicted_grey=(0.0,) * 3))
    assert not changes(replace(still, video=replace(still.video, frames_apart=0)), 6).any()
    always = changes(replace(still, video=replace(still.video, frames_apart=12)), 6)
    expected = np.sqrt(np.square(VIDEO.video.whole_grey) + 1 / 12)
    assert always.std(axis=(0, 1, 2)) / np.sqrt(2) == pytest.approx(expected, rel=0.06)


def test_between_whole_frames_neighbours_and_channels_change_together():
    never_whole = replace(VIDEO, video=replace(VIDEO.video, frames_apart=0))
    change = changes(never_whole, 8)
    beside = (change[:, :, 1:] * change[:, :, :-1]).mean() / np.square(change).mean()
    together = np.corrcoef(change[..., 0].ravel(), change[..., 2].ravel())[0, 1]
    # Measured on videos: 0.54 to 0.58 and 0.42 to 0.51.
    assert beside == pytest.approx(0.56, abs=0.08)
    assert together == pytest.approx(0.47, abs=0.1)
    assert 0.15 < change.std() / np.sqrt(2) < 0.45


def test_an_averaged_idle_frame_is_quieter_but_a_videos_is_not():
    quiet = recorder(STEADY).background(GREY).astype(float)
    # About five frames are averaged.
    expected = np.sqrt(np.square(STEADY.noise_grey) / 5 + 1 / 12)
    assert quiet.std(axis=(0, 1)) == pytest.approx(expected, rel=0.05)
    lossy = recorder(VIDEO).background(GREY).astype(float)
    assert np.all(lossy.std(axis=(0, 1)) > 0.8 * np.array(VIDEO.video.whole_grey))


@pytest.mark.parametrize(
    ("optics", "within"), [(STEADY, 0.1), (VIDEO, 0.5), (replace(STEADY, jpeg_quality=70), 1.5)]
)
def test_a_recording_keeps_the_level_and_repeats_with_its_seed(optics, within):
    first, second = frames_of(optics, 3, seed=4), frames_of(optics, 3, seed=4)
    assert np.array_equal(first, second)
    assert first.mean(axis=(0, 1, 2)) == pytest.approx((100.4,) * 3, abs=within)
    assert np.any(first != frames_of(optics, 3, seed=5))


def test_white_balance_drifts_by_what_is_asked_for():
    taking = recorder(replace(STEADY, drift_grey=0.3))
    levels = np.stack([taking.next(GREY).mean(axis=(0, 1)) for _ in range(200)])
    assert levels.std(axis=0) == pytest.approx((0.3,) * 3, rel=0.2)
