"""Whether 224 x 224 frames were squashed cannot be seen; who reads them is told, and may say."""

import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.geometry import filled_size
from geotlm_lm.recordings.pixels import SQUASHED, UNSQUASHED
from geotlm_lm.recordings.read import read_clip


@pytest.fixture
def recording(tmp_path):
    """Return what writes a recording with an idle gel, of a size, and its path."""

    def write(rows, columns, **stated):
        rng = np.random.default_rng(0)
        frames = rng.integers(0, 255, (3, rows, columns, 3)).astype(np.uint8)
        np.savez(tmp_path / "clip.npz", frames=frames, background=frames[0], **stated)
        return frames, tmp_path / "clip.npz"

    return write


def test_a_square_of_224_pixels_is_taken_for_a_squashed_picture_and_that_is_said(recording):
    frames, path = recording(224, 224)
    clip = read_clip(path)
    assert np.array_equal(clip.frames, frames)
    assert filled_size(*clip.frames.shape[1:3]) == (224, 224)
    assert SQUASHED in clip.notes


def test_square_pixels_are_taken_as_they_are_where_the_user_says_so(recording):
    frames, path = recording(224, 224)
    clip = read_clip(path, square_pixels=True)
    # As every other square picture: three quarters of our square, idle gel beside it.
    assert filled_size(*clip.frames.shape[1:3]) == filled_size(256, 256) == (224, 168)
    assert np.array_equal(clip.frames, frames[:, :, :-1])
    assert np.array_equal(clip.background, frames[0, :, :-1])
    assert UNSQUASHED in clip.notes
    assert SQUASHED not in clip.notes


@pytest.mark.parametrize("size", [(240, 320), (256, 256), (320, 240)])
@pytest.mark.parametrize("is_square", [True, False])
def test_pictures_of_another_size_are_as_they_were(recording, size, is_square):
    frames, path = recording(*size)
    clip = read_clip(path, square_pixels=is_square)
    assert np.array_equal(clip.frames, frames)
    assert not {SQUASHED, UNSQUASHED} & set(clip.notes)


def test_what_a_file_states_of_its_pixels_is_not_assumed_and_the_user_knows_better(recording):
    _, path = recording(224, 224, square_pixels=False)
    assert not {SQUASHED, UNSQUASHED} & set(read_clip(path).notes)
    assert read_clip(path).frames.shape[1:3] == (224, 224)
    assert UNSQUASHED in read_clip(path, square_pixels=True).notes
    _, path = recording(224, 224, square_pixels=1)
    assert UNSQUASHED in read_clip(path).notes
    assert not {SQUASHED, UNSQUASHED} & set(read_clip(path, square_pixels=False).notes)


@pytest.mark.parametrize("stated", [np.array([True, False]), np.array("yes"), 1.5, 2, -1])
def test_a_shape_of_pixels_that_is_no_truth_value_is_refused_in_a_sentence(recording, stated):
    _, path = recording(224, 224, square_pixels=stated)
    value = np.asarray(stated)
    found = f"value {stated}" if isinstance(stated, int) else f"shape {value.shape}"
    with pytest.raises(UnreadableClip) as refused:
        read_clip(path)
    assert str(refused.value) == (
        f"{path}: 'square_pixels' has {found} and type {value.dtype}, expected one "
        f"truth value; save True or False or leave it out."
    )
