"""Questions that nobody wrote a template for, put to the product in conversations; what it said.

Reads the questions from a file beside this one; the answers are graded by what a person would take
for right, in the fields of the answer.
"""

from __future__ import annotations

import time
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.record import RunRecord
from geotlm_lm.core.resources import resource_dir
from geotlm_lm.recordings.read import read_clip

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer, Session

QUESTIONS = Path(__file__).with_name("fresh_questions.toml")

WANTED = frozenset({"kind", "decided", "direction", "abstained"})
"""Fields of an answer that may be asked for."""


@dataclass(frozen=True)
class Fresh:
    """A question and what a right answer to it holds.

    Args:
        clip: Name of an example clip.
        ask: The question.
        wants: Fields of the answer and the values they should have.
        after: The turns before it.
        note: Why an answer that is odd is so; "" where there is nothing to say.
    """

    clip: str
    ask: str
    wants: Mapping[str, Any]
    after: tuple[str, ...] = field(default=())
    note: str = ""


def fresh_questions(path: Path | None = None) -> list[Fresh]:
    """Return the questions of a file; None for the one that ships with the package.

    Raises:
        ValueError: If a question wants a field that no answer has, or nothing.
    """
    path = path or QUESTIONS
    rows = tomllib.loads(path.read_text(encoding="utf-8"))["questions"]
    questions = [Fresh(**row | {"after": tuple(row.get("after", ()))}) for row in rows]
    for one in questions:
        if not one.wants or set(one.wants) - WANTED:
            raise ValueError(
                f"{path}: {one.ask!r} wants {dict(one.wants)}; known: {sorted(WANTED)}"
            )
    return questions


def transcript(
    answerer: Answerer,
    *,
    model_name: str = "embedded",
    command: str = "",
) -> RunRecord:
    """Ask every question in a conversation of its own and write down what was said.

    Args:
        answerer: The loaded model.
        model_name: What the record calls the model.
        command: The command line, for the record.
    """
    started = time.perf_counter()
    encoded = cache(lambda name: answerer.encode(_example(name)))
    turns = [_turn(answerer.session(encoded(one.clip)), one) for one in fresh_questions()]
    return RunRecord(
        name="transcript",
        command=command,
        seed=0,
        seconds=time.perf_counter() - started,
        numbers={
            "questions": len(turns),
            "as_wanted": sum(turn["as_wanted"] for turn in turns),
            "turns": turns,
        },
        config={"model": model_name, "model_digest": answerer.bundle.digest()},
    )


def _turn(session: Session, one: Fresh) -> dict[str, Any]:
    before = [session.ask(text).text for text in one.after]
    told = session.ask(one.ask).to_dict()
    return {
        "clip": one.clip,
        "before": [list(turn) for turn in zip(one.after, before, strict=True)],
        "question": one.ask,
        "answer": told["text"],
        "as_wanted": as_wanted(told, one.wants),
        "wanted": dict(one.wants),
        "found": {name: told.get(name) for name in sorted(WANTED)},
        "confidence": told.get("confidence"),
        "told_by": told.get("told_by"),
        "note": one.note,
    }


def as_wanted(told: Mapping[str, Any], wants: Mapping[str, Any]) -> bool:
    """Tell whether an answer holds everything that is wanted of it."""
    return all(told.get(name) == value for name, value in wants.items())


def _example(name: str) -> Clip:
    return read_clip(resource_dir("app") / "examples" / f"{name}.npz")
