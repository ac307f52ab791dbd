"""The next likeliest answer, named beside a doubtful one."""

from dataclasses import replace

import pytest

from geotlm_lm.core.labels import Motion
from tests.answering.scripted import answerer_saying, believed, recording


def asked(bundle, question, belief):
    answerer = answerer_saying(bundle, {"*": "A rotation."}, belief=belief)
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, question)
    return answer, answer.notes[len(encoded.clip.notes) :]


def turning(clockwise, counterclockwise):
    belief = believed("clockwise")
    ways = {Motion.CLOCKWISE: clockwise, Motion.COUNTERCLOCKWISE: counterclockwise}
    return replace(belief, ways={**belief.ways, **ways})


def test_a_doubtful_answer_comes_with_the_next_likeliest(bundle):
    answer, notes = asked(bundle, "Which way does it turn?", turning(0.6, 0.3))
    assert answer.direction is Motion.CLOCKWISE
    assert notes == ("Next likeliest, at 30%: counterclockwise.",)


def test_what_is_more_likely_wrong_than_right_is_withheld(bundle):
    answer, notes = asked(bundle, "Which way does it turn?", turning(0.45, 0.4))
    assert answer.text.startswith("I cannot tell for sure, 45%: It turns clockwise, about 12")
    assert (answer.abstained, answer.direction, answer.decided) == (True, None, None)
    assert notes == ("Next likeliest, at 40%: counterclockwise.",)


@pytest.mark.parametrize("ways", [("press",), ("clockwise", "left")])
def test_what_goes_on_besides_is_no_other_answer(bundle, ways):
    assert asked(bundle, "Which way?", believed(*ways, share=0.8))[1] in (
        (),
        ("Next likeliest, at 20%: still.",),
    )
