"""How far it went where the question takes a motion for granted: right or wrong, that is said."""

import pytest

from geotlm_lm.core.labels import Motion
from tests.answering.scripted import feeling, measuring, recording


@pytest.mark.parametrize(
    ("question", "text", "abstained"),
    [
        ("How fast does it turn ccw?", "But no, it goes clockwise in the camera image.", False),
        (
            "How fast does it turn clockwise?",
            "That holds: it goes clockwise in the camera image. I cannot tell the speed: it takes "
            "3 frames and a frame rate; give it by fps.",
            True,
        ),
    ],
)
def test_where_no_speed_is_known_it_is_said_of_a_motion_that_holds(
    bundle, question, text, abstained
):
    answerer = measuring(bundle, Motion.CLOCKWISE, "deg")
    answer = answerer.ask(answerer.encode(recording()), question)
    assert (answer.text, answer.abstained, answer.amount) == (text, abstained, None)


def test_what_presses_has_no_amount(bundle):
    answerer = measuring(bundle, Motion.PRESS, "deg")
    answer = answerer.ask(answerer.encode(recording()), "How far is it pressing in?")
    assert answer.text == "That holds: it is pressing in."


def test_a_model_without_amounts_judges_the_motion_alone(bundle):
    answerer = feeling(bundle, "clockwise")
    answer = answerer.ask(answerer.encode(recording()), "How far did it turn clockwise?")
    assert answer.text == "That holds: it goes clockwise in the camera image."
