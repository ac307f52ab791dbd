"""How large a pixel is on the gel, where somebody says so."""

from __future__ import annotations

import re
from typing import Any

from geotlm_lm.core.frame_spec import MM_PER_PX

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
