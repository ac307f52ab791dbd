"""Amounts of the sensor, along an axis, in parts and after a context, through the seam."""

import pytest

from tests.answering.scripted import answerer_saying, recording


@pytest.fixture(scope="module")
def sliding(bundle):
    """An answerer whose model says that a clip slides left, and the clip."""
    said = {
        "*": "Left, in the camera image.",
        "How far did it go?": "An amount of sliding, as measured.",
        "How fast did it go?": "A speed of sliding, as measured.",
        "how far did it move?": "An amount of sliding, as measured.",
    }
    answerer = answerer_saying(bundle, said, temperature=0.1)
    return answerer, answerer.encode(recording())


@pytest.fixture
def ask(sliding):
    answerer, clip = sliding
    return lambda question: answerer.ask(clip, question)


def test_how_far_the_sensor_moved_is_how_far_the_object_did(ask):
    answer = ask("How far did the sensor move?")
    assert answer.amount.unit == "px"
    assert answer.frame.actor == "sensor"


def test_a_claim_of_the_sensor_s_motion_is_judged(ask):
    answer = ask("Did the sensor move left?")
    assert (answer.decided, answer.text) == ("no", "No, the sensor goes right in the camera image.")
    assert ask("Did the sensor move right?").decided == "yes"


def test_after_the_sensor_is_said_to_move_the_object_can_be_asked_about(sliding):
    answerer, clip = sliding
    session = answerer.session(clip)
    session.ask("The sensor moved, not the object.")
    assert session.ask("Which way did it move?").text.startswith("The sensor goes right")
    assert session.ask("Which way did the object move?").text == "Left, in the camera image."


@pytest.mark.parametrize(
    ("question", "begins"),
    [
        ("How far did it move vertically?", "But no, it goes left in the camera image. About"),
        ("How far does it slide sideways?", "About"),
        ("How far did it move in x?", "About"),
        ("How much did it move in x and in y?", "Left, in the camera image. About"),
        ("How far did it move along the y axis?", "But no, it goes left in the camera image. Ab"),
    ],
)
def test_an_amount_along_another_axis_is_told_of_the_way_it_goes(ask, question, begins):
    assert ask(question).text.startswith(begins)


@pytest.mark.parametrize(
    "question",
    [
        "I moved the arm to the right. Which way does it slide?",
        "Yesterday the answer was right. Which way is it today?",
        "We pushed it 30 degrees counterclockwise. Which way is it moving?",
    ],
)
def test_a_context_is_no_claim(ask, question):
    assert ask(question).decided == "left"


@pytest.mark.parametrize(
    "text", ["The sensor is mounted on the right finger.", "My sensor's cable points up."]
)
def test_a_setup_is_not_judged(ask, text):
    assert ask(text).abstained


def test_three_parts_are_all_answered(ask):
    text = ask("Which way does it slide, how far and how fast?").text
    assert text.startswith("Left, in the camera image. About")


def test_the_width_of_the_picture_tells_millimetres(sliding):
    answerer, clip = sliding
    answer = answerer.ask(clip, "The image is 16 mm wide. How far did it go?")
    assert answer.amount.unit == "mm"
    columns = clip.clip.frames.shape[2]
    assert answer.frame.mm_per_px == pytest.approx(16 / columns, rel=1e-4)
    session = answerer.session(clip)
    session.ask("The field of view is 16 mm x 12 mm.")
    assert session.ask("How far did it go?").amount.unit == "mm"


def test_what_is_open_about_the_image_is_asked_for(ask):
    answer = ask("Is the image mirrored?")
    assert (answer.abstained, answer.kind) == (True, "frame")
    assert answer.text.startswith("No touch tells whether the image is mirrored")
