"""How far it went where the question takes a motion for granted: right or wrong, that is said."""

import pytest

from geotlm_lm.core.labels import Motion
from tests.answering.scripted import feeling, measuring, recording

TURNED, SLID = "About 13 degrees of turning", "About 3.6 pixels of sliding"


@pytest.mark.parametrize(
    ("motion", "question", "text", "decided"),
    [
        (
            Motion.COUNTERCLOCKWISE,
            "How many degrees clockwise did it turn?",
            f"But no, it goes counterclockwise in the camera image. {TURNED}",
            "it does not",
        ),
        (
            Motion.RIGHT,
            "How many mm did it slide to the left?",
            f"But no, it goes right in the camera image. {SLID}",
            "it does not",
        ),
        (
            Motion.RIGHT,
            "How far did it slide to the right?",
            f"That holds: it goes right in the camera image. {SLID}",
            "it holds",
        ),
        (
            Motion.CLOCKWISE,
            "The image is mirrored. How far did it turn counterclockwise?",
            "That holds: it goes counterclockwise in the camera image with the mirror undone. "
            f"{TURNED}",
            "it holds",
        ),
    ],
)
def test_a_motion_taken_for_granted_is_judged_and_its_amount_told(
    bundle, motion, question, text, decided
):
    answerer = measuring(bundle, motion, "px" if motion is Motion.RIGHT else "deg")
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, question)
    assert answer.text.startswith(text)
    assert (answer.kind, answer.decided, answer.abstained) == ("premise", decided, False)
    assert answer.amount is not None
    *words, streamed = answerer.stream(encoded, question)
    assert ("".join(words), streamed.text) == (answer.text, answer.text)


@pytest.mark.parametrize(
    ("motion", "unit", "question", "text"),
    [
        (
            Motion.RIGHT,
            "px",
            "How far did it turn?",
            f"But no, it goes right in the camera image. {SLID}",
        ),
        (Motion.RIGHT, "px", "How far did it slide?", SLID),
        (Motion.CLOCKWISE, "deg", "How far did it go?", TURNED),
        (Motion.CLOCKWISE, "deg", "How many pixels?", TURNED),
    ],
)
def test_a_turn_asked_after_of_what_slides_is_put_right(bundle, motion, unit, question, text):
    answerer = measuring(bundle, motion, unit)
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.text.startswith(text)
    assert (answer.kind, answer.amount.unit) == ("magnitude", unit)


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


@pytest.mark.parametrize(
    ("question", "text"),
    [
        ("How many radians?", "That is 0.23 radians, likely 0.19 to 0.24."),
        ("How far per frame?", "That is 4.3 degrees per frame on average, likely 3.7 to 4.7."),
    ],
)
def test_an_amount_is_told_in_the_unit_it_is_asked_for_in_as_well(bundle, question, text):
    answerer = measuring(bundle, Motion.CLOCKWISE, "deg", deg=12.0)
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.text == f"About 13 degrees of turning, likely 11 to 14. {text}"
    assert answer.amount.unit == "deg"
