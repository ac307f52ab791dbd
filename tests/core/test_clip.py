"""A clip is checked at birth and keeps where its frames stood."""

import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip

FRAMES = np.arange(5 * 8 * 9 * 3, dtype=np.int64).astype(np.uint8).reshape(5, 8, 9, 3)


@pytest.mark.parametrize(
    ("frames", "sentence"),
    [
        (
            FRAMES.astype(np.float32),
            "clip: found float32 frames of shape (5, 8, 9, 3), expected uint8 "
            "(frames, rows, columns, 3); convert the array first.",
        ),
        (
            FRAMES[0],
            "clip: found uint8 frames of shape (8, 9, 3), expected uint8 "
            "(frames, rows, columns, 3); convert the array first.",
        ),
        (FRAMES[:0], "clip: holds no pixels (shape (0, 8, 9, 3)); record it again."),
        (
            FRAMES[:, :7],
            "clip: frames are 9x7 pixels, expected at least 8 per side; "
            "export the recording at its full size.",
        ),
    ],
)
def test_frames_of_another_form_are_refused(frames, sentence):
    with pytest.raises(UnreadableClip) as caught:
        Clip(frames)
    assert str(caught.value) == sentence


@pytest.mark.parametrize(
    ("background", "sentence"),
    [
        (
            FRAMES[0, 1:],
            "(8, 9, 3); give an idle frame of the same size.",
        ),
        (FRAMES[0] / 255, "float64, expected uint8 as the frames are; convert the array first."),
    ],
)
def test_a_background_of_another_form_is_refused(background, sentence):
    with pytest.raises(UnreadableClip) as caught:
        Clip(FRAMES, background=background)
    assert str(caught.value).endswith(sentence)


@pytest.mark.parametrize("fps", [0, -1.0, float("nan"), float("inf")])
def test_a_senseless_frame_rate_counts_as_unknown_and_is_told_once(fps):
    note = (
        f"The frame rate {fps:g} is not used, expected more than 0 and less than 100000 per second."
    )
    assert Clip(FRAMES, fps=fps).fps is None
    assert Clip(FRAMES, fps=fps).select([0, 1]).notes == (note,)
    assert Clip(FRAMES, fps=np.array(25.0)).notes == Clip(FRAMES).notes == ()


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (
            {"frames": list(FRAMES)},
            "Clip takes one numpy array of frames, found list; stack them by np.stack(frames), or "
            "read a file by read_clip(path)",
        ),
        (
            {"frames": FRAMES, "background": "idle.png"},
            "the background of a Clip is a numpy array, found str; give an idle frame of the same "
            "size, or leave it out",
        ),
        (
            {"frames": FRAMES, "fps": "25"},
            "fps is a number, found str; give frames per second such as 25.0, or leave it out",
        ),
    ],
)
def test_what_is_no_array_and_no_number_is_refused_with_what_to_give(given, sentence):
    with pytest.raises(TypeError) as caught:
        Clip(**given)
    assert str(caught.value) == sentence


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


def test_every_frame_has_one_number():
    with pytest.raises(ValueError, match="5 frames have 2 numbers"):
        Clip(FRAMES, frame_numbers=(0, 1))
