"""Every way a file can fail to be a clip ends in one whole sentence, compared in full."""

import io
import os
import zipfile

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.recordings.read import read_clip
from tests.recordings.test_read import refusal

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
    "no frame of it can be decoded, expected a .mp4, .m4v, .avi, .mov, .mkv, .webm, .gif "
    "video; copy or export it again."
)
UNKNOWN = (
    "are not known, expected .npy, .npz, .mp4, .m4v, .avi, .mov, .mkv, .webm, .gif, .tif, .tiff, "
    ".mcap, .db3, .bag or a folder of images; export the recording as one of these."
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
        "shape (1, 4, 16, 20, 3) looks like 1 clip with an axis too many, expected one of "
        "(T,H,W,3); save frames[0].",
    ),
    "batch_of_two.npy": (
        npy(np.stack([FRAMES, FRAMES])),
        "shape (2, 4, 16, 20, 3) looks like 2 clips, expected one of (T,H,W,3); "
        "save each clip to its own file.",
    ),
    "colours_first.npy": (
        npy(np.moveaxis(FRAMES, -1, 0)),
        "shape (3, 4, 16, 20) has its 3 colours first, expected them last or second, (T,H,W,3) or "
        "(T,3,H,W); move them by np.moveaxis(frames, 0, -1).",
    ),
    "five_channels.npy": (
        npy(np.zeros((3, 16, 20, 5), np.uint8)),
        "shape (3, 16, 20, 5) has no axis of 1 or 3 colours, expected (T,H,W,3) or (T,3,H,W); "
        "keep the colours red, green, blue only.",
    ),
    "deep.npy": (
        npy(np.full((4, 16, 20, 3), 1023, np.uint16)),
        "holds 16-bit values up to 1023, expected 8 bits, or 16 that are used up to 65535; scale "
        "the frames to 0..255 and save them in 8 bits.",
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
    "keys.npz": (
        npz(left=FRAMES, right=FRAMES),
        "found the keys left, right, expected 'frames' (and optionally 'fps', 'background', "
        "'square_pixels'); save the frames under that key.",
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
    "header_only.gif": (b"GIF89a\x20\0\x18\0\0\0\0", VIDEO),
    "vast.gif": (
        b"GIF89a\xff\xff\xff\xff\0\0\0,\0\0\0\0\xff\xff\xff\xff\0\2\2\x44\1\0;",
        "frames are 65535x65535 pixels, expected at most 44 million; export the recording at a "
        "smaller size.",
    ),
    "still.png": (
        cv2.imencode(".png", FRAMES[0])[1].tobytes(),
        "only 1 frame was found, motion needs 2 or more; give the folder it lies in.",
    ),
    "clip": (
        b"x",
        f"files without an ending {UNKNOWN}",
    ),
    "clip.tactile": (
        b"x",
        f"files named '.tactile' {UNKNOWN}",
    ),
}

IMAGES = ".png, .jpg, .jpeg, .bmp, .tif, .tiff, .webp"


@pytest.mark.parametrize("name", CASES)
def test_a_file_that_is_no_clip_is_refused_in_one_sentence(tmp_path, name):
    content, sentence = CASES[name]
    (tmp_path / name).write_bytes(content)
    assert refusal(tmp_path / name) == sentence


def test_frames_too_large_to_hold_are_refused_before_they_are_read(tmp_path):
    path = tmp_path / "vast.npy"
    with path.open("wb") as stream:
        stream.write(header_of((2, 10_000, 10_000, 3)))
        stream.truncate(stream.tell() + 2 * 3 * 10**8)  # a hole: takes no room on the disk
    assert refusal(path) == (
        "frames are 10000x10000 pixels, expected at most 44 million; export the recording at a "
        "smaller size."
    )


def test_an_image_whose_chunk_claims_4_gb_is_refused_before_it_is_decoded(tmp_path, monkeypatch):
    code = bytearray(cv2.imencode(".png", FRAMES[0])[1].tobytes())
    code[33] = 0xFF
    for name in ("0.png", "1.png"):
        (tmp_path / name).write_bytes(code)
    monkeypatch.delattr(cv2, "imdecode")
    with pytest.raises(UnreadableClip, match="0.png: is cut off or is no image"):
        read_clip(tmp_path)


def as_it_is(path):
    """A name that nothing has."""


def with_images_of_two_sizes(folder):
    folder.mkdir()
    cv2.imwrite(str(folder / "1.png"), FRAMES[0])
    cv2.imwrite(str(folder / "2.png"), FRAMES[0][:, :10])


def with_a_damaged_image(folder):
    folder.mkdir()
    (folder / "1.png").write_bytes(b"not an image")


LONG = "a" * 300 + ".npy"
MADE = {
    "gone.npy": (as_it_is, "", "no such file or folder; check the path."),
    LONG: (
        as_it_is,
        "",
        "cannot be opened (File name too long); check the path and its permissions.",
    ),
    "pipe.npy": (os.mkfifo, "", "is not a regular file; give a recording."),
    "sizes": (
        with_images_of_two_sizes,
        "/2.png",
        "is 10x16 pixels, 1.png is 20x16; keep frames of one recording in the folder.",
    ),
    "damaged": (
        with_a_damaged_image,
        "/1.png",
        f"is cut off or is no image, expected {IMAGES}; copy or record it again.",
    ),
}


@pytest.mark.parametrize("name", MADE, ids=lambda name: name[:9])
def test_what_is_no_recording_is_told_by_its_name(tmp_path, name):
    make, inside, sentence = MADE[name]
    make(tmp_path / name)
    with pytest.raises(UnreadableClip) as caught:
        read_clip(tmp_path / name)
    assert str(caught.value) == f"{tmp_path / name}{inside}: {sentence}"


@pytest.mark.parametrize(
    ("given", "wanted"), [({"path": ""}, "a recording's"), ({"background": ""}, "an image's")]
)
def test_an_empty_path_is_not_taken_for_the_current_folder(tmp_path, given, wanted):
    np.save(tmp_path / "clip.npy", FRAMES)
    with pytest.raises(UnreadableClip) as caught:
        read_clip(**{"path": tmp_path / "clip.npy"} | given)
    assert str(caught.value) == f"An empty path was given, expected {wanted}; give it."


@pytest.mark.parametrize(
    ("names", "held"),
    [
        ([], "no images"),
        (["README"], "no images"),
        (["notes.txt", "1.gif", "2.GIF"], "no images but 2 .gif files"),
    ],
)
def test_a_folder_without_images_is_refused(tmp_path, names, held):
    for name in names:
        (tmp_path / name).write_text("no image")
    assert refusal(tmp_path) == (
        f"the folder holds {held}, expected {IMAGES}; "
        f"give the folder the frames lie in, or convert them."
    )


@pytest.mark.parametrize("layout", ["THWC", "TCHW", "THW"])
@pytest.mark.parametrize("shape", [(), (4,), (2, 3, 4, 5, 3)])
def test_a_layout_of_another_number_of_axes_is_refused(tmp_path, layout, shape):
    path = tmp_path / "clip.npy"
    np.save(path, np.zeros(shape, np.uint8))
    assert refusal(path, layout=layout) == (
        f"shape {shape} is not of the layout {layout} with 1, 3 or 4 channels; give the "
        f"layout the file has, or leave it out."
    )


@pytest.mark.parametrize(
    ("given", "error", "sentence"),
    [
        (
            {"path": FRAMES},
            TypeError,
            "read_clip takes a path, found ndarray; make a clip of an array by Clip(frames)",
        ),
        (
            {"background": FRAMES[0]},
            TypeError,
            "the background is a path, found ndarray; give an image in memory by "
            "dataclasses.replace(clip, background=image)",
        ),
        ({"layout": 3}, TypeError, "a layout is a str such as 'THWC', found int"),
        (
            {"layout": "HWC"},
            UsageError,
            "The layout 'HWC' is unknown; did you mean 'THWC'?",
        ),
        (
            {"fps": "25"},
            TypeError,
            "fps is a number, found str; give frames per second such as 25.0, or leave it out",
        ),
        (
            {"fps": 0},
            UsageError,
            "A frame rate of 0 was given, expected more than 0 and less than 100000 per second; "
            "give the camera's, or leave it out.",
        ),
    ],
)
def test_a_wrong_argument_is_told_with_what_to_give(tmp_path, given, error, sentence):
    np.save(tmp_path / "clip.npy", FRAMES)
    with pytest.raises(error) as caught:
        read_clip(**{"path": tmp_path / "clip.npy"} | given)
    assert str(caught.value) == sentence
