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


def sentence(clip):
    with pytest.raises(UnreadableClip) as caught:
        require_legible(clip)
    return str(caught.value)


def test_a_covered_lens_is_refused():
    frames = gel()
    frames[2] = 3
    assert sentence(clip_of(frames)) == (
        "x.npy: 100% of frame 7 is black, expected at most 40%; check the camera and the sensor's "
        "lights."
    )


def test_a_black_rim_of_a_quarter_is_a_letterbox():
    frames, idle = gel(), IDLE.copy()
    frames[:, :8], frames[:, -8:], idle[:8], idle[-8:] = 0, 0, 0, 0
    assert require_legible(clip_of(frames, idle))


def test_a_dim_picture_is_refused():
    assert require_legible(clip_of(gel() * 0.2, np.rint(IDLE * 0.2).astype(np.uint8)))
    assert sentence(clip_of(gel() * 0.12, np.rint(IDLE * 0.12).astype(np.uint8))) == (
        "x.npy: frame 3 is dim, its middle grey level is 12, expected at least 18; lengthen the "
        "camera's exposure."
    )


def test_a_washed_out_frame_is_refused():
    frames = gel()
    frames[1, :, :40, 0] = 255
    assert sentence(clip_of(frames)) == (
        "x.npy: 50% of frame 5 is overexposed, expected at most 30%; shorten the camera's exposure."
    )


def test_noise_is_refused_when_it_outweighs_what_cameras_have():
    rng = np.random.default_rng(0)
    # Noise of 20, told by a median that comes in steps of 0.6.
    frames = gel() + rng.normal(0, 20, (4, 64, 80, 3))
    assert sentence(clip_of(frames)) == (
        "x.npy: the frames carry noise of 19 grey levels, expected at most 9; lower the camera's "
        "gain, or average several frames into each."
    )
    assert require_legible(clip_of(gel() + rng.normal(0, 4, (4, 64, 80, 3))))


def test_an_exposure_that_runs_away_is_refused():
    frames = gel() + np.array([0, 10, 20, 30])[:, None, None, None]
    assert sentence(clip_of(frames)) == (
        "x.npy: the brightness of the whole image changes by 30 grey levels within the clip, "
        "expected at most 12; lock the camera's exposure."
    )


@pytest.mark.parametrize("change", [40, -40])
def test_a_background_of_another_exposure_is_refused(change):
    assert sentence(clip_of(gel() + change)) == (
        "x.npy: frame 3 is 40 grey levels off the background, expected at most 25; give a "
        "background taken with the same camera, lights and exposure."
    )


def test_frames_of_a_few_pixels_are_not_judged_by_their_noise():
    small = np.random.default_rng(2).normal(100, 15, (4, 28, 28, 3))
    assert require_legible(clip_of(small, np.full((28, 28, 3), 100, np.uint8)))


def test_frames_too_small_to_tell_anything_are_refused():
    tiny = np.full((4, 23, 200, 3), 100)
    with pytest.raises(UnreadableClip, match="frames are 200x23 pixels, expected at least 24 a"):
        require_legible(clip_of(tiny, np.full((23, 200, 3), 100, np.uint8)))
