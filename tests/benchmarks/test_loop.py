"""A gripper is stopped by what its sensor sees, and by nothing else."""

from types import SimpleNamespace

import pytest

from geotlm_lm.benchmarks.harness import Run
from geotlm_lm.benchmarks.loop import (
    LOOP,
    WATCHING,
    Ended,
    loosen_by_words,
    pull_by_words,
    pull_rows,
    turn_by,
    turn_by_words,
)
from geotlm_lm.simulation.gripper import Gripper


def test_a_cap_is_turned_to_its_goal_though_the_grip_slips(answerer):
    gripper = Gripper("tighten", seed=3)
    ended = turn_by_words(answerer, gripper)
    assert abs(ended.gripper.turned_deg - gripper.setting.goal) <= 3
    counted = turn_by(gripper.again(), lambda each: each.commanded_deg).gripper
    assert counted.turned_deg < gripper.setting.goal
    known = turn_by(gripper.again(), lambda each: each.turned_deg).gripper
    assert gripper.setting.goal <= known.turned_deg < gripper.setting.goal + 3


def test_a_slip_is_caught_and_lost_contact_is_told(answerer):
    pulled = pull_by_words(answerer, Gripper("pull", seed=7))
    assert pulled.stopped_s - pulled.due_s <= 0.2
    loosened = loosen_by_words(answerer, Gripper("loosen", seed=2))
    assert abs(loosened.stopped_s - loosened.due_s) <= 0.2


@pytest.mark.parametrize(
    ("slid_mm", "stopped_s", "is_caught", "is_no_false_stop"),
    [
        (0.31, 2.0, True, True),
        (0.25, 1.5, True, True),  # near to it both to stop and to go on is right
        (0.15, 1.5, False, False),
        (0.5, 2.3, False, True),
        (0.9, None, False, True),
    ],
)
def test_a_slip_is_caught_near_its_limit_and_soon(slid_mm, stopped_s, is_caught, is_no_false_stop):
    gripper = SimpleNamespace(slid_mm=slid_mm)
    caught, kept = pull_rows([Ended(gripper, stopped_s, due_s=2.0)])
    assert (caught.error == 0, kept.error == 0) == (is_caught, is_no_false_stop)


@pytest.mark.slow
def test_a_quick_run_has_every_case(answerer):
    rows = list(LOOP.run(Run(is_quick=True, answerer_given=answerer)))
    variants = {row.variant for row in rows}
    assert variants == {
        "conditions in words",
        "counts the commanded angle",
        "knows the true angle",
    }
    assert all(0 <= row.error <= 1 for row in rows)


@pytest.mark.slow
def test_real_recordings_are_watched(answerer, real):
    rows = list(WATCHING.run(Run(is_quick=True, answerer_given=answerer, real=real)))
    named = [row for row in rows if row.variant == "named within 0.3 s"]
    alarms = [row for row in rows if row.variant == "false alarms"]
    assert len(named) == len(alarms) == 4
    assert all("in ten" in row.outcome for row in alarms)
