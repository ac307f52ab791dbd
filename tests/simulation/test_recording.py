"""Expected noise: what was measured on lossy recordings of a GelSight Mini, and the settings'."""

from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.core.numbers import generator_for
from geotlm_lm.simulation.recording import Recorder
from geotlm_lm.simulation.scene import Optics, VideoCodec

GREY = np.full((3, 224, 224), 100.4, np.float32)
STEADY = Optics(drift_grey=0.0)
VIDEO = replace(STEADY, video=VideoCodec())


def recorder(optics, seed=0):
    return Recorder(optics, generator_for(seed, "recording"))


def frames_of(optics, count, seed=0):
    taking = recorder(optics, seed)
    return np.stack([taking.next(GREY) for _ in range(count)]).astype(float)


def changes(optics, count):
    return np.diff(frames_of(optics, count), axis=0)


def test_a_cameras_noise_is_new_in_every_frame():
    found = changes(STEADY, 6).std(axis=(0, 1, 2)) / np.sqrt(2)
    # Rounding to whole grey levels adds a twelfth to the variance.
    assert found == pytest.approx(np.sqrt(np.square(STEADY.noise_grey) + 1 / 12), rel=0.03)


def test_a_videos_noise_stands_still_until_a_frame_is_stored_whole():
    still = replace(VIDEO, video=replace(VIDEO.video, predicted_grey=(0.0,) * 3))
    assert not changes(replace(still, video=replace(still.video, frames_apart=0)), 6).any()
    always = changes(replace(still, video=replace(still.video, frames_apart=12)), 6)
    expected = np.sqrt(np.square(VIDEO.video.whole_grey) + 1 / 12)
    assert always.std(axis=(0, 1, 2)) / np.sqrt(2) == pytest.approx(expected, rel=0.06)


def test_one_frame_in_twelve_is_stored_whole():
    taking = recorder(VIDEO)
    frames = np.stack([taking.next(GREY)[:64, :64] for _ in range(300)]).astype(np.float32)
    sizes = np.abs(np.diff(frames, axis=0)).mean(axis=(1, 2, 3))
    # 299 draws of 1/12: a standard deviation of 0.016.
    assert np.mean(sizes > 2 * np.median(sizes)) == pytest.approx(1 / 12, abs=0.05)


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
