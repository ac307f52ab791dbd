"""Which array of an archive is taken for the frames, and what of it is refused unread."""

import io
import zipfile

import cv2
import numpy as np
import pytest

from geotlm_lm.recordings.read import declared_bytes, read_clip
from tests.recordings.test_read import FRAMES, refusal, write_images, write_video


@pytest.mark.parametrize(
    ("name", "frames", "beside"),
    [
        ("arr_0", FRAMES, {"fps": 25.0, "background": FRAMES[0]}),
        ("rgb", FRAMES, {"depth": FRAMES[..., 0]}),
        ("images", FRAMES, {"timestamps": np.arange(len(FRAMES)), "pose": np.eye(4)}),
        ("grey", FRAMES[..., 0], {"a_name": np.array("left"), "force": np.ones((len(FRAMES), 3))}),
        ("video", FRAMES.transpose(0, 3, 1, 2), {"notes": np.array(["a", None], object)}),
    ],
)
def test_the_only_array_shaped_as_pictures_is_taken_for_the_frames(tmp_path, name, frames, beside):
    np.savez(tmp_path / "clip.npz", **{name: frames}, **beside)
    clip = read_clip(tmp_path / "clip.npz", layout="THW" if frames.ndim == 3 else None)
    expected = FRAMES if frames.ndim == 4 else np.repeat(FRAMES[..., :1], 3, axis=-1)
    np.testing.assert_array_equal(clip.frames, expected)
    assert f"The array '{name}' was taken for the frames." in clip.notes
    assert clip.fps == beside.get("fps")
    assert np.array_equal(clip.background, beside.get("background"))


def stored(path, arrays, compression=zipfile.ZIP_DEFLATED):
    """Write an archive whose arrays are declared by shape and type, with as many zeros as given."""
    with zipfile.ZipFile(path, "w", compression) as archive:
        for key, (shape, kind, count) in arrays.items():
            header = io.BytesIO()
            about = {"descr": kind, "fortran_order": False, "shape": shape}
            np.lib.format.write_array_header_1_0(header, about)
            archive.writestr(f"{key}.npy", header.getvalue() + bytes(count))


SHORT = ((6, 48, 64, 3), "|u1", 6 * 48 * 64 * 3)
LONG = ((400, 240, 320, 3), "|u1", 400 * 240 * 320 * 3)


@pytest.mark.parametrize(
    ("arrays", "sentence"),
    [
        ({"frames": LONG}, "'frames' unpacks to 87 MiB, "),
        ({"frames": (LONG[0], "|u1", 9)}, "is cut off or is no numpy file"),
        ({"frames": ((400, 240, 320), "|u1", 400 * 240 * 320)}, "shape (400, 240, 320) has no "),
        ({"frames": (SHORT[0], "|S1", SHORT[2])}, "found values of type |S1, "),
        ({"frames": SHORT, "background": LONG}, "'background' unpacks to "),
        ({"frames": SHORT, "fps": (LONG[0], "<f4", 9)}, "is cut off or is no numpy file"),
        ({f"a{k}": SHORT for k in range(200)}, "found the keys a0, "),
    ],
    ids=["black", "cut", "shape", "type", "background", "fps", "many"],
)
def test_what_is_refused_by_what_it_declares_is_never_unpacked(
    tmp_path, monkeypatch, arrays, sentence
):
    stored(tmp_path / "clip.npz", arrays)
    monkeypatch.setattr(np.lib.format, "read_array", lambda *_, **__: pytest.fail("was unpacked"))
    assert refusal(tmp_path / "clip.npz").startswith(sentence)


def test_what_a_recording_takes_is_known_before_it_is_read(tmp_path):
    frames = np.random.default_rng(0).integers(60, 99, (5, 24, 32, 3)).astype(np.uint8)
    np.save(tmp_path / "clip.npy", frames)
    np.savez_compressed(tmp_path / "clip.npz", frames=frames / np.float64(255))
    (tmp_path / "images").mkdir()
    write_images(tmp_path / "images", frames)
    cv2.imwritemulti(str(tmp_path / "clip.tif"), list(frames))
    write_video(tmp_path / "clip.avi", frames)
    for name in ("clip.npy", "images", "clip.tif", "clip.avi"):
        assert declared_bytes(tmp_path / name) == frames.nbytes
    assert 2 * declared_bytes(tmp_path / "clip.npz") == frames.nbytes * (8 + 1)
    (tmp_path / "text.npy").write_text("no array")
    assert declared_bytes(tmp_path / "text.npy") == declared_bytes(tmp_path / "none.avi") == 0
