"""Ten faults put into simulated recordings are each named, and none is seen in five good ones."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.doctor.examine import examine
from geotlm_lm.recordings.pixels import as_pixels, drifted, gained
from geotlm_lm.simulation.touch import Touch, simulate_touch

TOUCHES = (
    Touch("key", twist_deg=12, seed=1),
    Touch("coin", slide_x_mm=1.5, seed=2),
    Touch("hex_nut", twist_deg=-15, seed=3),
    Touch("bead", slide_y_mm=-1.0, seed=4),
    Touch("cable", slide_y_mm=1.2, seed=5),
)

NOISE_GREY = 0.8
IDLE, HELD = 12, 6


def recording(touch):
    """Return a recording of a simulated touch: idle for 12 frames, then 24 in contact."""
    made = simulate_touch(touch, preset="draft", with_drift=False).clip
    shown = [made.background] * IDLE + [one for one in made.frames for _ in range(HELD)]
    rng = np.random.default_rng(touch.seed)
    sized = [cv2.resize(one, (320, 240), interpolation=cv2.INTER_AREA) for one in shown]
    return Clip(np.stack([noisy(one, rng, NOISE_GREY) for one in sized]), fps=25.0)


def noisy(frame, rng, grey):
    return as_pixels(frame + rng.normal(0, grey, frame.shape))


@pytest.fixture(scope="module")
def good():
    return recording(TOUCHES[2])


def faults(clip):
    return [one.subject for one in examine(clip) if one.verdict == "fault"]


@pytest.mark.parametrize("touch", TOUCHES, ids=lambda touch: touch.object_name)
def test_a_good_recording_has_no_fault(touch):
    assert faults(recording(touch)) == []


def with_frames(change):
    return lambda clip: replace(clip, frames=change(clip.frames), frame_numbers=())


def with_times(steps_s):
    return lambda clip: replace(clip, fps=None, times_s=tuple(np.cumsum(steps_s(len(clip)))))


def jittering(count):
    return 0.04 * np.random.default_rng(0).uniform(0.4, 1.4, count)


def gaps(count):
    return np.where(np.arange(count) % 12 == 11, 0.12, 0.04)


def reddening(frames):
    share = np.linspace(0, 12, len(frames))[:, None, None, None]
    return as_pixels(frames + share * np.array([1.0, 0.0, 0.0]))


def resized(columns, rows):
    return with_frames(lambda frames: np.stack([cv2.resize(f, (columns, rows)) for f in frames]))


def noisier(frames):
    rng = np.random.default_rng(0)
    return np.stack([noisy(one, rng, 6.5) for one in frames])


PREPARED = {
    "frame rate": with_times(jittering),
    "dropped frames": with_times(gaps),
    "repeated frames": with_frames(lambda frames: np.repeat(frames[::2], 2, axis=0)),
    "colour order": with_frames(lambda frames: np.ascontiguousarray(frames[..., ::-1])),
    "exposure": with_frames(lambda frames: drifted(0.0, 0.15, frames)),
    "white balance": with_frames(reddening),
    "brightness": with_frames(lambda frames: gained(0.28, frames)),
    "clipping": with_frames(lambda frames: gained(2.4, frames)),
    "noise": with_frames(noisier),
    "idle gel": lambda clip: clip.select(range(IDLE, len(clip))),
    "size": resized(80, 60),
    "pixel shape": resized(320, 120),
    "mount": with_frames(lambda frames: np.ascontiguousarray(frames.transpose(0, 2, 1, 3))),
}


BRINGS = {"brightness": ["contrast"]}
"""Faults that bring others: what a dim picture shows of an imprint is faint."""


@pytest.mark.parametrize("fault", PREPARED)
def test_a_fault_is_named_alone(good, fault):
    named = [finding for finding in examine(PREPARED[fault](good)) if finding.verdict == "fault"]
    assert [finding.subject for finding in named] == [fault, *BRINGS.get(fault, [])]
    assert all(finding.measured and finding.means and finding.advice for finding in named)


def test_a_recording_without_a_touch_has_no_contrast(good):
    idle = replace(good.select(range(IDLE)), background=good.frames[0])
    assert faults(idle) == ["contrast"]


def test_markers_are_told(good):
    marked = recording(replace(TOUCHES[0], is_marked=True))
    told = {one.subject: one for one in examine(marked)}
    assert told["markers"].verdict == "limit"
    assert {one.subject: one for one in examine(good)}["markers"].measured == "none seen."


def test_what_cannot_be_told_is_said_to_be_unknown(good):
    grey = np.repeat(good.frames[..., 1:2], 3, axis=-1)
    told = {one.subject: one.verdict for one in examine(replace(good, frames=grey, fps=None))}
    unknown = [subject for subject, verdict in told.items() if verdict == "unknown"]
    assert unknown == ["frame rate", "dropped frames", "mount", "colour order"]
