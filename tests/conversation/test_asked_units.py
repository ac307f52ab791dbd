"""Units that an amount is asked for in."""

import math

import pytest

from geotlm_lm.conversation.asked_units import asked_unit, asks_per_frame, with_unit


@pytest.mark.parametrize(
    ("question", "told", "name", "factor"),
    [
        ("How many radians?", "deg", "radians", math.radians(1)),
        ("how far in cm?", "mm", "cm", 0.1),
        ("How many arcminutes did it turn?", "deg", "arcminutes", 60.0),
        ("How many minutes of arc did it turn?", "deg", "minutes of arc", 60.0),
        ("Give the rotation angle in radians.", "deg", "radians", math.radians(1)),
        ("How many turns did it make?", "deg", "turns", 1 / 360),
        ("How fast in rpm?", "deg/s", "rpm", 1 / 6),
        ("How many radians per second?", "deg/s", "radians per second", math.radians(1)),
        ("How many degrees per minute?", "deg/s", "degrees per minute", 60.0),
    ],
)
def test_a_unit_that_is_asked_for_is_named_with_its_size(question, told, name, factor):
    assert asked_unit(question, told) == (name, pytest.approx(factor))


@pytest.mark.parametrize(
    ("question", "told"),
    [
        ("How many degrees?", "deg"),
        ("How many degrees per second?", "deg/s"),
        ("How many radians?", "px"),
        ("How many inches?", "px"),
        ("How many degrees per frame?", "deg/s"),
        ("How far?", "deg"),
    ],
)
def test_the_unit_told_anyway_and_one_of_another_thing_are_none(question, told):
    assert asked_unit(question, told) is None


def test_frames_are_asked_for_one_by_one():
    assert asks_per_frame("How far per frame?")
    assert not asks_per_frame("How far between frames 2 and 9?")


@pytest.mark.parametrize(
    ("question", "told", "meant"),
    [
        ("more than 20?", "deg", "more than 20 degrees?"),
        ("and less than 10.5?", "px", "and less than 10.5 pixels?"),
        ("was it more than 3?", "mm", "was it more than 3 mm?"),
        ("about 30?", "deg", "about 30 degrees?"),
        ("at least 4?", "px", "at least 4 pixels?"),
        ("more than 20 pixels?", "deg", "more than 20 pixels?"),
        ("more than 20?", "deg/s", "more than 20?"),
        ("more than 2 motions?", "deg", "more than 2 motions?"),
        ("how much more than 20?", "deg", "how much more than 20?"),
    ],
)
def test_a_bare_number_after_an_amount_is_of_its_unit(question, told, meant):
    assert with_unit(question, told) == meant
