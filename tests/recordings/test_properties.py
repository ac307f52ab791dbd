"""Any array is a recording or is refused in one sentence; what is read is what was written."""

import io
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from geotlm_lm.answering.encoded import with_background
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.recordings.read import read_clip

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


@given(uint8_frames())
@drawn
def test_what_was_saved_is_what_is_read_in_either_layout_and_range(tmp_path, frames):
    for name, array in {
        "rows.npy": frames,
        "colours_first.npy": np.moveaxis(frames, -1, 1),
        "numbers.npy": frames.astype(np.float64),
    }.items():
        (tmp_path / name).write_bytes(stored(array))
    assert np.array_equal(read_clip(tmp_path / "rows.npy").frames, frames)
    layout = {"colours_first.npy": "TCHW", "numbers.npy": "THWC"}
    if frames.max() > 1:  # fewer levels are taken for a range of 0 to 1, as the note says
        assert all(
            np.array_equal(read_clip(tmp_path / name, layout=axes).frames, frames)
            for name, axes in layout.items()
        )


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
    import cv2

    from geotlm_lm.recordings import images

    code = bytearray(cv2.imencode(suffix, np.zeros((16, 16, 3), np.uint8))[1].tobytes())
    if suffix == ".jpg":
        at = code.index(b"\xff\xc0") + 5
        code[at : at + 4] = b"\xff\xff\xff\xff"
    else:
        at, order = (16, "big") if suffix == ".png" else (18, "little")
        code[at : at + 8] = (65535).to_bytes(4, order) * 2
    (tmp_path / f"idle{suffix}").write_bytes(code)
    monkeypatch.setattr(images.cv2, "imdecode", lambda *_: pytest.fail("it was decoded"))
    with pytest.raises(UnreadableClip) as caught:
        images.read_still_image(tmp_path / f"idle{suffix}")
    assert str(caught.value) == (
        f"{tmp_path}/idle{suffix}: frames are 65535x65535 pixels, expected at most 44 million; "
        f"export the recording at a smaller size."
    )
