"""How far it goes, asked without "how far", "how much" or "how many", and nothing more."""

import pytest

from geotlm_lm.conversation.bare_amounts import asked_of_an_amount
from geotlm_lm.conversation.kinds import asked_kind
from geotlm_lm.conversation.motion_verbs import MOVES, SLIDES, TURNS
from geotlm_lm.conversation.two_parts import two_parts
from geotlm_lm.conversation.untold import never_told

WAYS = (
    "What angle did it {base}?",
    "Over what distance has the bottle cap {past}?",
    "which distance was it {past}",
    "Did it {base} a lot or a little?",
    "Is it {gerund} a lot or just a little?",
    "Has it {past} far or not?",
    "Total {gerund}?",
    "What was the total {base}?",
    "Could you quantify the {gerund}?",
    "please measure its {base}",
    "tell me the distance it {past}",
    "the angle the cap has {past}?",
)
IN_DEGREES = (
    "{gerund} in degrees",
    "Give me the {base} in degrees.",
    "Number of degrees it {past}?",
    "What's the number of degrees the nut has {past}?",
    "degrees {past}?",
    "Estimate the total {base} in degrees",
)


@pytest.mark.parametrize(("verb", "verbs"), [("turn", TURNS), ("slide", SLIDES), ("go", MOVES)])
def test_how_far_is_asked_in_many_ways(verb, verbs):
    for base, _, past, gerund in verbs:
        for way in WAYS:
            asked = asked_of_an_amount(way.format(base=base, past=past, gerund=gerund))
            assert asked == f"How far did it {verb}?", way
        for way in IN_DEGREES:
            asked = asked_of_an_amount(way.format(base=base, past=past, gerund=gerund))
            assert asked == f"How many degrees did it {verb}?", way


@pytest.mark.parametrize("question", ["yaw?", "what is dtheta", "twist angle", "the yaw angle?"])
def test_a_turn_is_called_yaw_too(question):
    assert asked_of_an_amount(question) == "How far did it turn?"


@pytest.mark.parametrize("question", ["plus or minus?", "Error bars?", "give me the range"])
def test_the_range_of_an_amount_is_told_with_it(question):
    assert asked_of_an_amount(question) == "How far did it go?"


def test_a_number_of_units_is_asked_without_a_motion():
    assert asked_of_an_amount("Number of pixels?") == "How many pixels?"


@pytest.mark.parametrize(
    "question",
    [
        "Is the net rotation clockwise?",
        "Which way is the total rotation?",
        "What kind of motion is the total motion?",
        "Total rotation direction?",
        "overall motion?",
        "What angle is the camera at?",
        "What distance is it viewed from?",
        "Did the gripper turn a lot or a little?",
        "Measure the slip direction",
        "Number of frames?",
        "Number of pixels in the image?",
        "Did it turn 10 degrees or not?",
        "Did it turn clockwise a lot or a little?",
        "Is it a slide in pixels?",
        "Did it turn a lot or slide a little?",
        "number of pixels in the clip",
        "total rotation of the sensor",
    ],
)
def test_what_asks_for_anything_else_is_left_alone(question):
    assert asked_of_an_amount(question) is None


@pytest.mark.parametrize("how", ["slow", "rapid", "rapidly", "swiftly"])
def test_how_rapidly_asks_for_a_speed(how):
    assert asked_kind(f"How {how} did it turn?") == "rate"


@pytest.mark.parametrize("noun", ["spin", "twist", "drift", "translation"])
def test_the_size_of_a_motion_is_an_amount(noun):
    question = f"How big is the {noun}?"
    assert never_told(question) is None
    assert asked_kind(question) == "magnitude"


def test_the_way_and_the_angle_are_asked_in_one_text():
    parts = two_parts("Which way did it turn, and what angle did it turn?")
    assert parts == ("Which way did it turn", "what angle did it turn?")
