"""Pages of a TIFF come back as frames, and what is no recording is refused in a sentence."""

import struct

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.recordings import images, policy
from geotlm_lm.recordings.images import read_still_image
from geotlm_lm.recordings.listing import clips_in, skipped_in
from geotlm_lm.recordings.read import read_clip
from tests.recordings.test_read import colourful

FRAMES = colourful()


def write_stack(path, frames):
    assert cv2.imwritemulti(str(path), [np.ascontiguousarray(one[..., ::-1]) for one in frames])
    return path


@pytest.mark.parametrize("name", ["clip.tif", "clip.TIFF", "Aufnahme \u00fc 1.tiff"])
def test_its_pages_are_frames_in_rgb(tmp_path, name):
    clip = read_clip(write_stack(tmp_path / name, FRAMES))
    assert np.array_equal(clip.frames, FRAMES)
    assert clip.frame_numbers == tuple(range(len(FRAMES)))
    assert clip.notes[0] == "5 pages were read as frames."


def test_more_pages_than_are_decoded_at_once_are_all_read(tmp_path):
    frames = colourful(count=2 * images.PAGES_AT_ONCE + 3)
    assert np.array_equal(read_clip(write_stack(tmp_path / "a.tif", frames)).frames, frames)


@pytest.mark.parametrize("count", [20, 75])
def test_a_long_one_is_read_at_a_stride_and_says_so(tmp_path, monkeypatch, count):
    monkeypatch.setattr(policy, "KEPT_BYTES", 6 * FRAMES[0].nbytes)
    frames = colourful(count=count)
    clip = read_clip(write_stack(tmp_path / "a.tif", frames))
    stride = -(-count // 6)
    assert clip.frame_numbers == tuple(range(0, count, stride))
    assert np.array_equal(clip.frames, frames[::stride])
    assert clip.notes[-1] == (
        f"Of {count} frames one in {stride} was read to bound memory; cut the recording to see all "
        f"of them."
    )


def test_grey_pages_are_read_as_grey(tmp_path):
    cv2.imwritemulti(str(tmp_path / "a.tif"), [*FRAMES[..., 0]])
    assert np.array_equal(read_clip(tmp_path / "a.tif").frames, FRAMES[..., :1].repeat(3, axis=-1))


def test_16_bits_are_brought_down_to_8_where_their_range_is_used(tmp_path):
    write_stack(tmp_path / "a.tif", FRAMES.astype(np.uint16) * 257)
    assert np.array_equal(read_clip(tmp_path / "a.tif").frames, FRAMES)
    cv2.imwrite(str(tmp_path / "a.png"), FRAMES[0][..., ::-1].astype(np.uint16) * 257)
    assert np.array_equal(read_still_image(tmp_path / "a.png"), FRAMES[0])


LOW = (
    "holds 16-bit values up to {}, expected 8 bits, or 16 that are used up to 65535; scale the "
    "frames to 0..255 and save them in 8 bits."
)
REAL = (
    "holds values of type float32, expected 8 or 16 bits; scale the frames to 0..255 and save them "
    "in 8 bits."
)


@pytest.mark.parametrize(
    ("name", "values", "held"),
    [("a.png", FRAMES.astype(np.uint16) * 16, LOW), ("a.tif", FRAMES / np.float32(255), REAL)],
)
def test_other_ranges_are_refused_whether_one_page_or_more(tmp_path, name, values, held):
    cv2.imwrite(str(tmp_path / name), values[0][..., ::-1])
    with pytest.raises(UnreadableClip) as caught:
        read_still_image(tmp_path / name)
    assert str(caught.value) == f"{tmp_path / name}: {held.format(values[0].max())}"
    write_stack(tmp_path / "b.tif", values)
    with pytest.raises(UnreadableClip) as caught:
        read_clip(tmp_path / "b.tif")
    assert str(caught.value) == f"{tmp_path / 'b.tif'}: {held.format(values.max())}"


def test_one_page_is_one_frame(tmp_path):
    cv2.imwrite(str(tmp_path / "a.tif"), FRAMES[0])
    with pytest.raises(UnreadableClip) as caught:
        read_clip(tmp_path / "a.tif")
    assert str(caught.value) == (
        f"{tmp_path / 'a.tif'}: only 1 frame was found, motion needs 2 or more; give the folder it "
        f"lies in."
    )


def test_pages_of_two_sizes_are_refused(tmp_path):
    cv2.imwritemulti(str(tmp_path / "a.tif"), [FRAMES[0], FRAMES[1], FRAMES[2][:, :10].copy()])
    with pytest.raises(UnreadableClip) as caught:
        read_clip(tmp_path / "a.tif")
    assert str(caught.value) == (
        f"{tmp_path / 'a.tif'}: page 3 is 10x24 pixels, page 1 is 32x24; keep frames of one "
        f"recording in the file."
    )


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.99])
def test_one_that_is_cut_off_is_refused_and_nothing_is_printed(tmp_path, capfd, share):
    whole = write_stack(tmp_path / "a.tif", FRAMES).read_bytes()
    (tmp_path / "a.tif").write_bytes(whole[: int(share * len(whole))] or b"II*")
    with pytest.raises(UnreadableClip) as caught:
        read_clip(tmp_path / "a.tif")
    assert str(caught.value) == (
        f"{tmp_path / 'a.tif'}: is cut off or is no TIFF of whole pages; copy or record it again."
    )
    assert capfd.readouterr() == ("", "")


def test_vast_pages_are_refused_before_they_are_decoded(tmp_path, monkeypatch):
    monkeypatch.setattr(policy, "KEPT_BYTES", 2 * FRAMES[0].nbytes)
    monkeypatch.setattr(images.cv2, "imreadmulti", lambda *_, **__: pytest.fail("it was decoded"))
    with pytest.raises(UnreadableClip, match="frames are 32x24 pixels, expected at most 0 million"):
        read_clip(write_stack(tmp_path / "a.tif", FRAMES))


def test_a_tag_that_points_outside_the_file_is_refused_and_nothing_is_printed(tmp_path, capfd):
    stored = bytearray(write_stack(tmp_path / "a.tif", FRAMES).read_bytes())
    at = int.from_bytes(stored[4:8], "little") + 2  # the first entry of the first directory
    stored[at : at + 12] = struct.pack("<HHII", 254, 2, 2**31, 2**31)
    (tmp_path / "a.tif").write_bytes(stored)
    with pytest.raises(UnreadableClip, match="is cut off or is no TIFF of whole pages"):
        read_clip(tmp_path / "a.tif")
    assert capfd.readouterr() == ("", "")


def test_in_a_folder_of_recordings_it_is_one_and_a_single_page_is_not(tmp_path):
    write_stack(tmp_path / "b.tif", FRAMES)
    cv2.imwrite(str(tmp_path / "a.tif"), FRAMES[0])
    assert [one.name for one in clips_in(tmp_path)] == ["b.tif"]
    assert [one.name for one in skipped_in(tmp_path)] == ["a.tif"]


def test_among_single_images_it_is_told_to_be_a_recording(tmp_path):
    write_stack(tmp_path / "1.tif", FRAMES)
    cv2.imwrite(str(tmp_path / "0.tif"), FRAMES[0])
    with pytest.raises(UnreadableClip) as caught:
        read_clip(tmp_path)
    assert str(caught.value) == (
        f"{tmp_path / '1.tif'}: holds several pages, expected one image; give the file as the "
        f"recording that it is, or save one page."
    )


def test_an_image_that_cannot_be_opened_is_told_why(tmp_path):
    with pytest.raises(UnreadableClip) as caught:
        read_still_image(tmp_path / "gone.png")
    assert str(caught.value) == (
        f"{tmp_path / 'gone.png'}: cannot be opened (No such file or directory); check the path "
        f"and its permissions."
    )
