"""What a grip carries goes along elastically, then slips; what is seen is what moves."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geotlm_lm.simulation.gripper import APPROACH_S, IDLE_S, Carried, Grip, Gripper

GRIP = Grip(stiffness=2.0, limit=0.5)
STEPS = st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(0, 2)), max_size=40)


@given(STEPS)
def test_the_sensor_s_way_is_that_of_the_object_what_gives_and_what_slips(steps):
    carried = Carried(GRIP)
    for step, load in steps:
        carried.pull(step, load)
        assert abs(carried.stretched) <= GRIP.stretch + 1e-9
    total = sum(step for step, _ in steps)
    parts = carried.moved + carried.stretched + carried.slipped
    assert parts == pytest.approx(total, abs=1e-9)
    assert carried.moved - total == pytest.approx(carried.relative, abs=1e-9)


@given(STEPS)
def test_the_other_way_round_all_goes_the_other_way(steps):
    one, other = Carried(GRIP), Carried(GRIP)
    for step, load in steps:
        one.pull(step, load)
        other.pull(-step, load)
    assert other.moved == pytest.approx(-one.moved)
    assert other.slipped == pytest.approx(-one.slipped)


@given(st.floats(0.01, 5.0), st.floats(0, 0.99))
def test_below_the_limit_nothing_slips_and_beyond_it_nothing_is_carried(step, load):
    held, bound = Carried(GRIP), Carried(GRIP)
    held.pull(step, load)
    bound.pull(step, 2.0)
    assert held.slipped == 0
    assert bound.moved == 0
    assert bound.slipped == pytest.approx(max(step - GRIP.stretch, 0.0))


def test_a_stiffer_press_holds_more():
    gripper = Gripper("tighten", seed=1)
    (turn, slide), (more_turn, more_slide) = (gripper.grips(depth) for depth in (0.6, 1.0))
    for one, other in ((turn, more_turn), (slide, more_slide)):
        assert 0 < one.limit < other.limit
        assert 0 < one.stiffness < other.stiffness


@pytest.mark.parametrize("task", ["tighten", "pull"])
def test_the_wrist_rests_in_the_frame_from_which_on_the_object_is_held(task):
    gripper = Gripper(task, seed=5, is_seen=False)
    while not gripper.is_ready:
        own = gripper.step(gripper.setting.rate).own_motion
    assert gripper.slid_mm == gripper.commanded_deg == own.turn_deg == own.right_px == 0
    own = gripper.step(gripper.setting.rate).own_motion
    assert gripper.commanded_deg > 0
    assert own.turn_deg + own.right_px > 0


@pytest.mark.parametrize("task", ["tighten", "pull", "loosen"])
def test_mechanics_do_not_depend_on_being_seen(task):
    seen = Gripper(task, seed=5)
    unseen = seen.again()
    rate = seen.setting.rate * (-1 if task == "loosen" else 1)
    for _ in range(60):
        first, second = seen.step(rate), unseen.step(rate)
        assert first.frame.shape == (224, 224, 3)
        assert second.frame is None
        assert first.own_motion == second.own_motion
    assert seen.turned_deg == unseen.turned_deg
    assert seen.slid_mm == unseen.slid_mm


def test_one_seed_is_one_gripper():
    one, other = Gripper("tighten", 7), Gripper("tighten", 7)
    assert one.setting == other.setting
    for _ in range(30):
        frames = [each.step(20.0).frame for each in (one, other)]
        np.testing.assert_array_equal(*frames)


def test_nothing_moves_and_nothing_touches_before_the_object_is_held():
    gripper = Gripper("tighten", seed=2)
    idle = [gripper.step(50.0).frame.astype(float) for _ in range(round(IDLE_S * 25))]
    while not gripper.is_ready:
        touched = gripper.step(50.0).frame
    assert np.abs(idle[0] - idle[-1]).mean() < np.abs(touched - idle[-1]).mean() / 2
    assert gripper.time_s >= IDLE_S + APPROACH_S
    assert gripper.commanded_deg == pytest.approx(50.0 / 25, abs=2.0)


def test_a_cap_that_comes_off_its_thread_is_lost():
    gripper = Gripper("loosen", seed=4, is_seen=False)
    while gripper.lost_s is None and gripper.time_s < 20:
        gripper.step(-30.0)
    assert gripper.lost_s is not None
    assert -gripper.turned_deg >= gripper.setting.thread_ends_deg or math.isfinite(gripper.lost_s)
