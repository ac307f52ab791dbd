"""Folders, pages and stills: frames in the order of names or pages, or one sentence."""

import struct

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.doctor.examine import missing_frames
from geotlm_lm.recordings import images, policy
from geotlm_lm.recordings.frame_order import frame_order, natural_order
from geotlm_lm.recordings.images import read_still_image
from geotlm_lm.recordings.read import clips_in, read_clip, skipped_in
from geotlm_lm.recordings.streams import open_source
from tests.recordings.test_read import colourful, refusal, write_images

FRAMES = colourful(count=6)


@pytest.mark.parametrize("suffix", [".bmp", ".tif", ".tiff", ".webp", ".WEBP"])
def test_images_of_every_lossless_kind_come_back_as_they_were(tmp_path, suffix):
    lossless = [cv2.IMWRITE_WEBP_QUALITY, 101] if suffix.lower() == ".webp" else []
    write_images(tmp_path, FRAMES, f"{{}}{suffix}", lossless)
    assert np.array_equal(read_clip(tmp_path).frames, FRAMES)


def test_the_idle_gel_masks_and_hidden_copies_are_told_from_the_frames_of_a_folder(tmp_path):
    write_images(tmp_path, FRAMES, "frame_{}.png")
    write_images(tmp_path, 255 - FRAMES, "mask_{}.png")
    write_images(tmp_path, FRAMES[2:3], ["Background.png"])
    (tmp_path / "._0.png").write_bytes(b"what a Mac leaves behind")
    (tmp_path / "more.png").mkdir()
    clip = read_clip(tmp_path)
    assert np.array_equal(clip.frames, FRAMES)
    assert np.array_equal(clip.background, FRAMES[2])
    assert clip.notes == (
        "6 images were read in natural order of their names.",
        "6 images named as masks (mask_0.png) were left out.",
        "Background: Background.png of the folder was taken for the idle gel.",
    )


@pytest.mark.parametrize("name", ["mask_{}.png", "masking{}.png"])
def test_images_without_others_beside_them_are_frames_whatever_their_name(tmp_path, name):
    write_images(tmp_path, FRAMES, name)
    assert np.array_equal(read_clip(tmp_path).frames, FRAMES)


def write_stack(path, frames):
    assert cv2.imwritemulti(str(path), [np.ascontiguousarray(page[..., ::-1]) for page in frames])
    return path


def test_pages_are_frames_in_rgb_at_a_stride_where_they_do_not_fit(tmp_path, monkeypatch):
    count = 2 * images.PAGES_AT_ONCE + 3
    frames = colourful(count=count)
    clip = read_clip(write_stack(tmp_path / "Aufnahme \u00fc 1.TIFF", frames))
    assert np.array_equal(clip.frames, frames)
    assert clip.frame_numbers == tuple(range(count))
    assert clip.notes[0] == f"{count} pages were read as frames."
    cv2.imwritemulti(str(tmp_path / "grey.tif"), [*frames[..., 0]])
    grey = read_clip(tmp_path / "grey.tif").frames
    assert np.array_equal(grey, frames[..., :1].repeat(3, axis=-1))
    monkeypatch.setattr(policy, "KEPT_BYTES", 6 * FRAMES[0].nbytes)
    strided = read_clip(tmp_path / "Aufnahme \u00fc 1.TIFF")
    assert strided.frame_numbers == tuple(range(0, count, 12))
    assert np.array_equal(strided.frames, frames[::12])


def test_16_bits_are_brought_down_to_8_where_their_range_is_used(tmp_path):
    write_stack(tmp_path / "a.tif", FRAMES.astype(np.uint16) * 257)
    assert np.array_equal(read_clip(tmp_path / "a.tif").frames, FRAMES)
    cv2.imwrite(str(tmp_path / "a.png"), FRAMES[0][..., ::-1].astype(np.uint16) * 257)
    assert np.array_equal(read_still_image(tmp_path / "a.png"), FRAMES[0])


RANGE = "scale the frames to 0..255 and save them in 8 bits."
LOW = f"holds 16-bit values up to {{}}, expected 8 bits, or 16 that are used up to 65535; {RANGE}"
REAL = f"holds values of type float32, expected 8 or 16 bits; {RANGE}"


@pytest.mark.parametrize(
    ("name", "values", "sentence"),
    [("a.png", FRAMES.astype(np.uint16) * 16, LOW), ("a.tif", FRAMES / np.float32(255), REAL)],
)
def test_other_ranges_are_refused_whether_one_page_or_more(tmp_path, name, values, sentence):
    cv2.imwrite(str(tmp_path / name), values[0][..., ::-1])
    assert refusal(tmp_path / name, read_still_image) == sentence.format(values[0].max())
    stack = write_stack(tmp_path / "b.tif", values)
    assert refusal(stack) == sentence.format(values.max())


def test_one_page_is_one_frame_and_pages_of_two_sizes_are_refused(tmp_path):
    cv2.imwrite(str(tmp_path / "a.tif"), FRAMES[0])
    assert refusal(tmp_path / "a.tif") == (
        "only 1 frame was found, motion needs 2 or more; give the folder it lies in."
    )
    cv2.imwritemulti(str(tmp_path / "b.tif"), [FRAMES[0], FRAMES[1], FRAMES[2][:, :10].copy()])
    assert refusal(tmp_path / "b.tif") == (
        "page 3 is 10x24 pixels, page 1 is 32x24; keep frames of one recording in the file."
    )


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.99, 1.0])
def test_a_damaged_stack_is_refused_and_nothing_is_printed(tmp_path, capfd, share):
    stored = bytearray(write_stack(tmp_path / "a.tif", FRAMES).read_bytes())
    at = int.from_bytes(stored[4:8], "little") + 2  # the first entry of the first directory
    if share == 1:  # points outside the file
        stored[at : at + 12] = struct.pack("<HHII", 254, 2, 2**31, 2**31)
    (tmp_path / "a.tif").write_bytes(stored[: int(share * len(stored))] or b"II*")
    assert refusal(tmp_path / "a.tif") == (
        "is cut off or is no TIFF of whole pages; copy or record it again."
    )
    assert capfd.readouterr() == ("", "")


def test_vast_pages_are_refused_before_they_are_decoded(tmp_path, monkeypatch):
    monkeypatch.setattr(policy, "KEPT_BYTES", 2 * FRAMES[0].nbytes)
    monkeypatch.setattr(images.cv2, "imreadmulti", lambda *_, **__: pytest.fail("it was decoded"))
    sentence = refusal(write_stack(tmp_path / "a.tif", FRAMES))
    assert sentence.startswith("frames are 32x24 pixels, expected at most 0 million")


def test_a_stack_among_single_images_is_a_recording(tmp_path):
    write_stack(tmp_path / "1.tif", FRAMES)
    cv2.imwrite(str(tmp_path / "0.tif"), FRAMES[0])
    assert [path.name for path in clips_in(tmp_path)] == ["1.tif"]
    assert [path.name for path in skipped_in(tmp_path)] == ["0.tif"]
    with pytest.raises(UnreadableClip, match="1.tif: holds several pages, expected one image;"):
        read_clip(tmp_path)


IN_ORDER = {
    "counted": [f"frame{number}.png" for number in range(8, 12)],
    "seconds": ["tac_0.1990.png", "tac_0.2.png", "tac_0.2015.png", "tac_1.0.png"],
    "epoch seconds": ["1668534123.45.png", "1668534123.5.png", "1668534124.01.png"],
    "a time and a frame": [f"gs_17.{t}_frame00000{n}.png" for n, t in enumerate([7, 81, 9123])],
    "microseconds without zeros": ["gs_7_5_frame1.png", "gs_7_40_frame2.png", "gs_7_8_frame3.png"],
    "chapters": [f"f1.{number}.png" for number in range(1, 12)],
    "a full minute": ["00-58.png", "00-59.png", "01-00.png", "01-01.png"],
    "seconds and milliseconds": [f"{s}_{ms:03d}.png" for s in (11, 12) for ms in (0, 40, 80)],
    "days": ["2023-12-31.png", "2024-01-02.png", "2024-01-10.png", "2024-11-01.png"],
    "signed": ["t-8.png", "t-2.png", "t0.png", "t7.png"],
    "labelled": ["pre_1.png", "touch_2.png", "post_3.png"],
    "no numbers": ["bead.png", "key.png", "seed2.png"],
}


@pytest.mark.parametrize("names", IN_ORDER.values(), ids=IN_ORDER)
def test_frames_stand_in_the_order_of_their_numbers(names):
    rng = np.random.default_rng(0)
    for _ in range(3):
        assert list(frame_order("folder", list(rng.permutation(names))).names) == names


def test_a_frame_number_stands_before_a_time_and_a_note_says_where_they_differ():
    differing = frame_order("folder", IN_ORDER["microseconds without zeros"])
    assert "in order of their frame numbers" in differing.notes[0]
    assert not frame_order("folder", IN_ORDER["a time and a frame"]).notes
    assert "read as decimals" in frame_order("folder", IN_ORDER["seconds"]).notes[0]


def test_a_minus_is_a_sign_where_names_without_one_lie_beside_it():
    names = ["a-1", "a-2", "b1", "b10", "frame-2", "frame-10", "-3", "-2", "0"]
    ordered = [names[place] for place in natural_order(names)]
    assert ordered == ["-3", "-2", "0", "a-1", "a-2", "b1", "b10", "frame-2", "frame-10"]


SEVERAL = {
    "two sensors": [f"{side}_{n:04d}.png" for side in ("left", "right") for n in range(3)],
    "one longer": ["left_1.png", "left_2.png", "left_3.png", "right_2.png"],
    "behind the number": [f"{n}_{kind}.png" for kind in ("rgb", "depth") for n in range(3)],
    "numbered cameras": [f"cam{camera}_{n:04d}.png" for camera in (0, 1) for n in range(3)],
    "trials": [f"trial{trial}_{n}.png" for trial in (3, 4, 5) for n in (1, 2)],
    "two formats": ["1.png", "1.jpg", "2.png", "2.jpg"],
    "one number twice": ["f1.png", "f01.png", "f2.png"],
}
SENTENCES = {
    "two formats": "holds 2 frames as .jpg and as .png",
    "one number twice": "f1.png and f01.png have the same number",
}


@pytest.mark.parametrize("kind", SEVERAL)
def test_frames_of_several_recordings_and_frames_that_are_there_twice_are_refused(kind):
    sentence = SENTENCES.get(kind, r"frames of \d recordings .*; give each a folder")
    with pytest.raises(UnreadableClip, match=sentence):
        frame_order("folder", SEVERAL[kind])


def test_missing_numbers_leave_gaps_in_time(tmp_path):
    write_images(tmp_path, FRAMES, [f"frame_{number}.png" for number in (1, 2, 3, 6, 7, 8)])
    clip = read_clip(tmp_path, fps=10)
    assert clip.frame_numbers == (0, 1, 2, 5, 6, 7)
    assert clip.recorded_frames == 8
    assert "leave out 2 of 8" in clip.notes[1]
    assert missing_frames(clip).measured.startswith("2 of 8")
    played = open_source(str(tmp_path), fps=10)
    assert played.fps == 10
    assert [frame.time_s for frame in played] == pytest.approx([0, 0.1, 0.2, 0.5, 0.6, 0.7])


def test_an_image_named_unlike_the_frames_is_left_out(tmp_path):
    write_images(tmp_path, FRAMES[:4], ["1.png", "2.png", "3.png", "reference.png"])
    clip = read_clip(tmp_path)
    assert len(clip) == 3
    assert "Left out: 1 named unlike the other images (reference.png)." in clip.notes


def test_a_picture_with_overwritten_bytes_is_left_out(tmp_path):
    rng = np.random.default_rng(0)
    gel = cv2.GaussianBlur(rng.integers(60, 200, (96, 128, 3), np.uint8), (9, 9), 0)
    for number in range(6):
        cv2.imwrite(str(tmp_path / f"{number}.jpg"), gel)
    assert read_clip(tmp_path).frame_numbers == tuple(range(6))
    damaged = tmp_path / "3.jpg"
    stored = bytearray(damaged.read_bytes())
    stored[len(stored) // 3 : len(stored) // 3 + 300] = bytes(300)
    damaged.write_bytes(stored)
    clip = read_clip(tmp_path)
    assert clip.frame_numbers == (0, 1, 2, 4, 5)
    assert "Left out: 1 frames (3) unlike both their neighbours" in clip.notes[-1]
