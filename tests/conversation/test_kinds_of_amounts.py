"""Which questions ask how far or how fast, and which only name a unit."""

import pytest

from geotlm_lm.conversation.kinds import (
    asked_amount,
    asked_kind,
)
from geotlm_lm.data.templates import load_templates

TEMPLATES = load_templates()
HELD_BY_EVERY_MODEL = ("T1", "T2", "T3", "T5", "T6", "T16", "T17")
ROUNDS = 6
CLAIM_OF = {"T2": "Yes", "T4": "It is: ", "T18": "That holds"}


@pytest.mark.parametrize(
    ("question", "kind", "amount"),
    [
        ("How many degrees clockwise did it turn?", "premise", "magnitude"),
        ("How many mm did it slide to the left?", "premise", "magnitude"),
        ("How fast does it turn clockwise?", "premise", "rate"),
        ("How many radians?", "magnitude", "magnitude"),
        ("How many turns did it make?", "magnitude", "magnitude"),
        ("and in radians?", "magnitude", "magnitude"),
        ("How many px/s?", "rate", "rate"),
        ("How many degrees per minute?", "rate", "rate"),
        ("Since when does it turn clockwise?", "premise", None),
    ],
)
def test_an_amount_is_asked_for_beside_a_motion_taken_for_granted(question, kind, amount):
    assert (asked_kind(question), asked_amount(question)) == (kind, amount)


@pytest.mark.parametrize(
    "question",
    [
        "Give me the direction as an angle in degrees",
        "Report which way it moves in degrees",
        "Give me the direction of rotation in degrees",
        "Report the position of the cable in pixels.",
        "State where the contact is in pixels",
        "Give the size of the image in pixels",
        "Report the uncertainty in pixels",
        "Give the diameter of the cap in mm",
    ],
)
def test_what_is_given_in_a_unit_may_be_no_amount_of_motion(question):
    assert asked_kind(question) is None


@pytest.mark.parametrize(
    "question",
    [
        "Give me the rotation in degrees",
        "Report the angle it turned in degrees",
        "give it in radians",
        "Express the answer in mm",
        "State the travel of the cable in pixels",
        "Convert that in mm.",
    ],
)
def test_an_extent_given_in_a_unit_is_an_amount(question):
    assert asked_kind(question) == "magnitude"
