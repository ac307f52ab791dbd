"""Understand a question: read it, and tie it to what was asked before."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

from geotlm_lm.core.errors import UsageError
from geotlm_lm.query import types as t
from geotlm_lm.query.follow_up import resumed
from geotlm_lm.query.reader import Reader
from geotlm_lm.query.replies import replies
from geotlm_lm.query.say_back import say_back

UNDERSTOOD = 0.5
"""Probability of a reading below which it is asked back instead of answered."""

OPEN_QUESTION = "Which way is it moving?"

_NEEDLESS = ("talk", "help", "unanswerable", "not-understood")
"""Asks whose answers turn nobody the wrong way: they are given however unsure the reading."""


@dataclass(frozen=True)
class Understood:
    """What a question was taken to ask.

    Args:
        query: With its numbers, and with what "again" stands for.
        line: Its words.
        probability: That this is what was meant.
        ask_back: What is said where that is too unsure, or a fact was not understood.
        milliseconds: That reading took.
    """

    query: t.Query
    line: str
    probability: float
    ask_back: str | None = None
    milliseconds: float = 0.0


def check_question(question: object) -> str:
    """Return a question without the white space around it.

    Raises:
        UsageError: If it is empty.
        TypeError: If it is no text.
    """
    if not isinstance(question, str):
        raise TypeError(
            f"a question is a text, found {type(question).__name__}; give one such as "
            f"'{OPEN_QUESTION}'"
        )
    if not question.strip():
        raise UsageError(f"The question is empty; ask something like '{OPEN_QUESTION}'.")
    return question.strip()


def understand(reader: Reader, question: str, before: t.Query | None = None) -> Understood:
    """Read a question.

    Args:
        reader: The model that reads.
        question: As it was typed.
        before: What was asked last, if anything was.

    Raises:
        UsageError: If the question is too long.
    """
    started = time.perf_counter()
    best = reader.read(question)
    query = resumed(best.query, before or t.Query())
    found = Understood(query, best.line, best.probability)
    unclear = [one.value for one in query.facts if one.name == "unclear"]
    if unclear:
        found = replace(found, ask_back=replies()["unclear"][unclear[0]])
    elif best.probability < UNDERSTOOD and not _is_needless(query):
        found = replace(found, ask_back=_asked_back(reader, question, best.query))
    return replace(found, milliseconds=1e3 * (time.perf_counter() - started))


def _is_needless(query: t.Query) -> bool:
    return bool(query.parts) and all(one.ask.kind in _NEEDLESS for one in query.parts)


def _asked_back(reader: Reader, question: str, best: t.Query) -> str:
    said = [say_back(one.query) for one in reader.readings(question)[1:]]
    said = [say_back(best), *said]
    said = [one for place, one in enumerate(said) if one not in said[:place]]
    return replies()["asked_back"].format(" or ".join(f"'{one}'" for one in said))
