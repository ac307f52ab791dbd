"""Arrays of any form come back as pixels or are refused; square pixels; damaged pictures."""

import io
from contextlib import suppress

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from geotlm_lm.answering.encoded import with_background
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.geometry import filled_size
from geotlm_lm.recordings import images
from geotlm_lm.recordings.pixels import SQUASHED, UNSQUASHED, drifted, faded, jpeg
from geotlm_lm.recordings.read import read_clip
from tests.recordings.test_read import refusal

drawn = settings(
    derandomize=True,
    max_examples=60,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)

ANY_TYPE = st.one_of(
    arrays.scalar_dtypes(), arrays.unicode_string_dtypes(), arrays.array_dtypes(max_size=2)
)
SIDES = st.tuples(st.integers(2, 7), st.integers(8, 20), st.integers(8, 20))


def uint8_frames(shape=SIDES):
    return shape.flatmap(lambda sides: arrays.arrays(np.uint8, (*sides, 3)))


def stored(array):
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def read_or_refused(path):
    """Anything else that the reader raises fails the test."""
    with suppress(UnreadableClip):
        clip = read_clip(path)
        assert clip.frames.dtype == np.uint8
        assert len(clip) >= 2


@given(ANY_TYPE.flatmap(lambda kind: arrays.arrays(kind, arrays.array_shapes(max_dims=6))))
@drawn
def test_any_array_is_read_or_refused(tmp_path, array):
    (tmp_path / "clip.npy").write_bytes(stored(array))
    read_or_refused(tmp_path / "clip.npy")


@given(uint8_frames(), st.binary(min_size=1, max_size=30), st.floats(0, 1))
@drawn
def test_a_file_with_bytes_written_over_it_is_read_or_refused(tmp_path, frames, junk, where):
    damaged = bytearray(stored(frames))
    at = int(where * len(damaged))
    damaged[at : at + len(junk)] = junk
    (tmp_path / "clip.npy").write_bytes(damaged)
    read_or_refused(tmp_path / "clip.npy")


@given(uint8_frames(st.tuples(st.integers(2, 6), st.integers(8, 40), st.integers(8, 40))))
@drawn
def test_a_background_of_the_frames_size_is_guessed_for_any_recording(frames):
    assert with_background(Clip(frames)).background.shape == frames.shape[1:]


@pytest.mark.parametrize("suffix", [".png", ".bmp", ".jpg"])
def test_an_image_too_large_to_hold_is_refused_before_it_is_decoded(tmp_path, monkeypatch, suffix):
    code = bytearray(cv2.imencode(suffix, np.zeros((16, 16, 3), np.uint8))[1].tobytes())
    if suffix == ".jpg":
        at = code.index(b"\xff\xc0") + 5
        code[at : at + 4] = b"\xff\xff\xff\xff"
    else:
        at, order = (16, "big") if suffix == ".png" else (18, "little")
        code[at : at + 8] = (65535).to_bytes(4, order) * 2
    (tmp_path / f"idle{suffix}").write_bytes(code)
    monkeypatch.setattr(images.cv2, "imdecode", lambda *_: pytest.fail("it was decoded"))
    assert refusal(tmp_path / f"idle{suffix}", images.read_still_image) == (
        "frames are 65535x65535 pixels, expected at most 44 million; export the recording at a "
        "smaller size."
    )


@pytest.fixture
def recording(tmp_path):
    """Return what writes a recording with an idle gel, of a size, and its path."""

    def write(rows, columns, **stated):
        rng = np.random.default_rng(0)
        frames = rng.integers(0, 255, (3, rows, columns, 3)).astype(np.uint8)
        np.savez(tmp_path / "clip.npz", frames=frames, background=frames[0], **stated)
        return frames, tmp_path / "clip.npz"

    return write


def test_a_square_of_224_pixels_is_taken_for_squashed_unless_the_user_says_that_it_is_not(
    recording,
):
    frames, path = recording(224, 224)
    assumed = read_clip(path)
    assert np.array_equal(assumed.frames, frames)
    assert SQUASHED in assumed.notes
    clip = read_clip(path, square_pixels=True)
    # As every other square picture: three quarters of our square, idle gel beside it.
    assert filled_size(*clip.frames.shape[1:3]) == filled_size(256, 256)
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
    assert refusal(path) == (
        f"'square_pixels' has {found} and type {value.dtype}, expected one truth value; save True "
        "or False or leave it out."
    )


NOISE = np.random.default_rng(0).integers(0, 256, (64, 64, 3)).astype(np.uint8)


def test_jpeg_loses_more_at_a_lower_quality():
    losses = [np.abs(jpeg(q, NOISE).astype(int) - NOISE).mean() for q in (95, 50, 10)]
    assert losses[0] < losses[1] < losses[2]


@pytest.mark.parametrize(("grey", "gain", "last"), [(10.0, 0.0, 110), (0.0, 0.2, 120)])
def test_a_drift_grows_from_the_first_frame_to_the_last(grey, gain, last):
    frames = np.full((3, 4, 4, 3), 100, np.uint8)
    levels = drifted(grey, gain, frames)[:, 0, 0, 0].tolist()
    assert levels == [100, (100 + last) // 2, last]


def test_a_faded_touch_differs_by_its_share_from_the_idle_gel():
    idle = np.full((4, 4, 3), 100, np.uint8)
    frames = np.stack([idle, idle + 40])
    assert faded(0.25, frames, idle)[:, 0, 0, 0].tolist() == [100, 110]
