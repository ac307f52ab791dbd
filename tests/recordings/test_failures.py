"""Every way a file can fail to be a clip ends in one whole sentence, compared in full."""

import os

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.recordings.read import read_clip
from tests.recordings.broken_files import CASES, FRAMES, header_of
from tests.recordings.test_read import refusal

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
            "The layout 'HWC' is unknown, expected one of THWC, TCHW, THW, or BGR, or both as in "
            "THWC-BGR; leave it out to have it guessed.",
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
