"""A view that nothing tells of is noted where a way is told, and nowhere else."""

import pytest

from geotlm_lm.conversation.frame_questions import RELATIVE
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import answerer_saying, recording


@pytest.mark.parametrize(
    ("question", "slots", "is_noted"),
    [
        ("Which way, seen from above?", Slots("direction", Motion.LEFT), True),
        ("Does it go left, seen from the front?", Slots("verify", Motion.LEFT, verdict=True), True),
        ("Is anything touching, seen from above?", Slots("contact", verdict=True), False),
        ("Is it moving at all, seen from above?", Slots("moving", verdict=True), False),
    ],
)
def test_the_note_stands_with_a_way_alone(bundle, question, slots, is_noted):
    answerer = answerer_saying(bundle, {"*": bundle.grammar.sentence(slots)})
    answer = answerer.ask(answerer.encode(recording()), question)
    assert any("how the camera stands" in note for note in answer.notes) is is_noted


def test_which_of_the_two_moves_is_never_told(bundle):
    said = bundle.grammar.sentence(Slots("direction", Motion.LEFT))
    answerer = answerer_saying(bundle, {"*": said})
    answer = answerer.ask(
        answerer.encode(recording()), "Is it the sensor or the object that moves?"
    )
    assert (answer.text, answer.abstained) == (RELATIVE, True)
