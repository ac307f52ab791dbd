"""What is told before an open question is a context; the claim of a question is its own."""

import pytest

from geotlm_lm.conversation.context import without_context


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        (
            "I moved the robot arm to the right. Which way does the object slide?",
            "Which way does the object slide?",
        ),
        (
            "We commanded a 30 degree counterclockwise wrist rotation. Which way does it rotate?",
            "Which way does it rotate?",
        ),
        (
            "Yesterday the answer was counterclockwise. Which way is it today?",
            "Which way is it today?",
        ),
        ("The gripper came down. How far did it slide?", "How far did it slide?"),
        ("We pushed 3 mm. Then we stopped. How far did it go?", "How far did it go?"),
        ("The cable hangs on the left. Tell me the direction.", "Tell me the direction."),
    ],
)
def test_a_context_is_left_out(text, asked):
    assert without_context(text) == asked


@pytest.mark.parametrize(
    "text",
    [
        "Which way does it turn?",
        "It is a cap. Which way does it turn?",
        "I moved it to the right. Did it slide left?",
        "Is it turning clockwise? Which way?",
        "A) left. B) right. Which way?",
        "It goes left or right. Which way?",
        "Suppose it were played backwards and pushed up. Which way?",
        "It turned clockwise. Are you sure?",
        "I think it turned left.",
    ],
)
def test_all_else_stays(text):
    assert without_context(text) == text


@pytest.mark.parametrize(
    "question",
    [
        "The image is mirrored and the cap turns left. Which way does it turn?",
        "The clip is played backwards and it goes left. Which way does it go?",
        "I look from the object's side and it turns left. Which way does it turn?",
        "The recording is upside down and it moves up. Which way does it move?",
    ],
)
def test_what_is_said_of_the_image_or_the_view_stays(question):
    assert without_context(question) == question


@pytest.mark.parametrize(
    ("question", "asked"),
    [
        ("The gripper turned clockwise. Is the object slipping?", "Is the object slipping?"),
        ("The robot moved left. Did the object slip?", "Did the object slip?"),
        ("I lift the bottle. Is it slipping in my hand?", "Is it slipping in my hand?"),
        ("The robot rotated the part by 30 degrees. Did it slip?", "Did it slip?"),
        ("I moved it 5 mm to the left. Did it move?", "Did it move?"),
    ],
)
def test_what_somebody_did_is_no_claim_about_what_is_felt(question, asked):
    assert without_context(question) == asked


@pytest.mark.parametrize(
    "question",
    [
        "I see the coin is going up; how far?",
        "now: I think it is spinning clockwise; how fast?",
        "We noticed it slips to the left. How far?",
        "It turned clockwise. How fast?",
    ],
)
def test_what_is_taken_for_granted_of_the_object_stays(question):
    assert without_context(question) == question


def test_what_went_before_the_recording_is_context():
    asked = "Where does it go now?"
    before = "The bead rolled to the left twice, then this clip was recorded."
    assert without_context(f"{before} {asked}") == asked


def test_what_somebody_did_is_context_of_a_question_for_contact():
    asked = "Is there anything in the hand?"
    assert without_context(f"The robot closed its hand and missed. {asked}") == asked


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        (
            "This recording was made on the left gripper finger. Which way does it move?",
            "Which way does it move?",
        ),
        ("I lifted it. Is it still touching?", "Is it still touching?"),
    ],
)
def test_where_it_was_recorded_and_what_was_done_before_contact_are_context(text, rest):
    assert without_context(text) == rest
