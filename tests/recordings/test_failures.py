"""Every way a file can fail to be a clip ends in one whole sentence, compared in full."""

import io
import os
import zipfile

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.recordings.video import _decode

FRAMES = np.zeros((4, 16, 20, 3), np.uint8)


def npy(array, **save):
    stream = io.BytesIO()
    np.save(stream, array, **save)
    return stream.getvalue()


def npz(**arrays):
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    return stream.getvalue()


def header_of(shape, dtype="|u1"):
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        stream, {"shape": shape, "fortran_order": False, "descr": dtype}
    )
    return stream.getvalue()


def npy_with(header):
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode()


def locked(content, offset_here, offset_in_directory, value):
    """Return an archive with one byte of its member's two headers changed."""
    changed = bytearray(content)
    changed[offset_here] = value
    changed[changed.find(b"PK\x01\x02") + offset_in_directory] = value
    return bytes(changed)


def archive_with(name, content):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr(name, content)
    return stream.getvalue()


NAN = FRAMES.astype(np.float32)
NAN[2, 3, 4, 0] = np.nan
NUMPY = (
    "is cut off or is no numpy file, expected what numpy.save or numpy.savez writes; "
    "copy or record it again."
)
VIDEO = (
    "no frame of it can be decoded, expected a .mp4, .avi, .mov, .mkv video; "
    "copy or export it again."
)
CASES = {
    "object_array.npy": (
        npy(np.array([FRAMES, None], object), allow_pickle=True),
        "holds Python objects, which are never unpickled, expected uint8 frames (T,H,W,3); "
        "stack frames of one size and save those.",
    ),
    "nan.npy": (
        npy(NAN),
        "holds NaN or infinite values, expected numbers in 0..1 or 0..255; "
        "repair or leave out those frames.",
    ),
    "infinite.npy": (
        npy(np.full((4, 16, 20, 3), np.inf)),
        "holds NaN or infinite values, expected numbers in 0..1 or 0..255; "
        "repair or leave out those frames.",
    ),
    "empty.npy": (
        npy(np.zeros((0, 16, 20, 3), np.uint8)),
        "holds no pixels (shape (0, 16, 20, 3)); record or export it again.",
    ),
    "no_rank.npy": (
        npy(np.zeros((0,), np.uint8)),
        "found shape (0,), expected (T,H,W,3), (T,3,H,W) or, with --layout THW, (T,H,W); "
        "save the frames in one of them.",
    ),
    "one_frame.npy": (
        npy(FRAMES[:1]),
        "only 1 frame was found, motion needs 2 or more; give a recording, "
        "or several frames of it.",
    ),
    "one_image.npy": (
        npy(FRAMES[0]),
        "only 1 frame was found (shape (16, 20, 3)), motion needs 2 or more; "
        "stack frames to (T,H,W,3).",
    ),
    "grey.npy": (
        npy(FRAMES[..., 0]),
        "shape (4, 16, 20) has no colour axis, expected (T,H,W,3); "
        "if these are grey frames pass --layout THW.",
    ),
    "batch.npy": (
        npy(FRAMES[None]),
        "shape (1, 4, 16, 20, 3) looks like 1 clips, expected one of (T,H,W,3); "
        "save each clip to its own file.",
    ),
    "alpha.npy": (
        npy(np.zeros((4, 16, 20, 4), np.uint8)),
        "shape (4, 16, 20, 4) has no axis of 1 or 3 colours, expected (T,H,W,3) or (T,3,H,W); "
        "keep the colours red, green, blue only.",
    ),
    "deep.npy": (
        npy(np.full((4, 16, 20, 3), 1023, np.uint16)),
        "values run from 1023 to 1023, expected 0..1 or 0..255; scale or clip them first.",
    ),
    "negative.npy": (
        npy(np.full((4, 16, 20, 3), -1.0)),
        "values run from -1 to -1, expected 0..1 or 0..255; scale or clip them first.",
    ),
    "overshoot.npy": (
        npy(np.linspace(0, 1.02, FRAMES.size).reshape(FRAMES.shape)),
        "values run from 0 to 1.02, expected 0..1 or 0..255; scale or clip them first.",
    ),
    "text.npy": (
        npy(np.full((4, 16, 20, 3), "a")),
        "found values of type <U1, expected uint8 or floating point; save the frames as numbers.",
    ),
    "tiny.npy": (
        npy(np.zeros((4, 4, 5, 3), np.uint8)),
        "frames are 5x4 pixels, expected at least 8 per side; "
        "export the recording at its full size.",
    ),
    "truncated.npy": (
        npy(FRAMES)[:500],
        "is cut off, it has 500 bytes and its header declares 3968; copy or record it again.",
    ),
    "not_numpy.npy": (b"hello world", NUMPY),
    "header_of_another_kind.npy": (npy_with("{1: 2, 'a': 3}"), NUMPY),
    "header_half.npy": (npy_with("{'descr': '|u1', ((\n"), NUMPY),
    "header_deep.npy": (npy_with("-" * 9000 + "1"), NUMPY),
    "header_vast.npy": (header_of((10**400, 16, 20, 3)), NUMPY),
    "bomb.npy": (
        header_of((10**6, 10**4, 10**4, 3)),
        "declares 279397 GiB (shape (1000000, 10000, 10000, 3)), the limit is 16 GiB; "
        "cut the recording into parts.",
    ),
    "not_zip.npz": (b"hello world", NUMPY),
    "truncated.npz": (npz(frames=FRAMES)[:-30], NUMPY),
    "bomb.npz": (
        archive_with("frames.npy", header_of((3000, 1000, 1000, 3))),
        "'frames' unpacks to 8.4 GiB, the limit for .npz is 2 GiB; save it as .npy instead.",
    ),
    "encrypted.npz": (locked(archive_with("frames.npy", npy(FRAMES)), 6, 8, 1), NUMPY),
    "unknown_packing.npz": (locked(archive_with("frames.npy", npy(FRAMES)), 8, 10, 97), NUMPY),
    "half_member.npz": (archive_with("frames.npy", npy(FRAMES)[:500]), NUMPY),
    "pickle.npz": (
        npz(frames=np.array([FRAMES, None], object)),
        "holds Python objects, which are never unpickled, expected uint8 frames (T,H,W,3); "
        "stack frames of one size and save those.",
    ),
    "keys.npz": (
        npz(images=FRAMES, rate=25),
        "found the keys images, rate, expected 'frames' (and optionally 'fps', 'background'); "
        "save the frames under that key.",
    ),
    "fps.npz": (
        npz(frames=FRAMES, fps=np.zeros(3)),
        "'fps' has shape (3,) and type float64, expected one number; "
        "save frames per second or leave it out.",
    ),
    "size.npz": (
        npz(frames=FRAMES, background=np.zeros((20, 20, 3), np.uint8)),
        "the background has shape (20, 20, 3), the frames (16, 20, 3); "
        "give an idle frame of the same size.",
    ),
    "clip_as_background.npz": (
        npz(frames=FRAMES, background=FRAMES),
        "the background has shape (4, 16, 20, 3), expected one image (H,W,3); "
        "save a single idle frame.",
    ),
    "text.mov": (b"this is a text file, renamed", VIDEO),
    "zeros.mp4": (b"", "is empty (0 bytes); copy or record it again."),
    "rubbish.avi": (bytes(range(256)) * 8, VIDEO),
    "still.png": (
        cv2.imencode(".png", FRAMES[0])[1].tobytes(),
        "only 1 frame was found, motion needs 2 or more; give the folder it lies in.",
    ),
    "clip.tactile": (
        b"x",
        "files named '.tactile' are not known, expected .npy, .npz, .mp4, .avi, .mov, .mkv or a "
        "folder of images; export the recording as one of these.",
    ),
}


def write_cases(folder):
    for name, (content, _) in CASES.items():
        (folder / name).write_bytes(content)


@pytest.mark.parametrize("name", CASES)
def test_a_file_that_is_no_clip_is_refused_in_one_sentence(tmp_path, name):
    content, sentence = CASES[name]
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(UnreadableClip) as caught:
        read_clip(path)
    assert str(caught.value) == f"{path}: {sentence}"


def test_frames_too_large_to_hold_are_refused_before_they_are_read(tmp_path):
    path = tmp_path / "vast.npy"
    with path.open("wb") as stream:
        stream.write(header_of((2, 10_000, 10_000, 3)))
        stream.truncate(stream.tell() + 2 * 3 * 10**8)  # a hole: takes no room on the disk
    with pytest.raises(UnreadableClip) as caught:
        read_clip(path)
    assert str(caught.value) == (
        f"{path}: frames are 10000x10000 pixels, expected at most 44 million; "
        f"export the recording at a smaller size."
    )


def test_a_missing_file_is_refused(tmp_path):
    path = tmp_path / "gone.npy"
    with pytest.raises(UnreadableClip) as caught:
        read_clip(path)
    assert str(caught.value) == f"{path}: no such file or folder; check the path."


def test_a_name_no_file_system_holds_is_refused(tmp_path):
    path = tmp_path / ("a" * 300 + ".npy")
    with pytest.raises(UnreadableClip) as caught:
        read_clip(path)
    assert str(caught.value) == (
        f"{path}: cannot be opened (File name too long); check the path and its permissions."
    )


def test_a_pipe_is_refused_before_it_is_opened(tmp_path):
    path = tmp_path / "pipe.npy"
    os.mkfifo(path)
    with pytest.raises(UnreadableClip) as caught:
        read_clip(path)
    assert str(caught.value) == f"{path}: is not a regular file; give a recording."


def test_a_folder_without_images_is_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("no image")
    with pytest.raises(UnreadableClip) as caught:
        read_clip(tmp_path)
    assert str(caught.value) == (
        f"{tmp_path}: the folder holds no images, expected .png, .jpg, .jpeg, .bmp; "
        f"give the folder the frames lie in."
    )


def test_a_folder_with_images_of_two_sizes_is_refused(tmp_path):
    cv2.imwrite(str(tmp_path / "1.png"), FRAMES[0])
    cv2.imwrite(str(tmp_path / "2.png"), FRAMES[0][:, :10])
    with pytest.raises(UnreadableClip) as caught:
        read_clip(tmp_path)
    assert str(caught.value) == (
        f"{tmp_path / '2.png'}: is 10x16 pixels, 1.png is 20x16; "
        f"keep frames of one recording in the folder."
    )


def test_a_folder_with_a_damaged_image_is_refused(tmp_path):
    (tmp_path / "1.png").write_bytes(b"not an image")
    with pytest.raises(UnreadableClip) as caught:
        read_clip(tmp_path)
    assert str(caught.value) == (
        f"{tmp_path / '1.png'}: is cut off or is no image, expected .png, .jpg, .jpeg, .bmp; "
        f"copy or record it again."
    )


def test_a_layout_that_does_not_fit_the_shape_is_refused(tmp_path):
    path = tmp_path / "clip.npy"
    np.save(path, FRAMES)
    with pytest.raises(UnreadableClip) as caught:
        read_clip(path, layout="TCHW")
    assert str(caught.value) == (
        f"{path}: shape (4, 16, 20, 3) is not of the layout TCHW with 1 or 3 colours; "
        f"give the layout the file has, or leave it out."
    )


def test_an_unknown_layout_is_a_wrong_call(tmp_path):
    with pytest.raises(UsageError) as caught:
        read_clip(tmp_path / "clip.npy", layout="HWC")
    assert str(caught.value) == (
        "The layout 'HWC' is unknown, expected one of THWC, TCHW, THW; "
        "leave it out to have it guessed."
    )


def test_a_frame_rate_of_zero_is_a_wrong_call(tmp_path):
    with pytest.raises(UsageError) as caught:
        read_clip(tmp_path / "clip.npy", fps=0)
    assert str(caught.value) == "A frame rate of 0 was given, expected 0 to 100000 per second."


def test_a_background_of_another_size_is_refused(tmp_path):
    np.save(tmp_path / "clip.npy", FRAMES)
    np.save(tmp_path / "idle.npy", np.zeros((9, 9, 3), np.uint8))
    with pytest.raises(UnreadableClip, match="the background has shape"):
        read_clip(tmp_path / "clip.npy", background=tmp_path / "idle.npy")


class SizeChanges:
    """A video whose picture shrinks from the third frame on."""

    def __init__(self):
        self.seen = 0

    def grab(self):
        self.seen += 1
        return self.seen <= 4

    def retrieve(self):
        return True, np.zeros((48, 64, 3) if self.seen < 3 else (24, 32, 3), np.uint8)


def test_a_video_that_changes_its_size_is_refused_in_one_sentence():
    with pytest.raises(UnreadableClip, match=r"frame 2 is 32 x 24 pixels after 64 x 48"):
        _decode(SizeChanges(), "clip.mkv")
