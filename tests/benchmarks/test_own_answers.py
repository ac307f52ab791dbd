"""What the model says itself is counted by kind of question, of what was answered."""

from itertools import cycle

from geotlm_lm.benchmarks import reading
from geotlm_lm.benchmarks.harness import Run
from geotlm_lm.benchmarks.reading import OWN_ANSWERS
from geotlm_lm.query.lines import read
from geotlm_lm.query.program import asks_of_two
from tests.answering.scripted import feeling


def test_own_answers_are_counted_by_kind(bundle, monkeypatch):
    answerer = feeling(bundle, "clockwise")
    answerer.bundle.speaker.says = lambda *given: given[-1].startswith("Yes")
    asked = ["way turn", "cw", "again"]
    monkeypatch.setattr(reading, "_questions", lambda seed: cycle(asked))
    rows = OWN_ANSWERS.run(Run(is_quick=True, answerer_given=answerer))
    shares = {row.case: (row.count, 1 - row.error) for row in rows}
    assert set(shares) >= {"all", "bool", "way"}
    assert shares["way"][1] == 0
    assert shares["bool"][1] == 1


def test_questions_ask_of_one_clip_and_lean_on_none():
    texts = reading._questions(0)
    assert len({next(texts) for _ in range(20)}) > 10
    assert not asks_of_two(read("amount turn").answers[0])
