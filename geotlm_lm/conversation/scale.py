"""How large a pixel is on the gel, where somebody says so."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from geotlm_lm.core.frame_spec import MM_PER_PX

_NUMBER = r"(?P<number>\d+(?:\.\d+)?|\.\d+)"
_LENGTH = r"(?P<unit>mm|millimet(?:er|re)s?|um|\u00b5m|\u03bcm|microns?|micromet(?:er|re)s?)"
_PIXEL = r"(?:px|pixels?)"
_PER = r" ?(?:per|a|/) ?"
_SCALE_IS = r"(?:(?:(?:(?:the|a) )?(?:scale|resolution) (?:is|of)|it is|it's|at) )?"
_PIXEL_IS = (
    rf"(?:(?:a|one|1|each|every) {_PIXEL}|(?:the )?(?:pixel size|size of (?:a|one) {_PIXEL})|"
    rf"(?:the |my )?pixels)"
)

_SIZES = (
    rf"{_SCALE_IS}{_NUMBER} ?{_LENGTH}{_PER}{_PIXEL}",
    rf"{_PIXEL_IS} (?:is|are|was|were|measures?|=) {_NUMBER} ?{_LENGTH}"
    rf"(?: wide| long|{_PER}{_PIXEL})?",
    rf"mm[_ ]per[_ ]{_PIXEL} ?(?:is|=|:)? ?{_NUMBER}",
)
_DENSITY = rf"{_SCALE_IS}{_NUMBER} ?{_PIXEL}{_PER}{_LENGTH}"
"""How large a pixel is, or how many there are to a length."""

_SUPPOSED = r"(?:if|suppose|supposing|assuming|assume)(?: that)? "
_GIVEN = r"(?:given(?: that)?|with|at|when|where|since|knowing|provided|for|and|so|note(?: that)?) "
_CLAUSE = rf"(?P<supposed>{_SUPPOSED})?(?:{_GIVEN})?(?P<clause>.+?)"
_AFTER = re.compile(
    rf"(?:[?!;:,]\s*|\.\s+|\s*\(|\s(?={_SUPPOSED}|{_GIVEN})){_CLAUSE}[\s?!.)]*$", re.IGNORECASE
)
_BEFORE = re.compile(rf"^(?P<supposed>{_SUPPOSED})(?P<clause>[^,]+),\s+", re.IGNORECASE)
"""A size said after what is asked, and one supposed before it."""


@dataclass(frozen=True)
class SaidScale:
    """The size of a pixel, said beside a question.

    Args:
        fields: Of a `FrameSpec`.
        rest: The text without it.
        is_supposed: Whether it is said with an "if", which holds for that question alone.
    """

    fields: dict[str, Any]
    rest: str
    is_supposed: bool


def scale_beside(text: str) -> SaidScale | None:
    """Return the size of a pixel that is said after a question, or supposed before it."""
    first = _BEFORE.match(text)
    found = [] if first is None else [(first, text[first.end() :])]
    at = 0
    while (said := _AFTER.search(text, at)) is not None:
        mark = "?" if text[said.start()] == "?" else ""
        found.append((said, text[: said.start()] + mark))
        at = said.start() + 1
    for said, rest in found:
        fields = read_scale(" ".join(said["clause"].lower().split()))
        if fields is not None and re.search(r"\w", rest):
            return SaidScale(fields, rest.strip(), said["supposed"] is not None)
    return None


def read_scale(clause: str) -> dict[str, Any] | None:
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
