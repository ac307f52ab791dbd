"""Each component of a mixed motion is graded by what counts and shows; truths by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from geotlm_lm.benchmarks.mixtures import (
    BELIEF,
    Told,
    belief_tells,
    grades,
    mixture_rows,
    words_tell,
)
from geotlm_lm.benchmarks.rows import Run
from geotlm_lm.benchmarks.variants import RIVALS
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.twist import COMPONENTS, Component, Twist
from geotlm_lm.motion.belief import Belief
from tests.benchmarks.fakes import FakeAnswerer

SHOWS = (9.0, 9.0, 9.0)


def label(turn=12.0, travel=(-6.0, 1.0), inward=0.0, visible=SHOWS):
    return MotionLabel(
        Motion.CLOCKWISE,
        rotation_deg=turn,
        depth_change_mm=inward,
        travel_px=travel,
        radius_px=30.0,
        visible_grey=visible,
    )


def belief(turn=11.0, travel=(-5.0, 2.0), inward=0.02, turns=0.9, slides=0.8, presses=0.1):
    ways = dict.fromkeys(Motion, 0.0)
    ways[Motion.CLOCKWISE if turn > 0 else Motion.COUNTERCLOCKWISE] = turns
    ways[Motion.LEFT] = slides
    ways[Motion.PRESS] = presses
    return Belief(
        mean=Twist(turn, *travel, inward),
        covariance=np.diag([1.0, 1.0, 1.0, 0.01]),
        ways=ways,
        contact=1.0,
        radius_px=30.0,
        readable=dict.fromkeys(COMPONENTS, True),
    )


def graded(truth, told):
    return dict(grades(truth, belief_tells(told)))


def test_a_belief_near_the_truth_is_right_about_all_of_it():
    found = graded(label(), belief())
    assert set(found) == {
        "turn: counts",
        "turn: way",
        "turn: how far",
        "turn: span",
        "slide: counts",
        "slide: way",
        "slide: how far",
        "slide: span",
        "press: counts",  # it does not, and nothing else is asked of it
        "turn and slide: both ways",
    }
    assert all(found.values())


def test_each_part_is_wrong_for_its_own_reason():
    opposite = graded(label(), belief(turn=-11.0))
    assert [name for name, right in opposite.items() if not right] == [
        "turn: way",
        "turn and slide: both ways",
    ]
    far = graded(label(), belief(turn=20.0))
    assert [name for name, right in far.items() if not right] == ["turn: how far", "turn: span"]
    unsure = graded(label(), belief(slides=0.4))
    assert [name for name, right in unsure.items() if not right] == [
        "slide: counts",
        "turn and slide: both ways",
    ]


@pytest.mark.parametrize(("down", "is_right"), [(5.9, True), (6.1, False)])
def test_a_heading_may_be_half_a_right_angle_off(down, is_right):
    found = graded(label(travel=(-6.0, 0.0)), belief(travel=(-6.0, down)))
    assert found["slide: way"] is is_right


@pytest.mark.parametrize(
    ("truth", "left_out"),
    [
        (label(turn=1.2), "turn"),  # 0.63 px at the radius: ambiguous
        (label(visible=(1.0, 9.0, 9.0)), "turn"),
        (label(inward=0.1), "press"),
        (label(inward=0.3, visible=(9.0, 9.0, 1.0)), "press"),
    ],
)
def test_what_is_ambiguous_or_does_not_show_is_left_out(truth, left_out):
    found = graded(truth, belief())
    assert not any(name.startswith(f"{left_out}:") for name in found)
    assert ("turn and slide: both ways" in found) == (left_out == "press")


def test_who_has_no_opinion_is_not_graded():
    ways = {Component.TURN: (1.0,), Component.SLIDE: (0.0, 1.0)}
    found = dict(grades(label(inward=0.4), Told(ways)))
    assert found == {"turn: way": True, "slide: way": False, "turn and slide: both ways": False}


def test_words_are_asked_of_each_component_and_name_its_way_or_deny_it():
    def ask(encoded, question):
        decided = "yes" if "lifting" in question else "no"
        return SimpleNamespace(in_the_image=Motion.CLOCKWISE, decided=decided)

    told = words_tell(SimpleNamespace(ask=ask), None)
    assert told.counting == {
        Component.TURN: True,
        Component.SLIDE: False,
        Component.PRESS: True,
    }
    found = dict(grades(label(inward=-0.4), told))
    assert {name for name, right in found.items() if not right} == {
        "slide: counts",
        "slide: way",
        "turn and slide: both ways",
    }


def test_mixtures_of_the_simulator_are_graded_by_every_method():
    rows = mixture_rows(Run(is_quick=True, answerer_given=FakeAnswerer()))
    assert {row.variant for row in rows} == {BELIEF, "words", *RIVALS}
    assert all("simulated mixtures, " in row.case and 0 < row.count <= 6 for row in rows)
