"""An answer with what it may be besides."""

from dataclasses import replace

import pytest

from geotlm_lm.answering.alternatives import AT_MOST, NOTHING_ELSE, with_alternatives
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import answerer_saying, recording


@pytest.fixture
def told(bundle):
    said = bundle.grammar.sentence(Slots("direction", Motion.LEFT))
    answerer = answerer_saying(bundle, {"*": said})
    return answerer.ask(answerer.encode(recording()), "Which way does it go?")


def test_the_likeliest_others_are_told_in_their_order(told):
    options = {"left": 0.9, "press": 0.06, "up": 0.03, "down": 0.006, "still": 0.001}
    answer = with_alternatives(replace(told, options=options, decided="left", confidence=0.9))
    end = "That is 90% probable. Next likeliest: pressing in 6%, up 3%, down 0.6%."
    assert answer.text == f"{told.text} {end}"
    assert answer.options == options


def test_what_would_be_told_as_nothing_is_left_out(told):
    options = {"left": 0.997, "up": 0.003}
    answer = with_alternatives(replace(told, options=options, decided="left", confidence=0.997))
    assert answer.text.endswith(f"That is 100% probable. {NOTHING_ELSE}")


def test_what_is_withheld_without_a_probability_stays_as_it_is(told):
    withheld = replace(told, options={}, decided=None, abstained=True)
    assert with_alternatives(withheld) is withheld


def test_they_are_told_in_the_frame_of_the_answer(bundle):
    said = bundle.grammar.sentence(Slots("direction", Motion.LEFT))
    answerer = answerer_saying(bundle, {"*": said})
    encoded = answerer.encode(recording())
    plain = answerer.ask(encoded, "What else could it be?")
    mirrored = answerer.ask(encoded, "What else could it be?", frame=FrameSpec(image_mirrored=True))
    assert mirrored.text.startswith("It slides right, about ")
    assert plain.text.startswith("Left, in the camera image. That is 97% probable.")
    assert plain.text.count("%") <= AT_MOST + 2
