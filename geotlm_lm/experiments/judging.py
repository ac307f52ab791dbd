"""What became of one question: right, wrong, abstained, refused in a sentence, or a crash.

Catches everything, because a report of what goes wrong must not stop where it does.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.core.labels import DIRECTED, Motion

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer

QUESTION = "Which way is it moving?"

RIGHT, WRONG, ABSTAINED, REFUSED, CRASHED = "right", "wrong", "abstained", "refused", "crashed"

OUTCOMES = (RIGHT, WRONG, ABSTAINED, REFUSED, CRASHED)

CONFIDENT = 0.9
"""A wrong answer at or above this probability is called confident."""


@dataclass(frozen=True)
class Verdict:
    """What became of one question.

    Args:
        outcome: One of `OUTCOMES`.
        confidence: Of an answer; 0 otherwise.
        says: The answer or the sentence of the refusal.
        seconds: From the recording's making to the answer.
        motion: What an answer names.
    """

    outcome: str
    confidence: float
    says: str
    seconds: float
    motion: Motion | None = None


def judge(answerer: Answerer, make: Callable[[], Clip], right: Set[Motion]) -> Verdict:
    """Ask for the motion of a clip and judge the answer.

    Args:
        answerer: The model.
        make: Returns the clip, or refuses as a reader would.
        right: Motions that are right; with none, only an abstention or a refusal is.
    """
    started = time.perf_counter()

    def verdict(
        outcome: str, says: str, confidence: float = 0.0, motion: Motion | None = None
    ) -> Verdict:
        return Verdict(outcome, confidence, says, time.perf_counter() - started, motion)

    try:
        answer = answerer.ask(answerer.encode(make()), QUESTION)
    except GeoTLMError as error:
        return verdict(REFUSED, str(error))
    except Exception as error:
        return verdict(CRASHED, f"{type(error).__name__}: {error}")
    if answer.abstained:
        return verdict(ABSTAINED, answer.text)
    outcome = RIGHT if answer.direction in right else WRONG
    return verdict(outcome, answer.text, answer.confidence, answer.direction)


def tally(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    """Return the counts of a row, its confidences, and the words of its worst case."""
    sure = {
        outcome: [one.confidence for one in verdicts if one.outcome == outcome]
        for outcome in (RIGHT, WRONG)
    }
    answered = sure[RIGHT] + sure[WRONG]
    worst = max(verdicts, key=lambda one: (_GRAVITY.index(one.outcome), one.confidence))
    return {
        "clips": len(verdicts),
        **{name: sum(one.outcome == name for one in verdicts) for name in OUTCOMES},
        "accuracy_of_answers": len(sure[RIGHT]) / len(answered) if answered else None,
        "confidence": sum(answered) / len(answered) if answered else None,
        "confidence_wrong": max(sure[WRONG], default=None),
        "false_directions": _wrong(verdicts, 0.0, claims=True),
        "confident_false_directions": _wrong(verdicts, CONFIDENT, claims=True),
        "confident_oversights": _wrong(verdicts, CONFIDENT, claims=False),
        "says": worst.says,
        "slowest_s": max(one.seconds for one in verdicts),
    }


def _wrong(verdicts: Sequence[Verdict], least: float, *, claims: bool) -> int:
    """Count wrong answers of a probability of `least` or more that claim a direction, or do not."""
    return sum(
        one.outcome == WRONG and one.confidence >= least and (one.motion in DIRECTED) == claims
        for one in verdicts
    )


_GRAVITY = (RIGHT, ABSTAINED, REFUSED, WRONG, CRASHED)
"""Which case of a row the table quotes: the last of these that came up."""
