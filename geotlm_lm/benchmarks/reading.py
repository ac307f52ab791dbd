"""Understanding: whether the right program is read, and how often the model itself answers."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np

from geotlm_lm.benchmarks.cases import simulated_mixtures
from geotlm_lm.benchmarks.harness import Listing, Pivot, Row, Run, Section, whole
from geotlm_lm.benchmarks.judging import share_row, share_rows
from geotlm_lm.benchmarks.meanings import come_to_the_same
from geotlm_lm.benchmarks.rendering import right_with_interval
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.query.follow_up import resumed
from geotlm_lm.query.grammar import corpus, grammar
from geotlm_lm.query.labelled import (
    BLIND,
    SET_UPS,
    TUNE,
    WRITERS,
    Labelled,
    labelled,
    of_pairs,
    written_by,
)
from geotlm_lm.query.lines import read
from geotlm_lm.query.program import LEANING, asks_of_two, filled, head_of
from geotlm_lm.query.reader import Reader, Reading
from geotlm_lm.training.calibration import expected_calibration_error

PROGRAM, VALUE, SEEN = "right program", "right value", "of families trained on"
SURE, PAIRS, SEEN_PAIRS = 0.8, 2000, 40_000

EACH = 20
"""Questions read of each primitive, at most."""

OWN, CLIPS, OWN_EACH = "said by the model itself", 150, 10
"""Name of a row, simulated clips, and questions about each."""

BEFORE = read("way turn")
"""What is taken to have been asked before a question that leans on another."""


def _reading_rows(run: Run) -> Iterator[Row]:
    some, pairs = run.size(10_000, 40), grammar().pairs(run.seed, "test")
    sets = {
        "grammar, families held out": of_pairs(islice(pairs, run.size(PAIRS, 60))),
        "corpus, families held out": of_pairs(corpus("test"))[:some],
        "blind": labelled(BLIND)[:some],
        "set-ups": labelled(SET_UPS)[:some],
        "tune": labelled(TUNE)[:some],
    }
    for writer in WRITERS:
        asked = of_pairs(written_by(writer, run.seed))
        sets[f"{writer} writer"] = asked[:: run.size(1, 20)]
    for name, questions in sets.items():
        run.progress(f"reading, {name}", 0, 1)
        graded = [grade(question, run.answerer.bundle.reader) for question in questions]
        yield from graded_rows(name, graded, run.seed)
        for cause in sorted({each.cause for each in graded}) if name.endswith("writer") else ():
            own = [each for each in graded if each.cause == cause]
            yield from graded_rows(f"{name}, {cause}", own, run.seed)
    yield from _seen_rows(run)


class Graded(NamedTuple):
    """A question's family of phrasing ("": its own), how sure its reading is, and what is right."""

    family: str
    probability: float
    program: bool
    value: bool

    @property
    def cause(self) -> str:
        """What makes it hard: the kind that its family is of."""
        return self.family.partition("/")[0]


def grade(question: Labelled, reader: Reader) -> Graded:
    """Return whether the right program is read, or another that comes to the same."""
    reading = reader.read(question.text)
    is_met = question.is_met(reading.line)
    is_same = is_met or _comes_to_it(question, reading)
    return Graded(question.family, reading.probability, is_met, is_same)


def graded_rows(name: str, graded: Sequence[Graded], seed: int) -> Iterator[Row]:
    """Yield the shares of right programs and of right values, whole families resampled."""
    families = [each.family or str(place) for place, each in enumerate(graded)]
    exact = [each.program for each in graded]
    detail = _doubt(np.array([each.probability for each in graded]), np.array(exact))
    yield share_row(name, PROGRAM, exact, families, seed, detail=detail)
    yield share_row(name, VALUE, [each.value for each in graded], families, seed)


def _comes_to_it(question: Labelled, reading: Reading) -> bool:
    """Whether what was read comes to the same as what was meant."""
    got = resumed(reading.program, BEFORE)
    meant = (filled(read(line), reading.quantities, reading.texts) for line in question.queries)
    return any(come_to_the_same(got, resumed(each, BEFORE)) for each in meant)


def _seen_rows(run: Run) -> Iterator[Row]:
    """Yield what is read of families that were trained on, by primitive."""
    cells: dict[str, list[bool]] = defaultdict(list)
    pairs = islice(grammar().pairs(run.seed + 1, "train"), run.size(SEEN_PAIRS, 500))
    run.progress("reading, seen families", 0, 1)
    for question in of_pairs(pairs):
        cell = cells[primitive_of(question.queries[0])]
        if len(cell) < run.size(EACH, 1):
            cell.append(question.is_met(run.answerer.bundle.reader.read(question.text).line))
    for word, exact in sorted(cells.items()):
        yield Row(word, SEEN, len(exact), 1 - sum(exact) / len(exact))


def primitive_of(line: str) -> str:
    """Return the word of what a program asks first, without what stands around it, or "fact"."""
    answers = read(line).answers
    return head_of(answers[0]).word if answers else "fact"


def _doubt(sure: np.ndarray, exact: np.ndarray) -> dict[str, float]:
    is_sure = sure >= SURE
    return {
        "mean_stated": float(sure.mean()),
        "calibration_error": expected_calibration_error(sure, exact),
        "sure": float(is_sure.mean()),
        "sure_and_wrong": float((is_sure & ~exact).sum() / max(is_sure.sum(), 1)),
    }


_DOUBT = {
    "questions": "case",
    "read": "count",
    "right": "right:.3f",
    "mean stated": "mean_stated:.3f",
    "calibration error": "calibration_error:.3f",
    "read with 0.8 or more": "sure:.3f",
    "wrong of these": "sure_and_wrong:.3f",
}

READING = Section(
    name="reading",
    title="Understanding",
    about="""\
Each question is read into a program. The *right program* is the one meant in every word, but for
the order of facts and of what stands in any order; the *right value* is that of a program which
states the same and comes to the same on 50 recordings that are made up, whatever its form. Families
of phrasing, and their clauses, were kept from training. The *blind* questions, and the *set-ups*
that state one to five facts in several sentences, were written by people who had seen no template
and no rule, and nothing was chosen by them; the *tune* questions, written so too, are what readers
were chosen and calibrated by. All that two *writers* ask was kept from training, and is told apart
by what makes it hard as well. Intervals resample whole families.""",
    shares=whole(_reading_rows),
    views={
        "": Pivot(
            right_with_interval, "questions", shows=lambda row: row.variant in (PROGRAM, VALUE)
        ),
        "Families that were trained on, by primitive": Pivot(
            "right:.2f", "primitive", shows=lambda row: row.variant == SEEN
        ),
        "Doubt": Listing(_DOUBT, lambda row: row.variant == PROGRAM),
    },
)


def _own_rows(run: Run) -> Iterator[Row]:
    graded = []
    questions = _questions(run.seed)
    clips = run.size(CLIPS, 2)
    for place, made in enumerate(simulated_mixtures(clips, run.seed)):
        run.progress("own answers", place, clips)
        try:
            encoded = run.answerer.encode(made.clip)
        except UnreadableClip:
            continue
        for question in islice(questions, OWN_EACH):
            reply = run.answerer.ask(encoded, question)
            if reply.values:
                is_own = reply.told_by == "model"
                graded += [(case, OWN, is_own, made.object_name) for case in ("all", reply.kind)]
    yield from sorted(share_rows(graded, run.seed), key=lambda row: row.case)


def _questions(seed: int) -> Iterator[str]:
    """Yield questions about one clip, of families kept from training."""
    for pair in grammar().pairs(seed, "test"):
        answers = read(pair.query).answers
        words = {each.word for answer in answers for each in answer}
        leans = words & {*LEANING, "again", "plain", "talk", "not-understood"}
        if answers and not leans and not any(map(asks_of_two, answers)):
            yield pair.text


OWN_ANSWERS = Section(
    name="own-answers",
    title="What the language model says itself",
    about="""\
Every answer follows from values. It is the language model's own where the model, given its tactile
prefix, the question and the program, says the same sentence word for word; numbers are copied from
the value. Clips are simulated and turn, slide and press at once, objects and families of phrasing
are kept from training. What the model feels at its slots stands beside probe and rivals above.""",
    shares=whole(_own_rows),
    views={"": Pivot(right_with_interval, "kind of answer")},
)
