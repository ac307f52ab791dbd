"""Grading of answers: right, wrong, or without a usable direction; the last is wrong, not dropped.

Knows motions, not the sentences they were read from.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from enum import StrEnum
from typing import Literal

from geotlm_lm.core.labels import DIRECTED, Motion


class Verdict(StrEnum):
    """What became of one answer."""

    RIGHT = "right"
    WRONG = "wrong"
    UNPARSABLE = "unparsable"
    """No motion could be read from it: an unknown sentence, a refusal, an empty string."""


def grade(truth: Motion, answer: Motion | None) -> Verdict:
    """Return what became of an answer; None means no motion could be read from it."""
    if answer is None:
        return Verdict.UNPARSABLE
    return Verdict.RIGHT if answer == truth else Verdict.WRONG


def tally(truths: Sequence[Motion], answers: Sequence[Motion | None]) -> dict[str, int]:
    """Count the verdicts; every verdict is a key, also with count 0.

    Raises:
        ValueError: If the lengths differ.
    """
    counts = Counter(grade(truth, answer) for truth, answer in zip(truths, answers, strict=True))
    return {verdict.value: counts[verdict] for verdict in Verdict}


def false_claim_rate(truths: Sequence[Motion], answers: Sequence[Motion | None]) -> float | None:
    """Return the share of clips without a direction for which one was claimed.

    Returns:
        None when every clip has a direction.
    """
    undirected = [a for t, a in zip(truths, answers, strict=True) if t not in DIRECTED]
    if not undirected:
        return None
    return sum(answer in DIRECTED for answer in undirected) / len(undirected)


TOLERANCES = {"deg": 2.0, "mm": 0.2, "px": 2.0}
"""Least error of an amount that still counts as right, by unit; a fifth of the true amount does.
Pixels are those of the 224-pixel image: 0.2 mm are 2.2 of them on a GelSight Mini."""

RELATIVE_TOLERANCE = 0.2


def within_tolerance(said: float, true: float, unit: Literal["deg", "mm", "px"]) -> bool:
    """Tell whether an amount is right: off by 2 degrees, 0.2 mm or 2 px, or by a fifth, at most."""
    return abs(said - true) <= max(TOLERANCES[unit], RELATIVE_TOLERANCE * true)
