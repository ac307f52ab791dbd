"""Merge two answers into one."""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.answering.answer import Answer
from geotlm_lm.answering.model_query import summed_timings


def merge_answers(first: Answer, second: Answer) -> Answer:
    """Return two answers as one: of a direction and an amount both fields are filled.

    It abstains where either does.
    """
    kept = second if first.abstained else first
    told = [one.confidence for one in (first, second) if not one.abstained]
    notes = (*first.notes, *(note for note in second.notes if note not in first.notes))
    return replace(
        kept,
        text=f"{first.text} {second.text}",
        direction=second.direction if first.direction is None else first.direction,
        abstained=first.abstained or second.abstained,
        confidence=min(told, default=0.0),
        notes=notes,
        timing_ms=summed_timings(first, second),
        amount=first.amount or second.amount,
        told_by="rule",
    )
