"""Questions with their meanings that people wrote one by one, and whether a reading is right."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from copy import copy
from dataclasses import dataclass, replace

from geotlm_lm.core.files import training_templates
from geotlm_lm.query.lines import normal, read
from geotlm_lm.query.program import Expression, Program
from geotlm_lm.training.grammar import Pair, grammar

BLIND, SET_UPS, TUNE, KEPT = "blind", "set-ups", "tune", "kept"
"""Sets of questions that no reader learns from. The first three are by people who had seen no
template, the second behind facts on a set-up; the last is of meanings that askers labelled. Only
the last two are used for any choice."""

WRITERS = ("nonnative", "adversary")
"""Who asks what no reader was trained on: all families of theirs are of the test split."""


@dataclass(frozen=True)
class Labelled:
    """A question and what it means.

    Args:
        text: As it was typed.
        queries: The best reading, and others that serve as well.
        asks_on: Whether it is whole only with what was asked before.
        family: Of phrasing, that it is of; "" of what stands by itself.
    """

    text: str
    queries: tuple[str, ...]
    asks_on: bool = False
    family: str = ""

    def is_met(self, line: str) -> bool:
        """Tell whether a reading means what was meant; the order of facts is free."""
        return meaning(line) in map(meaning, self.queries)


def labelled(name: str) -> list[Labelled]:
    """Return the questions of one of these sets."""
    path = training_templates() / "query" / f"{name}.jsonl"
    rows = map(json.loads, path.read_text(encoding="utf-8").splitlines())
    return [
        Labelled(row["text"], (row["query"], *row.get("also", ())), bool(row.get("before")))
        for row in rows
    ]


def of_pairs(pairs: Iterable[Pair]) -> list[Labelled]:
    """Return questions of the grammar or the corpus; their family is that of the question."""
    return [Labelled(pair.text, (pair.query,), family=pair.families[0]) for pair in pairs]


def written_by(writer: str, seed: int) -> Iterator[Pair]:
    """Yield what one of `WRITERS` asks, each text once with nothing around it."""
    own = copy(grammar())
    for family in grammar().families:
        for place, text in enumerate(family.texts if f"/{writer}-" in family.id else ()):
            own.families = [replace(family, texts=(text,), complete=True)]
            pairs = own.pairs(seed + place)
            yield next(pair for pair in pairs if pair.families == (family.id,))


def meaning(line: str) -> Program:
    """Return a program in its normal form, facts and what stands in any order in one order."""
    program = normal(read(line))
    answers = tuple(map(_ordered, program.answers))
    return replace(program, answers=answers, facts=tuple(sorted(program.facts, key=repr)))


def _ordered(expression: Expression) -> Expression:
    arguments = tuple(
        _ordered(each) if isinstance(each, Expression) else each for each in expression.arguments
    )
    if expression.word in ("and", "or", "xor", "+", "*", "min", "max"):
        arguments = tuple(sorted(arguments, key=repr))
    return replace(expression, arguments=arguments)
