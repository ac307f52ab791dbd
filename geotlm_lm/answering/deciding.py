"""Decide every part of what was understood, and word what is not told or only guessed."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace

from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.evidence_of import evidence_of
from geotlm_lm.answering.understanding import Understood
from geotlm_lm.answering.withholding import tentative, why_withheld
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.query import types as t
from geotlm_lm.query.decision import Decision
from geotlm_lm.query.execute import execute
from geotlm_lm.query.facts import with_facts


def of_two(query: t.Query) -> bool:
    """Tell whether a query asks about two clips."""
    return any(map(_is_of_two, query.parts))


def _is_of_two(part: t.Part) -> bool:
    return part.ask.kind in ("compare", "which-clip") or part.subject.clip in t.OF_SEVERAL


def frame_after(query: t.Query, frame: FrameSpec, columns: int) -> FrameSpec:
    """Return the frame in which the facts that were stated hold; the one before if they cannot."""
    try:
        return with_facts(frame, query.facts, columns)
    except UsageError:  # no camera has such pixels: `execute` says so
        return frame


@dataclass(frozen=True)
class Decided:
    """What one part is answered by, and the clips that it is about."""

    decision: Decision
    clips: tuple[Encoded, ...]

    def withheld(self, bundle: Bundle) -> str | None:
        """Return what is said in place of it; None where it is told."""
        each = self.decision.each if len(self.clips) == 2 else (self.decision,)
        reasons = (
            why_withheld(bundle, clip, one) for clip, one in zip(self.clips, each, strict=False)
        )
        return next((one for one in reasons if one is not None), None)


def decided_parts(
    query: t.Query, frame: FrameSpec, clips: tuple[Encoded, ...]
) -> tuple[Decided, ...]:
    """Return what each part of a query is answered by, of the clip or the two that it asks about.

    Args:
        query: What is asked.
        frame: What held before.
        clips: One, or two that follow each other.
    """
    found = []
    for part in query.parts:
        about = clips
        if not _is_of_two(part):
            is_first = part.subject.clip in ("first", "previous")
            about = clips[:1] if is_first else clips[-1:]
            part = replace(part, subject=replace(part.subject, clip=None))
        alone = replace(query, parts=(part,))
        found.append(Decided(*execute(alone, evidence_of(*about), frame), about))
    return tuple(found)


def first_withheld(bundle: Bundle, found: Sequence[Decided]) -> str | None:
    """Return what is said in place of all parts; None where they are told."""
    return next((why for one in found if (why := one.withheld(bundle)) is not None), None)


def withheld_words(why: str, understood: Understood) -> str:
    """Return why nothing is told, in the form that was asked for."""
    if understood.keys:
        return json.dumps(dict.fromkeys(understood.keys))
    is_json = understood.query.form == "json"
    return json.dumps({"missing": why, "probability": 0.0}) if is_json else why


def guess_words(text: str, understood: Understood, sure: float) -> str:
    """Return words as a guess; JSON holds its own probability, or no values under given keys."""
    if understood.keys:
        return json.dumps(dict.fromkeys(understood.keys))
    return text if understood.query.form == "json" else tentative(text, sure)
