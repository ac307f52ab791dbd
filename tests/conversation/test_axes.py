"""Axes of the image named in a claim."""

import pytest

from geotlm_lm.conversation.axes import asks_components, claimed_axis
from geotlm_lm.conversation.claims import claimed, claims_motion
from geotlm_lm.core.labels import Motion

ACROSS = frozenset({Motion.LEFT, Motion.RIGHT})
ALONG = frozenset({Motion.UP, Motion.DOWN})


@pytest.mark.parametrize(
    ("text", "motions"),
    [
        ("is it moving horizontally?", ACROSS),
        ("does it slide sideways?", ACROSS),
        ("moving vertically?", ALONG),
        ("is it sliding along y?", ALONG),
        ("is it moving along the x axis?", ACROSS),
        ("does it go in the y direction?", ALONG),
        ("is it moving along the z axis?", frozenset({Motion.PRESS, Motion.RELEASE})),
        ("how far in x and in y?", frozenset()),
        ("horizontally or vertically?", frozenset()),
        ("does it slide along the x axis?", ACROSS),
        ("is it moving in the y-axis?", ALONG),
        ("does it go in x?", ACROSS),
        ("Is it translating along the image's x axis?", ACROSS),
        ("is it sliding in y direction?", ALONG),
        ("does it move in x and y?", frozenset()),
        ("does it move in xenon?", frozenset()),
        ("does it turn about the x axis?", frozenset()),
        ("is it moving?", frozenset()),
        ("is the movement horizontal?", ACROSS),
        ("is its motion mostly vertical?", ALONG),
        ("is the motion horizontal or the motion vertical?", frozenset()),
        ("is it a horizontal slide?", ACROSS),
        ("does it turn about a vertical axis?", frozenset()),
        ("is a horizontal cap turning?", frozenset()),
        ("does the vertical sensor show a slide?", frozenset()),
    ],
)
def test_an_axis_stands_for_both_ways_along_it(text, motions):
    assert claimed_axis(text) == motions


@pytest.mark.parametrize("text", ["Up, down, sideways, what is it?", "sideways or up?"])
def test_a_choice_among_ways_claims_no_axis(text):
    assert claimed(text) != ACROSS


@pytest.mark.parametrize(
    "text",
    ["Is it moving horizontally?", "moving sideways?", "Does it slide along the x axis?"]
    + ["Is it moving in the x-axis?", "Did it move along x?"],
)
def test_an_axis_is_a_claim(text):
    assert claims_motion(text)
    assert claimed(text) == ACROSS


@pytest.mark.parametrize(
    "text",
    [
        "how much in x and in y?",
        "how many pixels in x and how many in y?",
        "give me dx and dy",
        "delta x, delta y",
        "translation vector in px?",
        "what are the horizontal and vertical components",
        "how fast does it go along x and along y?",
        "at what angle does it slide?",
        "dx px",
    ],
)
def test_parts_of_a_slide_are_asked_for(text):
    assert asks_components(text)


@pytest.mark.parametrize(
    "text", ["how far along x?", "is it moving along x or y?", "is dx positive?", "x and y"]
)
def test_one_axis_asks_for_no_parts(text):
    assert not asks_components(text)


@pytest.mark.parametrize(
    "text",
    [
        "does the motion vector point up?",
        "is there a slip vector?",
        "which way does the motion vector point?",
        "is the x and y displacement zero?",
    ],
)
def test_a_verdict_on_a_vector_asks_for_no_parts(text):
    assert not asks_components(text)


@pytest.mark.parametrize("text", ["what is the motion vector?", "is it possible to get dx and dy?"])
def test_a_vector_that_is_asked_for_has_parts(text):
    assert asks_components(text)
