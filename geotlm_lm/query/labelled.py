"""Questions with their meanings that people wrote one by one, and whether a reading is right."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace

from geotlm_lm.core.files import training_templates
from geotlm_lm.query.text import read
from geotlm_lm.query.types import Query

BLIND, SET_UPS, TUNE = "blind", "set-ups", "tune"
"""Sets written by people who had seen no template; only the last is used for any choice. The second
is questions behind facts on a set-up."""


@dataclass(frozen=True)
class Labelled:
    """A question and what it means.

    Args:
        text: As it was typed.
        queries: The best reading, and others that serve as well.
        asks_on: Whether it is whole only with what was asked before.
    """

    text: str
    queries: tuple[str, ...]
    asks_on: bool = False

    def is_met(self, line: str) -> bool:
        """Tell whether a reading means what was meant; the order of facts is free."""
        return meaning(line) in map(meaning, self.queries)

    def has_kinds(self, line: str) -> bool:
        """Tell whether a reading asks the right kinds of things in the right order."""
        return _kinds(line) in map(_kinds, self.queries)


def labelled(name: str) -> list[Labelled]:
    """Return the questions of one of these sets."""
    path = training_templates() / "query" / f"{name}.jsonl"
    rows = map(json.loads, path.read_text(encoding="utf-8").splitlines())
    return [
        Labelled(row["text"], (row["query"], *row.get("also", ())), bool(row.get("before")))
        for row in rows
    ]


def meaning(line: str) -> Query:
    """Return a query with its facts, and the literals of its propositions, in one order."""
    query = read(line)
    parts = tuple(replace(part, ask=_ordered(part.ask)) for part in query.parts)
    return replace(query, parts=parts, facts=tuple(sorted(query.facts, key=repr)))


def _ordered(ask):
    if ask.proposition is None:
        return ask
    literals = tuple(sorted(ask.proposition.literals, key=repr))
    return replace(ask, proposition=replace(ask.proposition, literals=literals))


def _kinds(line: str) -> list[str]:
    return [part.ask.kind for part in read(line).parts]
