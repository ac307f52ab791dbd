"""Facts about the recording, said in words, read into a `FrameSpec` by strict rules.

A text is read as a whole or not at all: one clause that is not understood changes nothing. A
question ("is the image mirrored?") and a supposition ("if it were mirrored") state no fact; an
image supposed to be turned upside down holds for the one question it is part of.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Any

from geotlm_lm.core.frame_spec import MM_PER_PX, FrameSpec

_IMAGE = (
    r"(?:the |my )?(?:(?:camera|recorded|tactile) )?(?:image|picture|video|clip|recording|camera)"
)
_SENSOR = r"(?:the |my )?(?:sensor|gel|pad|camera|gripper|robot)"
_OTHER_SIDE = (
    r"(?:the )?(?:objects?'?s?|object's|other|opposite) (?:side|viewpoint|point of view|view)"
)
_LOOK = r"(?:(?:i|we)(?:'m| am|'re| are)? |as )?(?:look|looking|see|seen|view|viewing|viewed|told)"
_MOVED = r"(?:moved|moves|turned|turns|slid|slides|is moving|was moving)"
_TOUCHES = r"(?:touch|touches|touched|is on|is at|presses on|sees|see|looks at|look at|holds|grips)"
_THREADED = r"(?:thread|threads|screw|bolt|nut|threaded)"

_HALF_TURN = r"(?:by )?180 ?(?:degrees|deg|°)(?: (?:counter)?clockwise)?"
_ON_ITS_HEAD = (
    r"(?:(?:(?:turned|flipped|rotated|put|mounted|installed|held) )?(?:upside[ -]down|on its head)"
    rf"|(?:turned|rotated|mounted|installed) {_HALF_TURN})"
)
_MOUNTED = r"(?:the |my )?sensor (?:{}) (?:mounted|installed)"
"""A sensor held upside down for once shows the same image; one that is mounted so does not."""

_IT_IS = r"(?:(?:it is|it's|it has|this is|i have|we have) )?"
_HAND = rf"(?:(?:it is|it's|it has|this is|the thread is) )?(?:a )?{{}}(?: {_THREADED})?"

_SIDE = (
    rf"(?:{_SENSOR}|i|we) {_TOUCHES} (?:the|its) {{0}}"
    r"|(?:it is |it's )?(?:touched|gripped|held) (?:at|by|from|on) (?:the|its) {0}(?: side)?"
    rf"|(?:{_LOOK} )?(?:from|at) (?:the|its) {{0}}(?: side)?|(?:the )?{{0}} side"
)

FACTS: tuple[tuple[str, dict[str, Any]], ...] = (
    (
        rf"{_IMAGE} (?:is|was) (?:mirrored|flipped)(?: left[ -]to[ -]right)?",
        {"image_mirrored": True},
    ),
    (r"(?:a )?mirrored (?:image|camera|video|clip|recording)", {"image_mirrored": True}),
    (r"there(?:'s| is) a mirror in the (?:optics|camera|sensor)", {"image_mirrored": True}),
    (
        rf"{_IMAGE} (?:is|was)(?: not|n't) (?:mirrored|flipped)(?: left[ -]to[ -]right)?",
        {"image_mirrored": False},
    ),
    (r"there(?:'s| is) no mirror(?: in the (?:optics|camera|sensor))?", {"image_mirrored": False}),
    (
        rf"{_IMAGE} (?:is|was) {_ON_ITS_HEAD}"
        rf"|{_MOUNTED.format('is|was')} (?:upside[ -]down|on its head)"
        r"|(?:an )?upside[ -]down (?:image|camera|video|clip|recording)",
        {"image_upside_down": True},
    ),
    (
        rf"{_IMAGE} (?:is|was)(?: not|n't) {_ON_ITS_HEAD}"
        rf"|{_MOUNTED.format('is not|was not|isn.t|wasn.t')} (?:upside[ -]down|on its head)"
        rf"|(?:{_IMAGE} (?:is|was)|{_MOUNTED.format('is|was')}) (?:upright|right side up)",
        {"image_upside_down": False},
    ),
    (
        rf"{_IMAGE} (?:is|was) (?:(?:mirrored|flipped) and upside[ -]down"
        r"|upside[ -]down and (?:mirrored|flipped))",
        {"image_mirrored": True, "image_upside_down": True},
    ),
    (rf"(?:{_LOOK}(?: it)? )?from (?:{_OTHER_SIDE}|behind|the object)", {"viewpoint": "object"}),
    (rf"(?:i am|i'm|i stand|i sit) (?:on|at) {_OTHER_SIDE}", {"viewpoint": "object"}),
    (
        rf"(?:{_LOOK}(?: it)? )?from (?:the )?(?:sensor|camera)(?:'s side|'s view)?",
        {"viewpoint": "sensor"},
    ),
    (
        rf"{_SENSOR} {_MOVED}(?:,? (?:and )?not (?:the|my) \w+|,? (?:and|while) the \w+ "
        r"(?:stayed|stays|is fixed|was fixed|stood still|is clamped))?",
        {"actor": "sensor"},
    ),
    (rf"(?:i|we) moved {_SENSOR}(?:,? (?:and )?not (?:the|my) \w+)?", {"actor": "sensor"}),
    (r"(?:the|my) object (?:is|was) (?:fixed|clamped)", {"actor": "sensor"}),
    (
        rf"(?:the|my) \w+ {_MOVED},? (?:and )?not {_SENSOR}",
        {"actor": "object"},
    ),
    (rf"{_SENSOR} (?:is|was) (?:fixed|clamped|mounted)", {"actor": "object"}),
    (_SIDE.format("head"), {"contact_side": "head"}),
    (_SIDE.format("(?:shank|tip)"), {"contact_side": "shank"}),
    (_SIDE.format("side") + r"|(?:a )?side grip", {"contact_side": "side"}),
    (_HAND.format(r"left[ -]?hand(?:ed)?"), {"thread": "left"}),
    (rf"{_IT_IS}(?:a )?reversed? {_THREADED}", {"thread": "left"}),
    (_HAND.format(r"right[ -]?hand(?:ed)?"), {"thread": "right"}),
    (rf"{_IT_IS}(?:a )?(?:normal|standard|ordinary) {_THREADED}", {"thread": "right"}),
    (
        r"(?:reset|forget) (?:the frame|all that|what i said)",
        {
            "image_mirrored": False,
            "viewpoint": "sensor",
            "actor": "object",
            "contact_side": None,
            "thread": None,
            "image_upside_down": False,
            "mm_per_px": None,
        },
    ),
)
"""What may be said, to the letter, and the fields of `FrameSpec` it sets."""

_NUMBER = r"(?P<number>\d+(?:\.\d+)?|\.\d+)"
_LENGTH = r"(?P<unit>mm|millimet(?:er|re)s?|um|\u00b5m|\u03bcm|microns?|micromet(?:er|re)s?)"
_PIXEL = r"(?:px|pixels?)"
_PER = r" ?(?:per|a|/) ?"
_SCALE_IS = r"(?:(?:(?:the )?(?:scale|resolution) is|it is|it's|at) )?"
_PIXEL_IS = (
    rf"(?:(?:a|one|1|each|every) {_PIXEL}|(?:the )?(?:pixel size|size of (?:a|one) {_PIXEL})|"
    rf"(?:the |my )?pixels)"
)

_SIZES = (
    rf"{_SCALE_IS}{_NUMBER} ?{_LENGTH}{_PER}{_PIXEL}",
    rf"{_PIXEL_IS} (?:is|are|measures?|=) {_NUMBER} ?{_LENGTH}(?: wide| long|{_PER}{_PIXEL})?",
    rf"mm[_ ]per[_ ]{_PIXEL} ?(?:is|=|:)? ?{_NUMBER}",
)
_DENSITY = rf"{_SCALE_IS}{_NUMBER} ?{_PIXEL}{_PER}{_LENGTH}"
"""How large a pixel is, or how many there are to a length."""

OF_THE_TELLING = ("viewpoint", "actor")
"""Fields that only say how to tell: put before a question by a comma they hold for it alone. The
others are facts of the world and last."""

_SUPPOSED = re.compile(
    r",?\s*\b(?:(?:if|suppose|supposing|imagine) (?:"
    rf"(?P<turns>(?:i|we|you|one) (?:had )?(?:turn|rotate|flip|put|turned|rotated|flipped) {_IMAGE}"
    rf" (?:upside[ -]down|on its head|{_HALF_TURN}))"
    rf"|{_IMAGE} (?:is|was|were|had been) {_ON_ITS_HEAD}"
    rf"|{_MOUNTED.format('is|was|were')} (?:upside[ -]down|on its head))"
    rf"|had {_IMAGE} been {_ON_ITS_HEAD})\b\s*[,:;.]?",
    re.IGNORECASE,
)
"""An image that is turned for the length of a question."""

_NO_SUPPOSITION = re.compile(
    r"\b(?:know|tell|sure|certain|check|say|see|matters?|wonder|ask|asks|depends?|care|on|or)"
    r"(?: me| us)?\s*$",
    re.IGNORECASE,
)
"""Words before an "if" that ask whether it is so."""

_WOULD_BE = re.compile(r"\bwould ((?:[^\W\d]+ ){0,2}[^\W\d]+) be(?= \w+ing\b)", re.IGNORECASE)
_WOULD = re.compile(r"\bwould(?= (?:the |this |that |it\b|my ))", re.IGNORECASE)

_NOTHING_ASKED = re.compile(r"(?:what|and|so|but|how|about|then|\W)*", re.IGNORECASE)
_OPEN_QUESTION = "Which way does it move?"

_LEAD = re.compile(
    r"^(?:please|note(?: that)?|fyi|by the way|ok|okay|actually|remember(?: that)?|so|and|now|but)"
    r"[:,]? +"
)
_BREAK = re.compile(r"\s*(?:[,;]|\band\b|\bbut\b)\s*")
_ENDS = re.compile(r"[!;:,\n]|\.(?!\d)")

MOST_CLAUSES = 4
"""One fact may run over: more than any in the list does (a comma and an "and" make three). Without
a bound 500 semicolons took a second."""


@dataclass(frozen=True)
class Stated:
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


def read_facts(text: str, frame: FrameSpec) -> Stated:
    """Return `frame` with the facts that `text` begins with, and what remains of the text.

    Args:
        text: A statement, a question, or a question after a statement.
        frame: What was known before.
    """
    text = text.replace("\u2019", "'").strip()
    supposed = _SUPPOSED.search(text)
    if supposed and not _NO_SUPPOSITION.search(text[: supposed.start()]):
        stated = read_facts(_without(text, supposed), frame)
        is_turned = not (supposed["turns"] and stated.frame.image_upside_down)
        return replace(stated, frame=replace(stated.frame, image_upside_down=is_turned))
    fields = _fields(text)
    if fields:
        told = replace(frame, **fields)
        return Stated(told, told, "", True)
    for end in sorted((match.start() for match in _ENDS.finditer(text)), reverse=True):
        rest = text[end + 1 :].strip()
        fields = _fields(text[:end])
        if rest and fields:
            lasts = text[end] in ".!;\n"
            kept = {k: v for k, v in fields.items() if lasts or k not in OF_THE_TELLING}
            return Stated(replace(frame, **fields), replace(frame, **kept), rest, True)
    return Stated(frame, frame, text)


def _without(text: str, supposed: re.Match[str]) -> str:
    """Return what a text asks apart from its supposition, as of what is and not what would be."""
    before, after = text[: supposed.start()].rstrip(), text[supposed.end() :].strip()
    rest = f"{before}, {after}" if after.strip("?!. ") and before else before + after
    rest = _WOULD_BE.sub(r"is \1", rest)
    rest = _WOULD.sub("does", rest)
    return _OPEN_QUESTION if _NOTHING_ASKED.fullmatch(rest) else rest


def _fields(text: str) -> dict[str, Any]:
    """Return the fields that every clause of `text` together sets; none if one is unknown."""
    text = " ".join(text.lower().split()).rstrip(".!, ")
    while (shorter := _LEAD.sub("", text)) != text:
        text = shorter
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
                fields |= found
                at = last + 1
                break
        else:
            return {}
    return fields


def _fact(clause: str) -> dict[str, Any] | None:
    found = next((sets for words, sets in FACTS if re.fullmatch(words, clause)), None)
    return found or _scale(clause)


def _scale(clause: str) -> dict[str, Any] | None:
    """Return the size of a pixel that a clause states, if it is one a camera can have."""
    for words in (*_SIZES, _DENSITY):
        if (said := re.fullmatch(words, clause)) is None:
            continue
        unit = said.groupdict().get("unit", "mm")
        size_mm = 1.0 if unit.startswith(("mm", "milli")) else 1e-3
        number = float(said["number"])
        if words is _DENSITY:
            size_mm = size_mm / number if number else 0.0
        else:
            size_mm *= number
        return {"mm_per_px": size_mm} if MM_PER_PX[0] <= size_mm <= MM_PER_PX[1] else None
    return None
