from types import SimpleNamespace

import numpy as np
import pytest

from geotlm_lm.benchmarks.cases.recordings import (
    by_task,
    four_frames,
    held_across,
    real_recordings,
    task_of,
    window_cases,
    without_idle_frame,
)
from geotlm_lm.benchmarks.cases.simulated import SimulatedCases
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion, MotionLabel
from geotlm_lm.simulation import simulate


def test_unreadable_clips_are_replaced_and_counted(monkeypatch):
    def every_third_unreadable(seed, count, *, objects, motions):
        for number in range(count):
            yield SimpleNamespace(
                clip=Clip(np.zeros((4, 8, 8, 3), np.uint8)),
                label=MotionLabel(motions[number % len(motions)], is_readable=number % 3 != 2),
                object_name=f"object {number % 4}",
            )

    monkeypatch.setattr(simulate, "simulate_series", every_third_unreadable)
    cases = SimulatedCases("rotation", 20, seed=0)
    assert len(list(cases)) == 20
    # Of the numbers 0..28 every third is unreadable: 2, 5, ..., 26.
    assert cases.unreadable == 9


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
    cases = window_cases(labelled(tmp_path, "left"))
    found = [(case.tags["frames"], case.tags["played"], case.motion) for case in cases]
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


def test_a_clip_that_starts_in_contact_shows_no_idle_gel(tmp_path):
    shown = list(four_frames(labelled(tmp_path, "left"), without_idle_frame))
    assert [case.motion for case in shown] == [Motion.LEFT, Motion.RIGHT]
    assert [case.clip.background for case in shown] == [None, None]
    assert shown[0].clip.frame_numbers == (0, 3, 6, 9)


def test_a_window_turned_by_a_quarter_is_turned_with_its_label_and_its_idle_gel(tmp_path):
    recordings = labelled(tmp_path, "left")
    shown = list(four_frames(recordings, held_across))
    assert [case.motion for case in shown] == [Motion.DOWN, Motion.UP]
    upright = next(window_cases(recordings)).clip
    # What was the right border is the top one.
    np.testing.assert_array_equal(shown[0].clip.frames[:, 0], upright.frames[:, :, -1])
    np.testing.assert_array_equal(shown[0].clip.background[0], upright.background[:, -1])
    assert shown[0].clip.frame_numbers == upright.frame_numbers


def test_labels_of_several_tasks_are_asked_task_by_task(tmp_path):
    parts = by_task(labelled(tmp_path, "clockwise", "left", "up", "press", "up-left"))
    found = {name: [row.motion for row in part.rows] for name, part in parts.items()}
    assert found == {
        " rotation": [Motion.CLOCKWISE],
        " sliding": [Motion.LEFT, Motion.UP],
        " without direction": [Motion.PRESS],
    }
    assert task_of(parts[" sliding"].rows) == SLIDES
    assert parts[" sliding"].skipped == {"up-left": 1}
