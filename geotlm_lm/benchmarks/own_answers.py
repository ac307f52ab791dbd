"""How often the language model itself says what is answered, by kind of question."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from geotlm_lm.benchmarks.cases import simulated_mixtures
from geotlm_lm.benchmarks.harness import Pivot, Row, Run, Section
from geotlm_lm.benchmarks.judging import share_rows
from geotlm_lm.benchmarks.rendering import right_with_interval
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.query.lines import read
from geotlm_lm.query.program import LEANING, asks_of_two
from geotlm_lm.training.grammar import grammar

CLIPS, EACH = 150, 10
"""Simulated clips, and questions about each."""

OWN = "said by the model itself"


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
        for question in islice(questions, EACH):
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
    run=_own_rows,
    views={"": (Pivot(right_with_interval, "kind of answer"), lambda row: row.variant == OWN)},
)
