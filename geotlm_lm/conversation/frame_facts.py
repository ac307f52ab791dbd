"""Parse stated facts about a recording into a `FrameSpec`, by strict rules.

A text is read as a whole or not at all: one clause that is not understood changes nothing. A
question ("is the image mirrored?") and a supposition ("if it were mirrored") state no fact; an
image supposed to be turned upside down holds for the one question it is part of. Turns by other
angles are read in `image_rotation`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Any

from geotlm_lm.conversation.frame_fact_patterns import (
    FACTS,
    UPRIGHT,
)
from geotlm_lm.conversation.image_rotation import asks_whether_clip_turned, read_image_rotation
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.pixel_scale import is_courtesy, read_scale, stated_scale
from geotlm_lm.conversation.statements import is_unread_statement
from geotlm_lm.conversation.text_normalisation import normalised_text
from geotlm_lm.core.frame_spec import FrameSpec

_PHRASES = Phrases("frame_facts")
OF_THE_TELLING = ("viewpoint", "actor")
"""Fields that only say how to tell: put before a question by a comma they hold for it alone. The
others are facts of the world and last."""


_SUPPOSED = _PHRASES.pattern("SUPPOSED", re.IGNORECASE)

OF_A_THREAD = frozenset(("thread", "contact_side"))
"""Fields that alone may be assumed for good, and asked for with no more than "and with ...?"."""

_ASSUMED = _PHRASES.pattern("ASSUMED")
_WITH_ANOTHER = _PHRASES.pattern("WITH_ANOTHER", re.IGNORECASE)
_SUPPOSED_THREAD = _PHRASES.pattern("SUPPOSED_THREAD", re.IGNORECASE)
_INSTEAD = _PHRASES.pattern("INSTEAD", re.IGNORECASE)
_WOULD_THAT_BE = _PHRASES.pattern("WOULD_THAT_BE", re.IGNORECASE)
_WOULD_HAVE = _PHRASES.pattern("WOULD_HAVE", re.IGNORECASE)
_TIGHTER_OR_LOOSER = "Is it tightening or loosening?"

_SUPPOSED_FACTS = _PHRASES.pattern("SUPPOSED_FACTS", re.IGNORECASE)
_NO_SUPPOSITION = _PHRASES.pattern("NO_SUPPOSITION", re.IGNORECASE)
_AS_SEEN = _PHRASES.pattern("AS_SEEN", re.IGNORECASE)
_WOULD_BE = _PHRASES.pattern("WOULD_BE", re.IGNORECASE)
_WOULD = _PHRASES.pattern("WOULD", re.IGNORECASE)
_NOTHING_ASKED = _PHRASES.pattern("NOTHING_ASKED", re.IGNORECASE)
_OPEN_QUESTION = "Which way does it move?"

_LEAD = _PHRASES.pattern("LEAD")
_BREAK = _PHRASES.pattern("BREAK")
_ENDS = re.compile(r"[!;:,\n]|\.(?!\d)")

_AGAIN = _PHRASES.pattern("AGAIN")

MOST_CLAUSES = 4
"""One fact may run over: more than any in the list does (a comma and an "and" make three). Without
a bound 500 semicolons took a second."""


@dataclass(frozen=True)
class StatedFacts:
    """What a text states about the frame, and what it asks.

    Args:
        frame: The frame for this question.
        lasting: The frame for the questions after it.
        rest: The text without the facts; "" where it states facts alone.
        is_stated: Whether any fact was understood.
    """

    frame: FrameSpec
    lasting: FrameSpec
    rest: str
    is_stated: bool = False


def read_facts(text: str, frame: FrameSpec) -> StatedFacts:
    """Return `frame` with the facts that `text` begins with, and what remains of the text.

    Args:
        text: A statement, a question, or a question after a statement.
        frame: What was known before.
    """
    text = text.replace("\u2019", "'").strip()
    supposed = _supposed_scale(text, frame)
    beside = stated_scale(text) if supposed is None else None
    if beside is not None and is_courtesy(beside.rest) and not beside.is_supposed:
        told = replace(frame, **beside.fields)
        return StatedFacts(told, told, "", True)
    if beside is not None and _asks(beside.rest):
        stated = read_facts(beside.rest, replace(frame, **beside.fields))
        kept = {"mm_per_px": frame.mm_per_px} if beside.is_supposed else {}
        return replace(stated, lasting=replace(stated.lasting, **kept), is_stated=True)
    supposed = supposed or _supposed_mover(text, frame) or _supposed_thread(text, frame)
    stated = supposed or _read(text, frame)
    seen = _AS_SEEN.search(stated.rest)
    if seen is None:
        return stated
    rest = _tidied(stated.rest[: seen.start()], stated.rest[seen.end() :])
    is_as_told = stated.frame.viewpoint == "sensor" and not seen["side"]
    if is_as_told and rest != _OPEN_QUESTION:
        return stated
    return replace(stated, frame=replace(stated.frame, viewpoint="sensor"), rest=rest)


def has_trailing_rotation(text: str) -> bool:
    """Tell whether an image rotation is stated behind a question, where it is not read.

    A turn is told before a question: behind one it may be of what happened in between.
    """
    asked, _, said = text.rpartition("?")
    return bool(asked) and not _fields(said).keys().isdisjoint(UPRIGHT)


def _asks(text: str) -> bool:
    return not is_unread_statement(text) and not _NOTHING_ASKED.fullmatch(text)


def _supposed_mover(text: str, frame: FrameSpec) -> StatedFacts | None:
    """Return a question that supposes that the sensor moves in the object's place."""
    said = _INSTEAD.match(text)
    if said is None:
        return None
    asked = _WOULD_HAVE.sub(r"has \1", _WOULD_THAT_BE.sub(_OPEN_QUESTION, text[said.end() :]))
    return StatedFacts(replace(frame, actor="sensor"), frame, asked, True)


def _supposed_scale(text: str, frame: FrameSpec) -> StatedFacts | None:
    """Return a question before which the size of a pixel is supposed beside other facts."""
    supposed = _SUPPOSED_FACTS.match(text)
    commas = list(re.finditer(r",\s+", text))[:MOST_CLAUSES] if supposed else []
    for comma in reversed(commas):
        fields = _fields(text[supposed.end() : comma.start()].replace(", and ", " and "))
        rest = text[comma.end() :].strip()
        if fields.keys() > {"mm_per_px"} and rest and _asks(rest):
            return StatedFacts(replace(frame, **fields), frame, rest, True)
    return None


def _supposed_thread(text: str, frame: FrameSpec) -> StatedFacts | None:
    """Return a question of a thread that is supposed.

    Or the question what another thread, or end of it, would do: "and with a left-hand one?".

    It holds for this question alone.
    """
    if (supposed := _SUPPOSED_THREAD.match(text)) is not None:
        fields = _fields(f"it is {supposed['fact']}")
        if fields and fields.keys() <= OF_A_THREAD:
            return StatedFacts(replace(frame, **fields), frame, text[supposed.end() :], True)
    another = _WITH_ANOTHER.fullmatch(text)
    fields = _fields(another["fact"]) if another else {}
    if not fields or not fields.keys() <= OF_A_THREAD:
        return None
    return StatedFacts(replace(frame, **fields), frame, _TIGHTER_OR_LOOSER, True)


def _read(text: str, frame: FrameSpec) -> StatedFacts:
    supposed = _SUPPOSED.search(text)
    if supposed and not _NO_SUPPOSITION.search(text[: supposed.start()]):
        stated = _read(_without(text, supposed), frame)
        turned = FrameSpec.fields_of_turn(180 + (stated.frame.turn_deg if supposed["turns"] else 0))
        return replace(stated, frame=replace(stated.frame, **turned))
    fields = _fields(text)
    if fields:
        told = replace(frame, **fields)
        return StatedFacts(told, told, "", True)
    asked, mark, said = text.rpartition("?")
    fields = _fields(said) if asked and said else {}
    if fields and fields.keys().isdisjoint(UPRIGHT):  # a turn is told before
        told = replace(frame, **fields)
        return replace(_read(asked + mark, told), is_stated=True)
    for end in sorted((match.start() for match in _ENDS.finditer(text)), reverse=True):
        rest = text[end + 1 :].strip()
        fields = _fields(text[:end])
        if rest and fields and not asks_whether_clip_turned(text[:end], text[end:]):
            lasts = text[end] in ".!;\n"
            kept = {k: v for k, v in fields.items() if lasts or k not in OF_THE_TELLING}
            kept |= _fields(text[: text.rfind(". ", 0, end) + 1])  # sentences of their own
            return StatedFacts(replace(frame, **fields), replace(frame, **kept), rest, True)
    return StatedFacts(frame, frame, text)


def _without(text: str, supposed: re.Match[str]) -> str:
    """Return what a text asks apart from its supposition, as of what is and not what would be."""
    rest = _tidied(text[: supposed.start()], text[supposed.end() :])
    return _WOULD.sub("does", _WOULD_BE.sub(r"is \1", rest))


def _tidied(before: str, after: str) -> str:
    """Return what is left around words that were taken out of a question."""
    before, after = before.rstrip(" ,"), after.strip(" ,")
    rest = f"{before}, {after}" if after.strip("?!. ") and before else before + after
    return _OPEN_QUESTION if _NOTHING_ASKED.fullmatch(rest) else rest


def _fields(text: str) -> dict[str, Any]:
    """Return the fields that every clause of `text` together sets.

    None of them if one clause is unknown, or if two turn the image by something else each.
    """
    text = normalised_text(text).rstrip(".!, ")
    while (shorter := _LEAD.sub("", text)) != text:
        text = shorter
    if (assumed := _ASSUMED.match(text)) is not None:
        fields = _fields(text[assumed.end() :])
        return fields if fields.keys() <= OF_A_THREAD else {}
    breaks = [match.span() for match in _BREAK.finditer(text)]
    starts = [0, *(end for _, end in breaks)]
    ends = [*(start for start, _ in breaks), len(text)]
    fields: dict[str, Any] = {}
    at = 0
    while at < len(starts):
        # The longest run of clauses first: "the sensor moved, not the object" is one fact.
        for last in range(min(at + MOST_CLAUSES, len(ends)) - 1, at - 1, -1):
            found = _fact(text[starts[at] : ends[last]])
            if found is not None:
                if _turns_otherwise(fields, found):
                    return {}
                fields |= found
                at = last + 1
                break
        else:
            return {}
    return fields


def _turns_otherwise(fields: dict[str, Any], found: dict[str, Any]) -> bool:
    """Tell whether both turn the image, and not alike."""
    one, other = ([turns.get(name) for name in UPRIGHT] for turns in (fields, found))
    return any(one) and any(other) and one != other


def _fact(clause: str) -> dict[str, Any] | None:
    clause = _AGAIN.sub("", clause)
    clause = clause.removeprefix("that ")
    found = next((sets for words, sets in FACTS if re.fullmatch(words, clause)), None)
    return found or read_image_rotation(clause) or read_scale(clause)
