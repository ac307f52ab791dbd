"""Two programs come to the same where no made recording tells them apart; what is read is graded by
the program and by what it comes to.
"""

from dataclasses import replace
from itertools import cycle
from types import SimpleNamespace

import numpy as np
import pytest

from geotlm_lm.answering import Answerer
from geotlm_lm.benchmarks import reading
from geotlm_lm.benchmarks.harness import Row, Run
from geotlm_lm.benchmarks.reading import (
    OWN_ANSWERS,
    PROGRAM,
    READING,
    VALUE,
    Graded,
    come_to_the_same,
    graded_rows,
    made_track,
)
from geotlm_lm.benchmarks.rendering import tables
from geotlm_lm.query.lines import read
from geotlm_lm.query.program import asks_of_two
from geotlm_lm.training.calibration import calibrated_reader
from geotlm_lm.training.grammar import Pair
from geotlm_lm.training.labelled import WRITERS, Labelled, written_by
from tests.answering.scripted import ScriptedReader, feeling
from tests.tiny_bundle import tiny_bundle, tiny_reader


@pytest.mark.parametrize(("one", "other", "are_same"), [
    ("turn", "not not turn", True),
    ("turn", "slide", False),
    ("tighten", "loosen", False),
    ("unit deg amount turn", "amount turn", True),
    ("unit rad amount turn", "amount turn", False),
    ("amount turn", "path turn", False),
    ("amount slide", "unit mm amount slide", False),
    ("begin contact", "first-time touch", True),
    ("begin first turn-events", "begin first cw-events", False),
    ("end contact", "begin contact", False),
    ("way all", "way turn", False),
    ("way all", "story", False),
    ("way all", "sure", False),
    ("choose A cw | B ccw", "choose B ccw | A cw", True),
    ("choose A cw | B ccw", "choose B cw | A ccw", False),
    ("record amount turn , amount slide end", "record amount slide , amount turn end", False),
    ("place", "place", True),
    ("cannot force", "cannot look", False),
    ("same way all", "opposite way all", False),
    ("fact mirrored ; turn", "turn", False),
    ("turn ; slide", "turn", False),
])  # fmt: skip
def test_programs_are_told_apart_by_their_values(one, other, are_same):
    assert come_to_the_same(read(one), read(other)) == are_same


def test_a_made_recording_holds_together():
    for seed in range(20):
        track = made_track(np.random.default_rng(seed))
        ends = [event.end for event in track.events]
        assert max(ends) <= len(track) - 1
        total = np.sum([[e.twist.turn_deg, e.twist.right_px] for e in track.events], axis=0)
        assert track.twists.sum(axis=0)[:2] == pytest.approx(total)


@pytest.mark.parametrize(("meant", "line", "right"), [
    ("> amount turn #1", "> amount turn #1", (True, True)),
    ("> amount turn #1", "< #1 amount turn", (False, True)),
    ("> amount turn #1", "> amount slide #1", (False, False)),
    ("mirror again", "mirror way turn", (False, True)),
    ("mirror again", "mirror way all", (False, False)),
])  # fmt: skip
def test_a_reading_is_graded_by_program_and_by_value(meant, line, right):
    text = "Is it more than 20 degrees?"
    graded = reading.grade(Labelled(text, (meant,)), ScriptedReader({text: line}))
    assert (graded.program, graded.value) == right


def test_doubt_is_held_against_the_right_program():
    own = [Graded("time/a", 0.9, True, True), Graded("time/b", 0.9, False, True)]
    own += [Graded("form/c", 0.5, False, False), Graded("", 0.5, True, True)]
    program, value = graded_rows("some", own, seed=0)
    assert (program.variant, program.right) == (PROGRAM, 0.5)
    assert (value.variant, value.right) == (VALUE, 0.75)
    assert (program.detail["sure"], program.detail["sure_and_wrong"]) == (0.5, 0.5)
    assert [each.cause for each in own] == ["time", "time", "form", ""]


def test_a_writer_asks_each_text_once():
    pairs = list(written_by(WRITERS[0], seed=0))
    assert {pair.families[0].rpartition(".")[2] for pair in pairs} == {"blind"}
    assert len({pair.text for pair in pairs}) > 0.98 * len(pairs) > 700


def test_every_set_is_read(monkeypatch):
    asked = Pair("Does it turn?", "turn", ("time/some.blind",))
    monkeypatch.setattr(reading, "grammar", lambda: SimpleNamespace(pairs=lambda *_: iter([asked])))
    monkeypatch.setattr(reading, "formed", lambda *_: iter([asked]))
    for name in ("corpus", "labelled", "written_by"):
        rows = [Labelled("Which way?", ("way all",))] if name == "labelled" else [asked]
        monkeypatch.setattr(reading, name, lambda *_, rows=rows: rows)
    reader = ScriptedReader({asked.text: "turn", "Which way?": "way turn"})
    answerer = Answerer(replace(tiny_bundle(), reader=reader))
    rows = [
        Row.from_dict(row.to_dict())
        for row in READING.run(Run(is_quick=True, answerer_given=answerer))
    ]
    right = {(row.case, row.variant): row.right for row in rows}
    assert right["blind", PROGRAM] == right["tune", VALUE] == 0
    assert right["adversary writer, time", VALUE] == right["turn", reading.SEEN] == 1
    page = "\n".join(tables(READING, rows))
    assert all(name in page for name in (PROGRAM, VALUE, "primitive", "wrong of these"))


def test_a_reader_is_calibrated_on_programs():
    questions = [Labelled("which way", ("way all",)), Labelled("which", ("way turn",))]
    calibrated = calibrated_reader(tiny_reader(), questions)
    assert np.isfinite(calibrated.calibration).all()
    assert calibrated.read("which way").probability < 0.5  # random weights are never right


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
