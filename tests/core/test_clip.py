"""A clip is checked at birth and keeps where its frames stood."""

import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip

FRAMES = np.arange(5 * 8 * 9 * 3, dtype=np.int64).astype(np.uint8).reshape(5, 8, 9, 3)


@pytest.mark.parametrize(
    ("given", "error", "sentence"),
    [
        (
            {"frames": FRAMES.astype(np.float32)},
            UnreadableClip,
            "clip: found float32 frames of shape (5, 8, 9, 3), expected uint8 "
            "(frames, rows, columns, 3); convert the array first.",
        ),
        (
            {"frames": FRAMES[:0]},
            UnreadableClip,
            "clip: holds no pixels (shape (0, 8, 9, 3)); record it again.",
        ),
        (
            {"frames": FRAMES[:, :7]},
            UnreadableClip,
            "clip: frames are 9x7 pixels, expected at least 8 per side; "
            "export the recording at its full size.",
        ),
        (
            {"background": FRAMES[0, 1:]},
            UnreadableClip,
            "clip: the background has shape (7, 9, 3), the frames (8, 9, 3); give an idle frame of "
            "the same size.",
        ),
        (
            {"background": FRAMES[0] / 255},
            UnreadableClip,
            "clip: the background is float64, expected uint8 as the frames are; convert the array "
            "first.",
        ),
        (
            {"frames": list(FRAMES)},
            TypeError,
            "Clip takes one numpy array of frames, found list; stack them by np.stack(frames), or "
            "read a file by read_clip(path)",
        ),
        (
            {"background": "idle.png"},
            TypeError,
            "the background of a Clip is a numpy array, found str; give an idle frame of the same "
            "size, or leave it out",
        ),
        ({"frame_numbers": (0, 1)}, ValueError, "5 frames have 2 numbers"),
    ],
)
def test_what_makes_no_clip_is_refused_with_what_to_give(given, error, sentence):
    with pytest.raises(error) as caught:
        Clip(**{"frames": FRAMES} | given)
    assert str(caught.value) == sentence


@pytest.mark.parametrize("fps", [0, -1.0, float("nan"), float("inf")])
def test_a_senseless_frame_rate_counts_as_unknown_and_is_told_once(fps):
    note = (
        f"The frame rate {fps:g} is not used, expected more than 0 and less than 100000 per second."
    )
    assert Clip(FRAMES, fps=fps).fps is None
    assert Clip(FRAMES, fps=fps).select([0, 1]).notes == (note,)
    assert Clip(FRAMES, fps=np.array(25.0)).notes == Clip(FRAMES).notes == ()


def test_selected_frames_keep_where_they_stood():
    twice = Clip(FRAMES).select([1, 2, 4]).select([0, 2])
    assert twice.frame_numbers == (1, 4)
    assert np.array_equal(twice.frames, FRAMES[[1, 4]])


def test_reversing_twice_gives_the_clip_back():
    clip = Clip(FRAMES, fps=5)
    assert np.array_equal(clip.reversed().frames, FRAMES[::-1])
    assert clip.reversed().reversed().frame_numbers == clip.frame_numbers


def test_frames_cannot_be_written_to_and_the_array_they_came_in_can():
    array = FRAMES.copy()
    clip = Clip(array)
    with pytest.raises(ValueError, match="read-only"):
        clip.frames[0, 0, 0, 0] = 1
    array[0, 0, 0, 0] = 1
