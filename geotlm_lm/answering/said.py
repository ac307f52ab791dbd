"""What would be answered to a reading, and whether two such answers come to the same."""

from __future__ import annotations

from dataclasses import dataclass

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.query.decision import Decision

_NESTING = ("way", "compare")
"""Asks of which the answer about all that moves holds the one about a component."""


@dataclass(frozen=True)
class Said:
    """An answer to a reading.

    Args:
        text: In plain words.
        frame: That holds from then on.
        decisions: What is told, part by part.
    """

    text: str
    frame: FrameSpec
    decisions: tuple[Decision, ...] = ()

    def agrees_with(self, other: Said) -> bool:
        """Tell whether both say the same, or one the same as the other and more."""
        if self.frame != other.frame or self.text == other.text:
            return self.frame == other.frame
        return 0 < len(self.decisions) == len(other.decisions) and all(
            map(_says_as_much_or_more, self.decisions, other.decisions)
        )


def _says_as_much_or_more(one: Decision, other: Decision) -> bool:
    """Tell whether two decisions say the same but for how much of what moves."""
    if one.part.ask.kind not in _NESTING or _but_for_movements(one) != _but_for_movements(other):
        return False
    pairs = zip(one.each or (one,), other.each or (other,), strict=True)
    return all(_holds(_ways(first), _ways(second)) for first, second in pairs)


def _but_for_movements(decision: Decision) -> tuple[object, ...]:
    ask, subject = decision.part.ask, decision.part.subject
    told = (decision.verdict, decision.rest, decision.missing, decision.happenings)
    return (ask.kind, ask.relation, subject, decision.edit, len(decision.each), *told)


def _ways(decision: Decision) -> frozenset[Motion]:
    return frozenset(one.way for one in decision.movements)


def _holds(ways: frozenset[Motion], others: frozenset[Motion]) -> bool:
    return bool(ways and others) and (ways <= others or others <= ways)
