"""Every way a file can fail to be a clip ends in one whole sentence, compared in full."""

import os

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.recordings.video import _decode
from tests.recordings.broken_files import CASES, FRAMES, header_of

IMAGES = ".png, .jpg, .jpeg, .bmp, .tif, .tiff, .webp"


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


def test_an_image_whose_chunk_claims_4_gb_is_refused_before_it_is_decoded(tmp_path, monkeypatch):
    code = bytearray(cv2.imencode(".png", FRAMES[0])[1].tobytes())
    code[33] = 0xFF
    for name in ("0.png", "1.png"):
        (tmp_path / name).write_bytes(code)
    monkeypatch.delattr(cv2, "imdecode")
    with pytest.raises(UnreadableClip, match="0.png: is cut off or is no image"):
        read_clip(tmp_path)


def test_a_missing_file_is_refused(tmp_path):
    path = tmp_path / "gone.npy"
    with pytest.raises(UnreadableClip) as caught:
        read_clip(path)
    assert str(caught.value) == f"{path}: no such file or folder; check the path."


@pytest.mark.parametrize(
    ("given", "wanted"), [({"path": ""}, "a recording's"), ({"background": ""}, "an image's")]
)
def test_an_empty_path_is_not_taken_for_the_current_folder(tmp_path, given, wanted):
    np.save(tmp_path / "clip.npy", FRAMES)
    with pytest.raises(UnreadableClip) as caught:
        read_clip(**{"path": tmp_path / "clip.npy"} | given)
    assert str(caught.value) == f"An empty path was given, expected {wanted}; give it."


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


@pytest.mark.parametrize(
    ("names", "held"),
    [
        ([], "no images"),
        (["README", "LICENCE", "setup"], "no images"),
        (["notes.txt"], "no images but 1 .txt file"),
        (["notes.txt", "1.gif", "2.GIF"], "no images but 2 .gif files"),
    ],
)
def test_a_folder_without_images_is_refused(tmp_path, names, held):
    for name in names:
        (tmp_path / name).write_text("no image")
    with pytest.raises(UnreadableClip) as caught:
        read_clip(tmp_path)
    assert str(caught.value) == (
        f"{tmp_path}: the folder holds {held}, expected {IMAGES}; "
        f"give the folder the frames lie in, or convert them."
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
        f"{tmp_path / '1.png'}: is cut off or is no image, expected {IMAGES}; "
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


@pytest.mark.parametrize("layout", ["THWC", "TCHW", "THW"])
@pytest.mark.parametrize("shape", [(), (4,), (2, 3, 4, 5, 3)])
def test_a_layout_of_another_number_of_axes_is_refused(tmp_path, layout, shape):
    path = tmp_path / "clip.npy"
    np.save(path, np.zeros(shape, np.uint8))
    with pytest.raises(UnreadableClip) as caught:
        read_clip(path, layout=layout)
    assert str(caught.value) == (
        f"{path}: shape {shape} is not of the layout {layout} with 1 or 3 colours; give the layout "
        f"the file has, or leave it out."
    )


def test_an_array_in_place_of_a_path_is_told_what_to_do():
    with pytest.raises(TypeError) as caught:
        read_clip(FRAMES)
    assert str(caught.value) == (
        "read_clip takes a path, found ndarray; make a clip of an array by Clip(frames)"
    )


def test_an_unknown_layout_is_a_wrong_call(tmp_path):
    with pytest.raises(UsageError) as caught:
        read_clip(tmp_path / "clip.npy", layout="HWC")
    assert str(caught.value) == (
        "The layout 'HWC' is unknown, expected one of THWC, TCHW, THW, or BGR, or both as in "
        "THWC-BGR; leave it out to have it guessed."
    )


def test_a_frame_rate_of_zero_is_a_wrong_call(tmp_path):
    with pytest.raises(UsageError) as caught:
        read_clip(tmp_path / "clip.npy", fps=0)
    assert str(caught.value) == (
        "A frame rate of 0 was given, expected more than 0 and less than 100000 per second; give "
        "the camera's, or leave it out."
    )


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

    def get(self, _):
        return 0.0


def test_a_video_that_changes_its_size_is_refused_in_one_sentence():
    with pytest.raises(UnreadableClip, match=r"frame 2 is 32 x 24 pixels after 64 x 48"):
        _decode(SizeChanges(), "clip.mkv")


def test_a_frame_rate_that_is_no_number_is_refused(tmp_path):
    with pytest.raises(TypeError, match="^fps is a number, found str; give frames per second such"):
        read_clip(tmp_path / "clip.npy", fps="25")
