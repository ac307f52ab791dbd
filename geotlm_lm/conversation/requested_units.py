"""Recognise the unit in which a question wants an amount.

Only units that amounts are not given in anyway.
"""

from __future__ import annotations

import re

from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.quantities import SECONDS, UNIT, unit_of
from geotlm_lm.conversation.text_normalisation import normalised_text

_PHRASES = Phrases("requested_units", UNIT=UNIT)
_ASKED = _PHRASES.pattern("ASKED")
_PER_FRAME = _PHRASES.pattern("PER_FRAME")
_TIMES = {1.0: "second", 60.0: "minute", 3600.0: "hour"}

_UNITS = {"deg": "degrees", "px": "pixels", "mm": "mm"}
_BARE_NUMBER = _PHRASES.pattern("BARE_NUMBER", re.IGNORECASE)


def requested_unit(question: str, told: str) -> tuple[str, float] | None:
    """Return the unit a question asks for, and how many of it make one of the unit `told`.

    None where it names none, the one told anyway, or one of another thing.

    Args:
        question: What was asked.
        told: "deg", "px" or "mm"; "deg/s" and so on of a speed.
    """
    said = _ASKED.search(normalised_text(question))
    if said is None:
        return None
    unit, factor = unit_of(said["unit"])
    if unit == told:
        return None if factor == 1 else (said["unit"], 1 / factor)
    if f"{unit}/s" != told:
        return None
    seconds = next((s for words, s in SECONDS if re.fullmatch(words, said["time"] or "s")), None)
    if seconds is None or (factor, seconds) == (1.0, 1.0):
        return None
    return f"{said['unit']} per {_TIMES[seconds]}", seconds / factor


def with_unit(question: str, told: str) -> str:
    """Add the unit of the last amount to a question that compares with a bare number.

    Any other question stays as it is, and so does one after a speed.

    Args:
        question: What is asked after an amount was told.
        told: The unit of that.
    """
    unit = _UNITS.get(told)
    if unit is None or not _BARE_NUMBER.fullmatch(question.strip()):
        return question
    return f"{question.strip(' ?!.')} {unit}?"


def asks_per_frame(question: str) -> bool:
    """Tell whether `question` asks how far it goes from one frame to the next."""
    return bool(_PER_FRAME.search(question.lower()))
