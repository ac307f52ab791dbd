"""Understand a question: read it, and tie it to what was asked before."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product

from geotlm_lm.answering.said import Said
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.query import types as t
from geotlm_lm.query.facts import FACTS
from geotlm_lm.query.follow_up import resumed
from geotlm_lm.query.key_names import key_names
from geotlm_lm.query.reader import Reader
from geotlm_lm.query.reading import Reading
from geotlm_lm.query.replies import replies
from geotlm_lm.query.say_back import say_back
from geotlm_lm.query.tell import tell

UNDERSTOOD = 0.5
"""Probability of a reading below which it is asked back instead of answered. Of the questions by
which readers are chosen, 0.68 of those read with 0.5 to 0.6 came to the right answer, 0.48 of those
with 0.4 to 0.5."""

UNDERSTOOD_FACTS = 0.7
"""The same where it states facts about the set-up, which hold until they are taken back: of 45 read
with 0.4 to 0.7, 31 were read rightly, of 146 surer ones 140."""

NEEDLESS = 0.25
"""Probability of a reading from which on an answer is told that turns nobody the wrong way."""

_NEEDLESS = ("talk", "help", "unanswerable", "not-understood")
"""Asks that are answered so."""


UNLIKELY = 0.1
"""Probability of a reading up to which it is not offered."""

_OPEN = t.Query((t.Part(t.Ask("way")),))
"""What is told beside a question of which no reading is likely."""

Says = Callable[[t.Query], Said]
"""What is answered to a query."""


@dataclass(frozen=True)
class Understood:
    """What a question was taken to ask.

    Args:
        query: With its numbers, and with what "again" stands for.
        line: Its words.
        probability: That this is what was meant.
        keys: Names that the question gives to the values of its answer.
        ask_back: What is said where that is too unsure, or a fact was not understood.
        notes: Which facts were not understood and change nothing.
        milliseconds: That reading took.
    """

    query: t.Query
    line: str
    probability: float
    keys: tuple[str, ...] = ()
    ask_back: str | None = None
    notes: tuple[str, ...] = ()
    milliseconds: float = 0.0


def understand(
    reader: Reader, question: str, before: t.Query | None = None, says: Says | None = None
) -> Understood:
    """Read a question.

    Readings that come to the same answer are one: their chances are added.

    Args:
        reader: The model that reads.
        question: As it was typed.
        before: What was asked last, if anything was.
        says: Returns what is answered to a query; None where the query itself is wanted.

    Raises:
        UsageError: If the question is too long.
    """
    started = time.perf_counter()
    readings = reader.readings(question)
    queries = [resumed(one.query, before or t.Query()) for one in readings]
    found = Understood(queries[0], readings[0].line, readings[0].probability)
    if says is not None and len(readings) > 1:
        found = replace(found, probability=_agreed(reader, readings, list(map(says, queries))))
    facts = found.query.facts
    unclear = [one.value for one in facts if one.name == "unclear"]
    if found.probability < _least(found.query):
        likely = zip(queries, readings, strict=True)
        ask_back = _asked_back([one for one, read in likely if read.probability > UNLIKELY], says)
        found = replace(found, ask_back=ask_back)
    elif unclear and (says is None or _matters(unclear, found.query, says)):
        found = replace(found, ask_back=replies()["unclear"][unclear[0]])
    elif unclear:
        found = replace(found, notes=tuple(replies()["unclear_same"][one] for one in unclear))
    if found.query.form == "json":
        found = replace(found, keys=key_names(question, len(found.query.parts)))
    return replace(found, milliseconds=1e3 * (time.perf_counter() - started))


def _matters(topics: Sequence[str], query: t.Query, says: Says) -> bool:
    """Tell whether an answer depends on facts that were not understood."""
    kinds = {part.ask.kind for part in query.parts}
    is_of_two = any(part.subject.clip in t.OF_SEVERAL for part in query.parts)
    if not kinds or is_of_two or kinds & _OF_FRAME or not set(topics) <= _MAY_BE.keys():
        return True
    told = set()
    for stated in product(*(_MAY_BE[one] for one in topics)):
        facts = (*query.facts, *(fact for facts in stated for fact in facts))
        found = says(replace(query, facts=facts)).decisions
        if any(one.missing is not None for one in found):
            return True
        told.add(tuple(tell(replace(one, frame=FrameSpec())) for one in found))
    return len(told) > 1


_OF_FRAME = {"setup", "why", "compare", "which-clip"}
"""Asks whose answers speak of the frame itself, or of another clip."""

_MIRRORED, _HALF = t.Fact("mirrored"), t.Fact("turned", "half")
_MAY_BE: dict[str, list[tuple[t.Fact, ...]]] = {
    name: [(t.Fact(name, denied=True),), *((t.Fact(name, one),) for one in FACTS[name][0])]
    for name in ("turned", "thread", "side")
} | {"mirrored": [(t.Fact("mirrored", denied=True),), (_MIRRORED,), (_MIRRORED, _HALF)]}
"""What a fact that was not understood may be; a mirror may lie across or along."""


def _agreed(reader: Reader, readings: Sequence[Reading], said: Sequence[Said]) -> float:
    """Return the probability of all readings that are answered as the first is."""
    answered = zip(readings, said, strict=True)
    agreeing = [one.chance for one, says in answered if says.agrees_with(said[0])]
    return reader.calibrated(sum(agreeing))


def _least(query: t.Query) -> float:
    """Return how probable a reading has to be to be answered."""
    if query.facts:
        return UNDERSTOOD_FACTS
    is_needless = bool(query.parts) and all(one.ask.kind in _NEEDLESS for one in query.parts)
    return NEEDLESS if is_needless else UNDERSTOOD


def _asked_back(queries: Sequence[t.Query], says: Says | None) -> str:
    """Return what the two likeliest readings are, and what would be answered to each."""
    told: dict[str, str] = {}
    for query in queries:
        said = "" if says is None else says(replace(query, form="sentence")).text
        if query.parts and said not in told.values():
            told.setdefault(say_back(query), said)
    likely = list(told.items())[:2]
    if not likely:
        rest = replies()["help"] if says is None else f"{replies()['felt']} {says(_OPEN).text}"
        return f"{replies()['asked_back']} {rest}"
    asked = [f"{'or ' * place}{query}? {said}" for place, (query, said) in enumerate(likely)]
    return f"{replies()['unsure']} {' '.join(f'{one[:1].upper()}{one[1:]}' for one in asked)}"
