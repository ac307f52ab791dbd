"""The reasons behind an answer: whose words they are, in which frame, and that they end in it."""

import pytest

from geotlm_lm.checkpoint import Calibration
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import answerer_saying, believed, feeling, recording


def test_reasons_end_in_the_answer_and_say_whose_words_they_are(bundle):
    answerer = feeling(bundle, "clockwise")
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, "Which way?")
    why = answerer.why(encoded, answer)
    assert why.steps[0].startswith("Contact fills ")
    assert why.steps[-1] == "Therefore: Clockwise, in the camera image."
    assert why.steps[-2].startswith("The answer is told in this frame: camera image")
    assert why.source == "by rule, from the geometry the model read; not in its own words"


def test_reasons_of_an_answer_in_another_frame_say_where_their_own_ways_are_seen(bundle):
    answerer = feeling(bundle, "clockwise")
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, "Which way?", frame=FrameSpec(image_mirrored=True))
    _, measured, sums, _, frame, conclusion = answerer.why(encoded, answer).steps
    assert measured.startswith("In the camera image the whole contact ")
    assert "wise in the camera image" in sums
    assert frame.startswith("The answer is told in this frame: camera image with the mirror undone")
    assert conclusion.startswith("Therefore: It turns counterclockwise, ")


@pytest.mark.parametrize("said", [Motion.CLOCKWISE, Motion.LEFT])
def test_a_model_trained_for_evidence_gives_reasons_in_its_words_where_it_feels_so(bundle, said):
    sentence = bundle.grammar.sentence(Slots("evidence", said))
    belief = believed("clockwise", "press", mm=0.4)
    answerer = answerer_saying(bundle, {"*": sentence}, belief=belief)
    encoded = answerer.encode(recording())
    why = answerer.why(encoded, answerer.ask(encoded, "Which way?"))
    assert why.steps[0].startswith("Contact fills ")
    assert why.steps[-3] == (
        "Measured from the first frame to the last: a turn clockwise of about 12 degrees, likely "
        "11 to 13; a slide left of about 0 px, likely 0 to 0.00047; a growth of the contact of "
        "about 0.2 mm, likely 0.14 to 0.2."
    )
    assert why.steps[-1].startswith("Therefore: It turns clockwise, about 12 degrees, and presses")
    assert (sentence in " ".join(why.steps)) == (said is Motion.CLOCKWISE)
    assert why.source.startswith("sentences 2 to 4 in") == (said is Motion.CLOCKWISE)


def test_reasons_of_an_answer_that_was_withheld_conclude_nothing_in_the_models_words(bundle):
    said = bundle.grammar.sentence(Slots("evidence", Motion.CLOCKWISE))
    answerer = answerer_saying(bundle, {"*": said}, belief=believed("clockwise"))
    answerer.bundle.calibration = Calibration(contact_threshold=1.0)
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, "Which way?")
    assert answer.abstained
    why = answerer.why(encoded, answer)
    assert not any(said.split(".")[0] in step for step in why.steps)
    assert why.source == "by rule, from the geometry the model read; not in its own words"
