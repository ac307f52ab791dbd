"""Decide what a recording tells, and what is withheld for want of contact, reference or certainty.

This is the one place: of each value, a record's fields among them, either it is told or `Unknown`
stands in its place with the reason.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.query.program import TWO_CLIPS, Expression, head_of, words_of
from geotlm_lm.query.values import (
    Choice,
    Movement,
    Placed,
    Record,
    Remark,
    Truth,
    Unknown,
    Value,
)

LEAST_SURE = 0.5
"""Probability below which an answer is only a guess: it would more likely be wrong than right."""

OF_CONTACT = frozenset({"touch", "none", "press", "in", "out"})
"""Words of a program that ask whether, or how deep, something touches."""

_OF_MOTION = frozenset({"move", "turn", "slide"})


def told_or_not(value: Value, clips: tuple[Encoded, ...], bundle: Bundle) -> Value:
    """Return a value, or why the recording that it is of does not tell it.

    Args:
        value: What was asked comes to.
        clips: One, or two that follow each other.
        bundle: Knows how much contact each direction needs.
    """
    if isinstance(value, Record):
        fields = ((key, told_or_not(each, clips, bundle)) for key, each in value.fields)
        return replace(value, fields=tuple(fields))
    for encoded in looked_at(value, clips):
        reason, detail = _why_withheld(value, encoded, bundle)
        if reason is not None:
            return Unknown(of=value.of, reason=reason, detail=detail, edit=value.edit)
    return value


def is_guess(value: Value) -> bool:
    """Tell whether a value is more likely wrong than right."""
    if isinstance(value, Record):
        return any(is_guess(each) for _, each in value.fields)
    is_asked_for = head_of(value.of).word in ("why", "sure", "alternatives", "why-of", "sure-of")
    return value.is_known and not is_asked_for and value.probability < LEAST_SURE


def looked_at(value: Value, clips: tuple[Encoded, ...]) -> tuple[Encoded, ...]:
    """Return the clips that a value tells of."""
    if len(clips) == 1:
        return clips
    words = {each.word for each in value.of}
    firsts = words & {"of-first", "of-previous"}
    if value.clip == "first" or (firsts and value.of.word in firsts):
        return clips[:1]
    return clips if words & set(TWO_CLIPS) or firsts else clips[-1:]


def _why_withheld(value: Value, encoded: Encoded, bundle: Bundle) -> tuple[str | None, str]:
    """Return the name of a reason of `replies.toml`, and what it says besides."""
    if isinstance(value, Remark):
        return None, ""
    if encoded.suspicion:
        return "suspicion", encoded.suspicion
    if not value.is_known:
        return None, ""
    words = set(_words(value))
    moves = tuple(_movements(value))
    if not encoded.is_contact_known and _tells_contact(value, words, moves):
        return "contact", ""
    ways = [move.way for move in moves if move.way in DIRECTED]
    if encoded.track is None and any(
        bundle.calibration.withholds(way, encoded.contact_share) for way in ways
    ):
        return "mask", f"(mask {encoded.contact_share:.3f})."
    if _lacks_reference(value, words, encoded):
        return "reference", ""
    # What changes a recording in which a touch is recognised is that touch.
    is_unexplained = encoded.is_changed and encoded.belief.contact < LEAST_SURE
    return ("unrecognised" if is_unexplained and _denies_contact(value) else None), ""


def _tells_contact(value: Value, words: set[str], moves: tuple[Movement, ...]) -> bool:
    """Tell whether a value says that something touches or not, where, or that it presses."""
    moved = {move.component for move in moves}
    return isinstance(value, Placed) or Component.PRESS in moved or bool(words & OF_CONTACT)


def _lacks_reference(value: Value, words: set[str], encoded: Encoded) -> bool:
    """Tell whether a value judges contact without a reference image of the idle gel.

    Whether anything moves may be told all the same: nothing does.
    """
    is_lacking = encoded.is_static or not encoded.is_contact_known
    if not is_lacking or (isinstance(value, Truth) and words and words <= _OF_MOTION):
        return False
    return _rest(value) is not None or bool(words & {"touch", "none"})


def _denies_contact(value: Value) -> bool:
    is_denied = isinstance(value, Truth) and value.of.word == "touch" and not value.holds
    return is_denied or _rest(value) is Motion.NONE


def _movements(value: Value) -> Iterator[Movement]:
    return iter(() if value.moved is None else value.moved.movements)


def _rest(value: Value) -> Motion | None:
    return None if value.moved is None else value.moved.rest


def _words(value: Value) -> Iterator[str]:
    """Yield what a program speaks of; of options those that hold, not what else was offered."""
    asked: tuple[Expression, ...] = (value.of,)
    head = head_of(value.of)
    if isinstance(value, Choice) and value.chosen and head.word in ("choose", "choose-not"):
        asked = tuple(head.arguments[0][place].holds for place in value.chosen)
    for expression in asked:
        yield from words_of(expression)
