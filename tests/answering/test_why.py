"""The reasons behind an answer: by rule, in which frame, and that they end in it."""

from geotlm_lm.core.frame_spec import FrameSpec
from tests.answering.scripted import believed, feeling, recording

SOURCE = "by rule, from the geometry the model read"


def test_reasons_end_in_the_answer_and_say_whose_words_they_are(bundle):
    answerer = feeling(bundle, belief=believed("clockwise", "press", mm=0.4))
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, "Which way?")
    why = answerer.why(encoded, answer)
    assert why.steps[0].startswith("Contact fills ")
    assert why.steps[-3] == (
        "Measured from the first frame to the last: a turn clockwise of about 12 degrees, likely "
        "11 to 13; a slide left of about 0 px, likely 0 to 0.00047; a growth of the contact of "
        "about 0.2 mm, likely 0.14 to 0.2."
    )
    assert why.steps[-2].startswith("The answer is told in this frame: camera image")
    assert why.steps[-1].startswith("Therefore: It turns clockwise, about 12 degrees, and presses")
    assert why.source == SOURCE


def test_reasons_of_an_answer_in_another_frame_say_where_their_own_ways_are_seen(bundle):
    answerer = feeling(bundle, "clockwise")
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, "Which way?", frame=FrameSpec(image_mirrored=True))
    _, measured, sums, _, frame, conclusion = answerer.why(encoded, answer).steps
    assert measured.startswith("In the camera image the whole contact ")
    assert "wise in the camera image" in sums
    assert frame.startswith("The answer is told in this frame: camera image with the mirror undone")
    assert conclusion.startswith("Therefore: It turns counterclockwise, ")


def test_reasons_of_an_answer_that_was_withheld_name_no_way(bundle):
    answerer = feeling(bundle, "clockwise", contact_threshold=1.0)
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, "Which way?")
    assert (answer.abstained, answer.direction) == (True, None)
    why = answerer.why(encoded, answer)
    assert why.steps[-1].startswith("Therefore: I cannot name a direction")
    assert not any("add up" in step for step in why.steps)
    assert why.source == SOURCE


def test_why_asked_in_words_gives_the_geometry_and_the_conclusion(bundle):
    answerer = feeling(bundle, "clockwise")
    text = answerer.ask(answerer.encode(recording()), "why").text
    assert text.startswith("Contact fills ")
    assert "Therefore: it turns clockwise" in text
