"""What no working camera shows is refused in one whole sentence; what one shows passes."""

import cv2
import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.recordings.legible import require_legible

IDLE = np.full((64, 80, 3), 100, np.uint8)


def gel(count=4):
    """An idle gel with an imprint that travels to the right."""
    frames = np.repeat(IDLE[None], count, axis=0).astype(np.float32)
    for number, frame in enumerate(frames):
        cv2.circle(frame, (30 + 4 * number, 32), 9, (130, 125, 120), -1)
    return frames


def clip_of(frames, background=IDLE):
    frames = np.clip(np.rint(frames), 0, 255).astype(np.uint8)
    return Clip(frames, background=background, name="x.npy", frame_numbers=(3, 5, 7, 9))


def with_frame(number, region, level):
    frames = gel()
    frames[number][region] = level
    return clip_of(frames)


def dimmed(share):
    return clip_of(gel() * share, np.rint(IDLE * share).astype(np.uint8))


def noisy(grey):
    return clip_of(gel() + np.random.default_rng(0).normal(0, grey, (4, 64, 80, 3)))


def tiny(rows, columns):
    idle = np.full((rows, columns, 3), 100, np.uint8)
    return clip_of(np.random.default_rng(2).normal(100, 15, (4, rows, columns, 3)), idle)


REFUSED = {
    "covered": (
        with_frame(2, np.s_[:], 3),
        "100% of frame 7 is black, expected at most 40%; check the camera and the sensor's lights.",
    ),
    "dim": (
        dimmed(0.12),
        "frame 3 is dim, its middle grey level is 12, expected at least 18; lengthen the camera's "
        "exposure.",
    ),
    "washed out": (
        with_frame(1, np.s_[:, :40, 0], 255),
        "50% of frame 5 is overexposed, expected at most 30%; shorten the camera's exposure.",
    ),
    "noisy": (  # of 20, told by a median that comes in steps of 0.6
        noisy(20),
        "the frames carry noise of 19 grey levels, expected at most 9; lower the camera's gain, or "
        "average several frames into each.",
    ),
    "exposure that runs away": (
        clip_of(gel() + np.array([0, 10, 20, 30])[:, None, None, None]),
        "the brightness of the whole image changes by 30 grey levels within the clip, expected at "
        "most 12; lock the camera's exposure.",
    ),
    "another exposure than the background's": (
        clip_of(gel() - 40),
        "frame 3 is 40 grey levels off the background, expected at most 25; give a background "
        "taken with the same camera, lights and exposure.",
    ),
    "tiny": (
        tiny(23, 200),
        "frames are 200x23 pixels, expected at least 24 a side; export the recording at a larger "
        "size.",
    ),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_what_no_working_camera_shows_is_refused(kind):
    clip, sentence = REFUSED[kind]
    with pytest.raises(UnreadableClip) as caught:
        require_legible(clip)
    assert str(caught.value) == f"x.npy: {sentence}"


def test_what_one_shows_passes():
    frames, idle = gel(), IDLE.copy()
    frames[:, :8], frames[:, -8:], idle[:8], idle[-8:] = 0, 0, 0, 0
    assert require_legible(clip_of(frames, idle))  # a letterbox: a quarter is black
    assert require_legible(dimmed(0.2))
    assert require_legible(noisy(4))
    assert require_legible(tiny(28, 28))  # too few pixels to be judged by their noise
