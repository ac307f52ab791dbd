"""Frames are chosen where the imprint moves at full, steady contact, and the clip says which."""

import csv
import importlib

import cv2
import numpy as np
import pytest

from geotlm_lm.benchmarks.cases.damaged import extreme_clips
from geotlm_lm.benchmarks.cases.simulated import SimulatedCases
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.recordings.choose import choose_frames
from geotlm_lm.recordings.read import read_clip

ROWS, COLUMNS = 120, 160
PATTERN = cv2.GaussianBlur(np.random.default_rng(1).normal(0, 1, (240, 240)), (0, 0), 5)
PATTERN *= 30 / PATTERN.std()


def frame(angle_deg=0.0, depth=1.0, seed=0):
    """Return a rough disc, turned by `angle_deg` and pressed to `depth`, over a plain gel."""
    turn = cv2.getRotationMatrix2D((120, 120), -angle_deg, 1)
    rough = cv2.warpAffine(PATTERN, turn, (240, 240))[60:180, 40:200]
    y, x = np.mgrid[:ROWS, :COLUMNS]
    disc = np.hypot(x - 80, y - 60) < 45
    grey = 120 + depth * disc * rough + np.random.default_rng(seed).normal(0, 1, (ROWS, COLUMNS))
    return np.repeat(np.clip(np.rint(grey), 0, 255).astype(np.uint8)[..., None], 3, axis=-1)


def recording(angles, depths):
    return Clip(
        np.stack([frame(a, d, i) for i, (a, d) in enumerate(zip(angles, depths, strict=True))])
    )


@pytest.fixture(scope="module")
def press_hold_twist_release():
    """Idle 0-9, pressing to 14, still to 29, twisting by 36 degrees to 47, still to 59, release."""
    depths = [0] * 10 + list(np.linspace(0.2, 1, 5)) + [1] * 45 + list(np.linspace(0.8, 0, 6))
    angles = [0] * 30 + list(np.linspace(2, 36, 18)) + [36] * 18
    return recording(angles, depths)


def test_frames_are_taken_from_the_twist_and_not_from_press_or_release(press_hold_twist_release):
    numbers = choose_frames(press_hold_twist_release).frame_numbers
    assert 28 <= numbers[0] < numbers[-1] <= 49


def test_neighbouring_frames_are_at_most_twelve_degrees_apart(press_hold_twist_release):
    steps = np.diff(choose_frames(press_hold_twist_release).frame_numbers)
    assert 3 < 2 * steps.max() <= 12  # two degrees per frame


def test_playing_a_recording_backwards_chooses_the_same_frames(press_hold_twist_release):
    forwards = choose_frames(press_hold_twist_release).frame_numbers
    backwards = choose_frames(press_hold_twist_release.reversed()).frame_numbers
    assert np.abs(np.array(forwards) - backwards[::-1]).max() <= 1


def test_a_small_turn_back_before_the_main_motion_is_not_taken_for_it():
    """Back by 12 degrees until frame 30, held, and forward by 36 from 40 to 58, more slowly."""
    depths = [0] * 10 + list(np.linspace(0.2, 1, 5)) + [1] * 50 + list(np.linspace(0.8, 0, 6))
    back, forward = np.linspace(-4, -12, 3), np.linspace(-12, 24, 19)
    angles = [0] * 28 + list(back) + [-12] * 9 + list(forward) + [24] * 12
    numbers = choose_frames(recording(angles, depths)).frame_numbers
    assert 39 <= numbers[0] < numbers[-1] <= 59


def test_of_an_even_motion_the_middle_between_its_two_ends_is_taken():
    """Back by 16 degrees, held, and forward by 64, evenly: the middle lies 32 degrees on."""
    depths = [0] * 10 + list(np.linspace(0.2, 1, 5)) + [1] * 59 + list(np.linspace(0.8, 0, 6))
    back, forward = np.linspace(-4, -16, 4), np.linspace(-14, 48, 32)
    angles = np.array([0] * 18 + list(back) + [-16] * 9 + list(forward) + [48] * 17)
    numbers = choose_frames(recording(angles, depths)).frame_numbers
    assert angles[list(numbers)].mean() == pytest.approx(16, abs=6)


def test_of_a_turn_too_fast_for_its_frames_those_in_direct_succession_are_taken():
    depths = [0] * 10 + list(np.linspace(0.2, 1, 5)) + [1] * 15 + list(np.linspace(0.8, 0, 6))
    angles = [0] * 20 + list(np.linspace(15, 60, 4)) + [60] * 12
    numbers = choose_frames(recording(angles, depths)).frame_numbers
    assert np.diff(numbers).tolist() == [1, 1, 1]
    assert 18 <= numbers[0] < numbers[-1] <= 24


def test_the_chosen_frames_are_named_and_the_idle_gel_is_kept(press_hold_twist_release):
    chosen = choose_frames(press_hold_twist_release)
    numbers = ", ".join(str(number) for number in chosen.frame_numbers)
    assert chosen.notes == (
        "Background: the recording's own untouched frames.",
        f"Frames {numbers} are used.",
    )
    assert np.abs(chosen.background.astype(int) - 120).max() <= 3


def test_a_press_without_motion_shows_the_pressing_in():
    depths = [0] * 10 + list(np.linspace(0.1, 1, 8)) + [1] * 12
    numbers = choose_frames(recording([0] * 30, depths)).frame_numbers
    assert numbers[0] <= 11
    assert 15 <= numbers[-1] <= 18


def test_a_release_without_motion_shows_the_lifting():
    depths = [1] * 12 + list(np.linspace(1, 0.1, 8)) + [0] * 10
    numbers = choose_frames(recording([0] * 30, depths)).frame_numbers
    assert 10 <= numbers[0] <= 14
    assert numbers[-1] >= 17


def test_a_clip_of_four_frames_is_kept_whole():
    clip = recording([0, 3, 6, 9], [1] * 4)
    assert choose_frames(clip).frame_numbers == (0, 1, 2, 3)


@pytest.mark.parametrize(("length", "numbers"), [(2, (0, 0, 1, 1)), (3, (0, 1, 1, 2))])
def test_a_short_clip_repeats_frames_in_time_order(length, numbers):
    clip = recording([0, 3, 6][:length], [1] * length)
    assert choose_frames(clip).frame_numbers == numbers


def test_a_span_is_taken_evenly_with_both_ends(press_hold_twist_release):
    chosen = choose_frames(press_hold_twist_release, span=(30, 45))
    assert chosen.frame_numbers == (30, 35, 40, 45)


@pytest.mark.parametrize("span", [(45, 30), (30, 30), (0, 66), (-3, 5)])
def test_a_span_outside_the_recording_is_a_wrong_call(press_hold_twist_release, span):
    with pytest.raises(UsageError) as caught:
        choose_frames(press_hold_twist_release, span=span)
    assert str(caught.value) == (
        f"Frames {span[0]}:{span[1]} were asked for, expected FIRST < LAST within 0:65; "
        f"give frame numbers inside the recording."
    )


def test_a_span_counts_in_the_recording_where_it_was_read_at_a_stride(press_hold_twist_release):
    strided = press_hold_twist_release.select(range(0, 66, 5))
    assert choose_frames(strided, span=(28, 46)).frame_numbers == (30, 35, 40, 45)
    with pytest.raises(UsageError) as caught:
        choose_frames(strided, span=(31, 36))
    assert str(caught.value) == (
        "Frames 31:36 hold 1 of the frames that were read, expected 2 or more; "
        "give a longer span, or cut the recording so that all of it is read."
    )


@pytest.mark.parametrize("grey", [0, 90])
def test_frames_that_are_all_alike_are_taken_evenly(grey):
    clip = Clip(np.full((10, 24, 32, 3), grey, np.uint8))
    assert choose_frames(clip).frame_numbers == (0, 3, 6, 9)


def test_of_two_presses_the_release_between_them_is_shown():
    depths = [1] * 8 + list(np.linspace(0.9, 0, 6)) + list(np.linspace(0, 1, 8))
    numbers = choose_frames(recording([0] * 22, depths)).frame_numbers
    assert 5 <= numbers[0] < numbers[-1] <= 15


def test_one_frame_shows_no_motion():
    with pytest.raises(UnreadableClip, match="motion needs 2 or more"):
        choose_frames(recording([0], [1]))


def test_a_long_recording_is_compared_at_a_stride(press_hold_twist_release, monkeypatch):
    module = importlib.import_module("geotlm_lm.recordings.choose")
    monkeypatch.setattr(module, "CANDIDATE_LIMIT", 40)
    numbers = choose_frames(press_hold_twist_release).frame_numbers
    assert all(number % 2 == 0 for number in numbers)
    assert 28 <= numbers[0] < numbers[-1] <= 50


@pytest.mark.real
def test_frames_chosen_from_real_recordings_lie_in_contact(real):
    with (real / "physiclear" / "clips.csv").open() as stream:
        rows = [row for row in csv.DictReader(stream) if row["tier"] == "A"][4::12]
    inside = []
    for row in rows:
        numbers = choose_frames(read_clip(real / "physiclear" / row["clip"])).frame_numbers
        inside.append(
            int(row["contact_start"]) - 2 <= numbers[0]
            and numbers[-1] <= int(row["contact_end"]) + 2
        )
    assert np.mean(inside) > 0.85


def test_a_long_recording_of_sudden_steps_is_not_begun_before_the_touch():
    touched = next(iter(SimulatedCases("rotation", 1, seed=0)))
    extreme = extreme_clips(touched.clip, touched.motion)["10,000 frames"]
    assert min(choose_frames(extreme.make()).frame_numbers) >= 1_000  # a tenth is the idle gel
