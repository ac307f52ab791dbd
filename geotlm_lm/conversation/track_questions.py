"""What is asked of a whole recording: when, in which order, how often, and in which span of it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum

from geotlm_lm.conversation.number_words import NUMBER, number
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text

_PHRASES = Phrases("track_questions", NUMBER=NUMBER)


class TrackAsk(StrEnum):
    """What of a recording is asked for."""

    SLIPPED = "slipped"
    STORY = "story"
    FIRST = "first"
    LAST = "last"
    NEXT = "next"
    FASTEST = "fastest"
    TURNED_BACK = "turned_back"
    COUNT = "count"
    DURATION = "duration"
    ENDED = "ended"
    BEGAN = "began"


class Doing(StrEnum):
    """What it does that is asked about."""

    HOLD = "held"
    LET_GO = "let_go"
    SLIP = "slip"
    STILL = "still"
    PRESS = "pressed"
    TURN = "turned"
    SLIDE = "slid"


@dataclass(frozen=True)
class Span:
    """A part of a recording.

    Args:
        first: Where it begins; None at the recording's begin.
        last: Where it ends; None at its end.
        unit: "s" or "frames".
        is_from_end: Whether `first` is told backwards from the end.
    """

    first: float | None
    last: float | None
    unit: str
    is_from_end: bool = False


_ASKS = (
    (TrackAsk.SLIPPED, _PHRASES.pattern("SLIPPED")),
    (TrackAsk.STORY, _PHRASES.pattern("STORY")),
    (TrackAsk.FIRST, _PHRASES.pattern("FIRST")),
    (TrackAsk.LAST, _PHRASES.pattern("LAST")),
    (TrackAsk.NEXT, _PHRASES.pattern("NEXT")),
    (TrackAsk.FASTEST, _PHRASES.pattern("FASTEST")),
    (TrackAsk.TURNED_BACK, _PHRASES.pattern("TURNED_BACK")),
    (TrackAsk.COUNT, _PHRASES.pattern("COUNT")),
    (TrackAsk.DURATION, _PHRASES.pattern("DURATION")),
    (TrackAsk.ENDED, _PHRASES.pattern("ENDED")),
    (TrackAsk.BEGAN, _PHRASES.pattern("BEGAN")),
)
"""In the order in which the words are tried."""
_DOING = (
    (Doing.LET_GO, _PHRASES.pattern("LET_GO")),
    (Doing.SLIP, _PHRASES.pattern("SLIP")),
    (Doing.STILL, _PHRASES.pattern("STILL")),
    (Doing.HOLD, _PHRASES.pattern("HELD")),
    (Doing.PRESS, _PHRASES.pattern("PRESSED")),
    (Doing.TURN, _PHRASES.pattern("TURNED")),
    (Doing.SLIDE, _PHRASES.pattern("SLID")),
)
_BETWEEN = tuple(re.compile(one) for one in _PHRASES.each("BETWEEN"))
_ENDS = (_PHRASES.pattern("AFTER"), _PHRASES.pattern("BEFORE"))
_OPENING, _CLOSING = _PHRASES.pattern("OPENING"), _PHRASES.pattern("CLOSING")


def track_ask(question: str) -> TrackAsk | None:
    """Return what of a whole recording a question asks for; None where one clip tells it too."""
    text = normalised_text(question)
    return next((ask for ask, words in _ASKS if words.search(text)), None)


def asked_doing(question: str) -> Doing | None:
    """Return what it does that a question is about; None where that is any motion."""
    text = normalised_text(question)
    return next((doing for doing, words in _DOING if words.search(text)), None)


def asked_span(question: str) -> tuple[str, Span] | None:
    """Return a question without the span of the recording that it names, and the span."""
    text = normalised_text(question)
    for words in (*_BETWEEN, *_ENDS):
        found = words.search(text)
        span = found and _span(found.groupdict())
        if span:
            return _without(text, found), span
    for words, is_from_end in ((_OPENING, False), (_CLOSING, True)):
        if found := words.search(text):
            unit, scale = _unit(found["unit"])
            long = (number(found["long"] or "1") or 1.0) * scale
            span = Span(long, None, unit, True) if is_from_end else Span(None, long, unit)
            return _without(text, found), span
    return None


def _span(told: dict[str, str | None]) -> Span | None:
    """Return the span that a pattern's groups tell; None where no unit is told."""
    units = [told.get(name) for name in ("unit2", "unit1")]
    named = next((one for one in units if one), None)
    if named is None and (told.get("frames1") or told.get("frames2")):
        named = "frames"
    if named is None:
        return None
    unit, scale = _unit(named)
    first, last = (told.get(name) and number(told[name]) for name in ("first", "last"))
    scaled = [None if one is None else one * scale for one in (first, last)]
    return None if scaled == [None, None] else Span(*scaled, unit)


def _unit(word: str) -> tuple[str, float]:
    if word.startswith("frame"):
        return "frames", 1.0
    return "s", 1e-3 if word.startswith("m") else 1.0


def _without(text: str, found: re.Match[str]) -> str:
    rest = f"{text[: found.start()]} {text[found.end() :]}"
    return re.sub(r"\s+([?!.,])", r"\1", " ".join(rest.split())).strip(" ,")
