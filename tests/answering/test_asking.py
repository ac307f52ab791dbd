"""What is answered before, beside or after the model: places, amounts claimed, two questions."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from geotlm_lm.answering import OPEN_QUESTION
from geotlm_lm.answering.answer import Encoded
from geotlm_lm.answering.hearing import AMOUNT_QUESTION
from geotlm_lm.backbone.view import View
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import filled_size
from geotlm_lm.core.labels import Motion
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.language.parse_answer import Slots
from geotlm_lm.model import Perception
from tests.answering.scripted import answerer_saying, measuring, recording


@pytest.mark.parametrize(
    ("question", "text", "decided"),
    [
        ("Did it turn 12 degrees?", "Yes, about 13 degrees of turning", "yes"),
        ("Did it turn 45 degrees?", "No, about 13 degrees of turning", "no"),
        ("Has it turned a quarter turn?", "No, about 13 degrees of turning", "no"),
        ("more than 10 degrees?", "Yes, about 13 degrees of turning", "yes"),
        ("did it turn less than 10 degrees?", "No, about 13 degrees of turning", "no"),
        ("did it move 12 px?", "No, about 13 degrees of turning", "no"),
        ("Did it turn 12 degrees clockwise?", "Yes, about 13 degrees of turning", "yes"),
        ("Did it turn 12 degrees ccw?", "No, it goes clockwise in the camera image.", "no"),
        ("Did it slide 3 mm?", "No, it goes clockwise in the camera image.", "no"),
    ],
)
def test_an_amount_that_is_claimed_is_judged_by_what_is_measured(bundle, question, text, decided):
    answerer = measuring(bundle, Motion.CLOCKWISE, "deg", deg=12.0)
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.text.startswith(text)
    assert (answer.decided, answer.told_by) == (decided, "rule")
    assert answer.confidence > 0.5


def test_millimetres_are_judged_only_where_the_size_of_a_pixel_is_known(bundle):
    answerer = measuring(bundle, Motion.LEFT, "px", px=14.0)
    encoded = answerer.encode(recording())
    unknown = answerer.ask(encoded, "Did it slide 3 mm?")
    assert unknown.abstained
    assert unknown.text.startswith("I cannot judge millimetres: about ")
    known = answerer.ask(encoded, "Did it slide 3 mm?", frame=FrameSpec(mm_per_px=0.01))
    assert (known.decided, known.amount.unit) == ("no", "mm")


def test_two_questions_are_answered_both(bundle):
    answerer = measuring(bundle, Motion.CLOCKWISE, "deg", deg=12.0)
    answer = answerer.ask(answerer.encode(recording()), "Which way is it turning and how far?")
    assert answer.text.startswith("Clockwise, in the camera image. About 13 degrees of turning")
    assert (answer.direction, answer.amount.value) == (Motion.CLOCKWISE, 13.0)


def test_where_the_contact_is_is_read_off_the_mask(bundle):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."}, contact_threshold=0.0)
    answer = answerer.ask(answerer.encode(recording()), "Where is the contact?")
    assert answer.text.startswith("In the middle of the camera image: its middle is around ")
    assert (answer.kind, answer.abstained, answer.direction) == ("contact", False, None)
    blind = answerer_saying(bundle, {"*": "Left, in the camera image."}, contact_threshold=1.1)
    assert blind.ask(blind.encode(recording()), "Where is the contact?").abstained


def test_a_statement_that_holds_no_known_fact_is_not_answered_with_a_motion(bundle):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."})
    answer = answerer.ask(answerer.encode(recording()), "The image is blurred.")
    assert answer.text.startswith("I read no fact about the recording in that")
    assert answer.abstained


def test_an_image_turned_by_a_quarter_is_told_as_it_is_turned_back(bundle):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."})
    asked = "The image is rotated by 90 degrees clockwise. Which way does it slide?"
    answer = answerer.ask(answerer.encode(recording()), asked)
    assert answer.text == "Down, in the camera image turned back by 90 degrees counterclockwise."
    assert answer.direction is Motion.DOWN
    assert answer.frame == FrameSpec(image_quarter_turn="clockwise")


@pytest.mark.parametrize(
    ("said", "begins"),
    [
        ("The camera is mounted sideways", "I cannot tell a direction without the way it is"),
        ("The image is rotated by 30 degrees", "I tell directions for an image turned by 90, 180"),
    ],
)
@pytest.mark.parametrize("asks", [".", ". Which way does it slide?", ". Which way and how far?"])
def test_a_turn_that_lacks_something_is_asked_for_and_no_direction_is_told(
    bundle, said, begins, asks
):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."})
    answer = answerer.ask(answerer.encode(recording()), said + asks)
    assert answer.text.startswith(begins)
    assert (answer.abstained, answer.kind, answer.direction) == (True, "frame", None)


def test_facts_that_were_read_before_a_turn_that_lacks_something_hold(bundle):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."})
    session = answerer.session(answerer.encode(recording()))
    asked = session.ask("The image is mirrored. The camera is mounted sideways. Which way?")
    assert (asked.abstained, session.frame) == (True, FrameSpec(image_mirrored=True))


@pytest.mark.parametrize(
    ("question", "direction"),
    [
        ("Which way, in the camera image?", Motion.LEFT),
        ("and from the sensor's side?", Motion.LEFT),
        ("As the camera sees it?", Motion.LEFT),
        ("Which way?", Motion.RIGHT),
    ],
)
def test_a_view_named_in_a_question_holds_for_it(bundle, question, direction):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."})
    session = answerer.session(answerer.encode(recording()), FrameSpec(viewpoint="object"))
    assert session.ask(question).direction is direction
    assert session.frame.viewpoint == "object"


@pytest.mark.parametrize("said", ["A slide.", "A rotation."])
def test_the_kind_of_motion_is_that_of_the_open_answer(bundle, said):
    opened = bundle.grammar.sentence(Slots("direction", Motion.CLOCKWISE))
    answerer = answerer_saying(bundle, {"*": said, OPEN_QUESTION: opened})
    answer = answerer.ask(answerer.encode(recording()), "What kind of motion is it?")
    assert (answer.text, answer.decided) == ("A rotation.", "rotation")


@pytest.mark.parametrize(
    ("question", "field", "value"),
    [
        ("No, the image is mirrored.", "image_mirrored", True),
        ("Wrong, the sensor moved.", "actor", "sensor"),
        ("Nope. It is a left-hand thread.", "thread", "left"),
    ],
)
def test_a_correction_that_states_a_fact_is_noted(bundle, question, field, value):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."})
    session = answerer.session(answerer.encode(recording()))
    session.ask("Which way?")
    assert session.ask(question).text.startswith("Noted: ")
    assert getattr(session.frame, field) == value
    assert session.history[-1].question == question


def test_a_correction_that_asks_is_answered_and_one_that_doubts_is_not_given_in_to(bundle):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."})
    session = answerer.session(answerer.encode(recording()))
    session.ask("Which way?")
    assert session.ask("No, which way does the sensor move?").text.startswith("The sensor goes")
    assert session.ask("No, it goes right.").text.startswith("I ")
    assert session.ask("No, it goes right.").direction is Motion.RIGHT


def test_an_amount_says_between_which_frames_of_a_longer_recording_it_is(bundle):
    answerer = measuring(bundle, Motion.CLOCKWISE, "deg", deg=12.0)
    long = answerer.encode(recording(frames=30))
    first, *_, last = long.clip.frame_numbers
    assert (first, last) != (0, 29)
    told = answerer.ask(long, AMOUNT_QUESTION).text
    assert told.startswith(f"About 13 degrees of turning between frames {first} and {last}, likely")
    for whole in (recording(), recording(frames=2)):
        told = answerer.ask(answerer.encode(whole), AMOUNT_QUESTION).text
        assert told.startswith("About 13 degrees of turning, likely ")
    asked = answerer.encode(recording(frames=30), span=(3, 9))
    assert "between frames" not in answerer.ask(asked, AMOUNT_QUESTION).text


def test_a_claim_in_pixels_is_judged_in_pixels_whatever_their_size(bundle):
    answerer = measuring(bundle, Motion.LEFT, "px", px=14.0)
    answer = answerer.ask(
        answerer.encode(recording()), "Did it slide more than 1 px?", frame=FrameSpec(mm_per_px=0.1)
    )
    assert (answer.decided, answer.amount.unit) == ("yes", "px")


def test_both_answers_of_two_fill_the_fields(bundle):
    answerer = measuring(bundle, Motion.CLOCKWISE, "deg", deg=12.0)
    answer = answerer.ask(answerer.encode(recording()), "How far? Which way does it turn?")
    assert (answer.direction, answer.amount.value) == (Motion.CLOCKWISE, 13.0)


def touched_at(row, column, rows=240, columns=320):
    """A clip whose mask is 1 in one patch of a view over the whole image."""
    clip = recording()
    frames = np.zeros((len(clip), rows, columns, 3), np.uint8)
    mask = torch.zeros(1, 14, 14)
    mask[0, row, column] = 1
    with torch.no_grad():
        geometry = DGR(4).pool(torch.zeros(1, 2, 14, 14, 2), torch.zeros(1, 14, 14, 2), mask)
    token, (filled_rows, filled_columns) = torch.zeros(1, 4), filled_size(rows, columns)
    view = View(picture_height_px=filled_rows, picture_width_px=filled_columns)
    perception = Perception(token, geometry, token, (view,), None)
    return Encoded(replace(clip, frames=frames, background=frames[0]), perception, {})


@pytest.mark.parametrize(
    ("patch", "size", "part", "centre"),
    [
        ((1, 2), (240, 320), "upper left", (57, 26)),
        ((7, 12), (240, 320), "right middle", (286, 129)),
        ((7, 6), (480, 640), "middle", (297, 257)),
        # Idle gel fills up a square that a portrait picture leaves: it begins at 49 of 224.
        ((12, 9), (320, 240), "lower right", (196, 286)),
    ],
)
def test_the_contact_is_in_its_place_in_the_picture_whatever_was_looked_at(
    bundle, patch, size, part, centre
):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."}, contact_threshold=0.0)
    answer = answerer.ask(touched_at(*patch, *size), "Where is the contact?")
    told = f"In the {part} of the camera image: its middle is around {centre[0]} px from the left"
    assert answer.text.startswith(told)
    assert answer.evidence["contact_centre_px"] == pytest.approx(centre, abs=1)
    assert "covers about 1% of the image" in answer.text


@pytest.mark.parametrize(
    ("question", "text"),
    [
        ("What is the resolution?", "The frames are 64 px wide and 48 px high."),
        ("How many frames per second?", "The recording has 25 frames per second."),
        ("How many frames are there?", "I look at few frames of a recording, here at 0, 1, 2, 3,"),
    ],
)
def test_what_is_asked_of_the_recording_is_told_without_the_model(bundle, question, text):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."})
    answer = answerer.ask(answerer.encode(recording(fps=25.0)), question)
    assert answer.text.startswith(text)
    assert (answer.kind, answer.direction, answer.amount) == ("frame", None, None)
    assert (answer.told_by, answer.abstained, answer.confidence) == ("rule", False, 1.0)
    assert answerer.bundle.speaker.heard == []


def test_a_recording_without_a_frame_rate_says_so(bundle):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."})
    answer = answerer.ask(answerer.encode(recording()), "What is the frame rate?")
    assert answer.text == "The recording gives no frame rate; give it by fps."


@pytest.mark.parametrize(
    "question", ["Which way and how fast?", "How fast? Which way does it turn?"]
)
def test_of_two_answers_one_that_is_withheld_makes_both_abstain(bundle, question):
    answerer = measuring(bundle, Motion.CLOCKWISE, "deg", deg=12.0)
    answer = answerer.ask(answerer.encode(recording()), question)
    assert "I cannot tell the speed: " in answer.text
    assert (answer.abstained, answer.direction) == (True, Motion.CLOCKWISE)


@pytest.mark.parametrize(
    ("question", "text", "kind"),
    [
        ("Which half is touched?", "In the middle of the camera image: ", "contact"),
        (
            "In which frame is that told?",
            "I tell directions in this frame: camera image, seen from the",
            "frame",
        ),
        ("How much force is there?", "I cannot tell force or depth;", "refusal"),
        ("How big is the nut?", "I tell how far it turns or slides and how much", "refusal"),
    ],
)
def test_what_no_model_is_asked_is_said_whatever_kind_it_passes_for(bundle, question, text, kind):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."}, contact_threshold=0.0)
    frame = FrameSpec(viewpoint="object")
    answer = answerer.ask(answerer.encode(recording()), question, frame=frame)
    assert (answer.text[: len(text)], answer.kind) == (text, kind)
    assert answerer.bundle.speaker.heard == []
