"""Numbers with a unit, and what is none."""

import math

import pytest

from geotlm_lm.conversation.quantities import quantities, without_quantities


@pytest.mark.parametrize(
    ("text", "values", "unit"),
    [
        ("0.5 rad", (math.degrees(0.5),), "deg"),
        ("half a radian", (math.degrees(0.5),), "deg"),
        ("1 cm", (10.0,), "mm"),
        ("200 \N{GREEK SMALL LETTER MU}m", (0.2,), "mm"),
        ("200 microns", (0.2,), "mm"),
        ("two inches", (50.8,), "mm"),
        ("one and a half turns", (540.0,), "deg"),
        ("a third of a turn", (120.0,), "deg"),
        ("45\N{DEGREE SIGN}", (45.0,), "deg"),
        ("5-10 mm", (5.0, 10.0), "mm"),
        ("between 5 mm and 1 cm", (5.0, 10.0), "mm"),
        ("between a hundred and two hundred degrees", (100.0, 200.0), "deg"),
        ("10 \N{PLUS-MINUS SIGN} 2 degrees", (8.0, 12.0), "deg"),
        ("10 px/s", (10.0,), "px/s"),
        ("ten degrees a second", (10.0,), "deg/s"),
        ("120 degrees per minute", (2.0,), "deg/s"),
        ("5 rpm", (30.0,), "deg/s"),
        ("1 turn per minute", (6.0,), "deg/s"),
        ("half a turn per second", (180.0,), "deg/s"),
        ("one rotation", (360.0,), "deg"),
        ("2 revolutions per second", (720.0,), "deg/s"),
        # Named, and not read as any number.
        ("a few degrees", (), "deg"),
        ("-20 degrees", (), "deg"),
        ("10 or 20 degrees", (), "deg"),
        ("20 to 10 degrees", (), "deg"),
        (f"{10**400} degrees", (), "deg"),
        ("5 degrees per frame", (), "deg/s"),
    ],
)
def test_a_quantity_is_read_in_the_unit_it_is_told_in(text, values, unit):
    (found,) = quantities(text)
    assert found.values == pytest.approx(values)
    assert found.unit == unit


@pytest.mark.parametrize(
    "text",
    [
        "did the 10 mm nut turn?",
        "is it a rotation?",
        "does one turn left?",
        "the m8 bolt",
        "left (2)",
        "is it one rotation or a slide?",
        "is it a slide or one rotation?",
    ],
)
def test_what_counts_no_amount_is_none(text):
    assert quantities(text) == ()


def test_the_size_of_a_thing_stays_beside_the_amount():
    assert without_quantities("did the 10 mm nut turn 20 degrees?") == "did the 10 mm nut turn  ?"
