"""One clip moves in one way: an amount is of the turn or the slide that the open answer tells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from geotlm_lm.answering.answer import GOES_BY
from geotlm_lm.answering.hearing import Heard, is_doubtful
from geotlm_lm.core.labels import DIRECTED, Motion, motion_class
from geotlm_lm.language.parse_answer import Kind, Slots, Unit

MEASURED = ("magnitude", "rate")
"""Kinds of amounts."""

_UNITS: dict[str, Unit] = {kind: unit for unit, kind in GOES_BY.items()}


def told_motion(opened: Heard) -> Motion | None:
    """Return the turn or slide that the open question is answered with.

    None where it is answered with another motion, or with a doubtful one.
    """
    slots = opened.slots
    if slots is None or slots.kind != "direction" or slots.direction not in DIRECTED:
        return None
    return None if is_doubtful("direction", slots.direction, opened.options) else slots.direction


def goes_another_way(slots: Slots, motion: Motion | None) -> bool:
    """Tell whether an answer about an amount speaks of another kind of motion than `motion`."""
    is_of_it = motion is None or slots.unit == _UNITS[motion_class(motion)]
    return slots.kind in MEASURED and not is_of_it


def as_told(heard: Heard, kind: Kind, motion: Motion | None, shares: Mapping[str, float]) -> Heard:
    """Return what was heard of an amount, made one of `motion` where it is of another.

    Of 38 real recordings that are told to turn, 7 were told to slide, or to lift off, when asked
    how far they go.

    Args:
        heard: To a question about an amount.
        kind: Of that question.
        motion: What the open question is answered with; only a turn or a slide makes a difference.
        shares: Probability of each motion, by its word.
    """
    if motion not in DIRECTED or (heard.slots and not goes_another_way(heard.slots, motion)):
        return heard
    options: dict[str, float] = {}
    for word, share in shares.items():
        kind_of_motion = motion_class(Motion(word)).value
        options[kind_of_motion] = options.get(kind_of_motion, 0.0) + share
    slots = Slots(kind, unit=_UNITS[motion_class(motion)])
    return replace(heard, slots=slots, text="", options=options, is_by_rule=True)
