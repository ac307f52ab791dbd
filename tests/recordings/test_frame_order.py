"""Frames of a folder in the order their names tell, or one sentence where they tell of several."""

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.doctor.examine import missing_frames
from geotlm_lm.recordings.frame_order import frame_order, natural_order
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.recordings.streams import open_source

FRAMES = np.random.default_rng(3).integers(0, 256, (6, 24, 32, 3)).astype(np.uint8)

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
        order = frame_order("folder", list(rng.permutation(names)))
        assert list(order.names) == names
        assert not order.left_out


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
}


@pytest.mark.parametrize("names", SEVERAL.values(), ids=SEVERAL)
def test_frames_of_several_recordings_are_refused(names):
    with pytest.raises(UnreadableClip, match=r"frames of \d recordings .*; give each a folder"):
        frame_order("folder", names)


@pytest.mark.parametrize(
    ("names", "sentence"),
    [
        (["1.png", "1.jpg", "2.png", "2.jpg"], "holds 2 frames as .jpg and as .png"),
        (["f1.png", "f01.png", "f2.png"], "f1.png and f01.png have the same number"),
    ],
)
def test_a_frame_that_is_there_twice_is_refused(names, sentence):
    with pytest.raises(UnreadableClip, match=sentence):
        frame_order("folder", names)


def write_images(folder, names, frames):
    for name, frame in zip(names, frames, strict=True):
        cv2.imwrite(str(folder / name), frame[..., ::-1])


def test_missing_numbers_leave_gaps_in_time(tmp_path):
    numbers = [1, 2, 3, 6, 7, 8]
    write_images(tmp_path, [f"frame_{number}.png" for number in numbers], FRAMES)
    clip = read_clip(tmp_path, fps=10)
    assert clip.frame_numbers == (0, 1, 2, 5, 6, 7)
    assert clip.recorded_frames == 8
    assert "leave out 2 of 8" in clip.notes[1]
    assert missing_frames(clip).measured.startswith("2 of 8")
    played = open_source(str(tmp_path), fps=10)
    assert played.fps == 10
    assert [frame.time_s for frame in played] == pytest.approx([0, 0.1, 0.2, 0.5, 0.6, 0.7])


def test_an_image_named_unlike_the_frames_is_left_out(tmp_path):
    names = ["1.png", "2.png", "3.png", "reference.png"]
    write_images(tmp_path, names, FRAMES[:4])
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
