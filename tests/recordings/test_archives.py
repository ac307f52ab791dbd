"""Which array of an archive is taken for the frames."""

import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.recordings.read import read_clip
from tests.recordings.test_read import FRAMES


@pytest.mark.parametrize("beside", [{}, {"fps": 25.0, "background": FRAMES[0]}])
def test_the_only_array_of_an_archive_is_taken_for_the_frames(tmp_path, beside):
    np.savez(tmp_path / "clip.npz", FRAMES, **beside)
    clip = read_clip(tmp_path / "clip.npz")
    np.testing.assert_array_equal(clip.frames, FRAMES)
    assert clip.fps == beside.get("fps")
    assert "The array 'arr_0' was taken for the frames." in clip.notes


@pytest.mark.parametrize(
    ("name", "frames", "beside"),
    [
        ("rgb", FRAMES, {"depth": FRAMES[..., 0]}),
        ("images", FRAMES, {"timestamps": np.arange(len(FRAMES)), "pose": np.eye(4)}),
        ("grey", FRAMES[..., 0], {"a_name": np.array("left"), "force": np.ones((len(FRAMES), 3))}),
        ("video", FRAMES.transpose(0, 3, 1, 2), {"notes": np.array(["a", None], object)}),
    ],
)
def test_of_several_arrays_the_only_one_shaped_as_pictures_is_taken(tmp_path, name, frames, beside):
    np.savez(tmp_path / "clip.npz", **{name: frames}, **beside)
    clip = read_clip(tmp_path / "clip.npz", layout="THW" if frames.ndim == 3 else None)
    expected = FRAMES if frames.ndim == 4 else np.repeat(FRAMES[..., :1], 3, axis=-1)
    np.testing.assert_array_equal(clip.frames, expected)
    assert f"The array '{name}' was taken for the frames." in clip.notes


@pytest.mark.parametrize("beside", [FRAMES[:3], FRAMES[::-1]])
def test_of_two_arrays_shaped_as_pictures_neither_is_taken(tmp_path, beside):
    np.savez(tmp_path / "clip.npz", left=FRAMES, right=beside, names=np.array("ab"))
    with pytest.raises(UnreadableClip, match="found the keys left, names, right, expected"):
        read_clip(tmp_path / "clip.npz")
