"""Clips have the motions, sets, halves and sources that their titles say."""

from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest

from geotlm_lm.benchmarks import clips
from geotlm_lm.benchmarks.cases import (
    HALVES,
    half_of,
    held_across,
    open_data_sets,
    real_recordings,
    rows_of_half,
    simulated_cases,
    task_of,
    window_cases,
)
from geotlm_lm.benchmarks.harness import Run
from geotlm_lm.benchmarks.judging import Reply
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion, MotionLabel
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.simulation import simulate
from tests.data.action_clips import write_actions
from tests.data.tracked_trials import path_of, write_trial


def test_unreadable_clips_are_replaced_and_counted(monkeypatch):
    def every_third_unreadable(seed, count, *, objects, motions):
        for number in range(count):
            yield SimpleNamespace(
                clip=Clip(np.zeros((4, 8, 8, 3), np.uint8)),
                label=MotionLabel(motions[number % len(motions)], is_readable=number % 3 != 2),
                object_name=f"object {number % 4}",
            )

    monkeypatch.setattr(simulate, "simulate_series", every_third_unreadable)
    left_out = Counter()
    assert len(list(simulated_cases("rotation", 20, 0, left_out))) == 20
    # Of the numbers 0..28 every third is unreadable: 2, 5, ..., 26.
    assert left_out == {"unreadable_left_out": 9}


def labelled_folder(folder, *directions):
    (folder / "clips").mkdir(parents=True)
    frames = (
        np.zeros((12, 16, 16, 3), np.uint8) + np.arange(12, dtype=np.uint8)[:, None, None, None]
    )
    np.save(folder / "clips" / "a.npy", frames)
    rows = [f"a.npy,0,9,{direction}" for direction in directions]
    (folder / "windows.csv").write_text(
        "\n".join(["clip,first_frame,last_frame,direction", *rows]) + "\n"
    )
    return folder


def labelled(folder, *directions):
    (recordings,) = real_recordings(labelled_folder(folder / "mine", *directions)).values()
    return recordings


@pytest.mark.parametrize(
    ("directions", "among"),
    [
        (("clockwise", "clockwise"), ROTATIONS),
        (("left",), SLIDES),
        (("clockwise", "left"), DIRECTED),
        (("clockwise", "press"), tuple(Motion)),
    ],
)
def test_the_task_is_the_smallest_that_holds_every_label(tmp_path, directions, among):
    assert task_of(labelled(tmp_path, *directions).rows) == among


def test_each_window_is_given_as_four_and_pair_both_ways(tmp_path):
    windows = window_cases(labelled(tmp_path, "left"))
    found = [(case.tags["frames"], case.tags["played"], case.motion) for case in windows]
    assert found == [
        ("four", "forwards", Motion.LEFT),
        ("four", "backwards", Motion.RIGHT),
        ("pair", "forwards", Motion.LEFT),
        ("pair", "backwards", Motion.RIGHT),
    ]


def test_a_folder_without_usable_labels_says_what_it_found(tmp_path):
    folder = labelled_folder(tmp_path / "mine", "up-left", "up-left")
    with pytest.raises(UnreadableClip, match=r"no row has a usable direction .*'up-left': 2"):
        real_recordings(folder)


def test_a_window_turned_by_a_quarter_is_turned_with_its_label_and_its_idle_gel(tmp_path):
    case = next(window_cases(labelled(tmp_path, "left")))
    across, upright = held_across(case), case.clip
    assert across.motion is Motion.DOWN
    # What was the right border is the top one.
    np.testing.assert_array_equal(across.clip.frames[:, 0], upright.frames[:, :, -1])
    np.testing.assert_array_equal(across.clip.background[0], upright.background[:, -1])
    assert across.clip.frame_numbers == upright.frame_numbers


def test_rows_are_of_one_half_or_of_both():
    rows = [SimpleNamespace(object_family=name) for name in ("lemon", "tsa", "unheard of", "pen")]
    reported, tuned = (rows_of_half(rows, half) for half in HALVES)
    assert rows_of_half(rows, None) == tuple(rows)
    assert len(reported) + len(tuned) == len(rows)
    assert tuned[0].object_family == "lemon"
    assert half_of("avocado_real") == half_of("avocado")
    assert rows[1] in reported


FLOW = {"flow": lambda clip, among: Reply(RigidFlow().predict(clip, among), 1.0)}


def judged_rows(path, variants=FLOW, **options):
    ((name, data_set),) = open_data_sets([path]).items()
    return list(clips.data_set_rows(Run(**options), name, data_set, variants))


@pytest.fixture(scope="module")
def tracked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("trials") / "normalflow_dataset"
    write_trial(folder / "key0", path_of(11, turn_deg=(0, 12), y=(-2.0, -2.0)))
    write_trial(folder / "key1", path_of(11, turn_deg=(12, 0), y=(-2.0, -2.0)))
    write_trial(folder / "bead0", path_of(11, x=(-0.8, 0.8), y=(1.5, 1.5)))
    (folder / "bead1").mkdir()
    (folder / "bead1" / "true_start_T_currs.npy").write_bytes(b"")
    return folder


def test_trials_are_judged_as_the_papers_two_tasks(tracked):
    turns, slides = judged_rows(tracked)
    assert (turns.case, turns.error) == ("TactileTracking normalflow_dataset, rotation", 0)
    assert (slides.case, slides.error) == ("TactileTracking normalflow_dataset, sliding", 0)
    assert set(turns.detail["recall"]) == {"clockwise", "counterclockwise"}
    assert set(slides.detail["recall"]) == {"right"}
    assert turns.detail["pairs"]["rule"]["gap_frames"] in (5, 10)
    assert turns.detail["pairs"]["paper_share"] == pytest.approx(3 / 84)
    assert clips.left_out(turns) == "1 whose files cannot be used"
    assert "bead1: gelsight.avi is missing" in turns.detail["first_left_out"][0]


@pytest.fixture(scope="module")
def listed(tmp_path_factory):
    root = tmp_path_factory.mktemp("listed")
    write_actions(root, frames=7)
    write_actions(root, body="key", sensor="digit", actions=("rotate_cw", "slide_up"))
    rows = ["clip_id,object_id,sensor,action,frames,background"]
    for path in sorted(root.glob("*/*/*")):
        body, sensor, name = path.relative_to(root).parts
        folder = f"{body}/{sensor}/{name}"
        action = name.removesuffix("-0")
        rows.append(f"{folder},{body},{sensor},{action},{folder}/[0-9]*.png,{folder}/bg.png")
    rows.append("bad,key,digit,slide_up,gone.npy,")
    (root / "touchd.csv").write_text("\n".join(rows) + "\n")
    return root / "touchd.csv"


def test_a_manifest_is_judged_by_task_and_by_sensor(listed):
    rows = judged_rows(listed)
    assert [(row.case, row.count) for row in rows] == [
        ("manifest touchd, rotation", 3),
        ("manifest touchd, rotation, sensor digit", 1),
        ("manifest touchd, rotation, sensor gsmini", 2),
        ("manifest touchd, sliding", 5),
        ("manifest touchd, sliding, sensor digit", 1),
        ("manifest touchd, sliding, sensor gsmini", 4),
    ]
    assert max(row.error for row in rows) <= 0.25
    assert rows[3].detail["files_left_out"] == 1  # told once it is to be read


def test_two_data_sets_of_one_name_are_refused(listed):
    with pytest.raises(UsageError, match="another data set is called 'manifest touchd' too"):
        open_data_sets([listed, listed])
