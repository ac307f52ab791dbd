"""Two answers told as one."""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.answering.answer import Answer


def both(first: Answer, second: Answer) -> Answer:
    """Return two answers as one: of a direction and an amount both fields are filled.

    It abstains where either does.
    """
    timing = {
        stage: first.timing_ms.get(stage, 0.0) + second.timing_ms.get(stage, 0.0)
        for stage in first.timing_ms | second.timing_ms
    }
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
        timing_ms=timing,
        amount=first.amount or second.amount,
        told_by="rule",
    )
