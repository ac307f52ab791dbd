"""Parse statements of how large a pixel is on the gel."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text
from geotlm_lm.core.frame_spec import MM_PER_PX

_PHRASES = Phrases("pixel_scale")
_SIZES = _PHRASES.each("SIZES")
_DENSITY = _PHRASES.text("DENSITY")
_AFTER = _PHRASES.pattern("AFTER", re.IGNORECASE)
_BEFORE = _PHRASES.pattern("BEFORE", re.IGNORECASE)
_COURTESY = _PHRASES.pattern("COURTESY", re.IGNORECASE)
_ASKED = _PHRASES.pattern("ASKED")
_ACROSS = _PHRASES.pattern("ACROSS", re.IGNORECASE)


@dataclass(frozen=True)
class StatedScale:
    """A pixel size stated beside a question.

    Args:
        fields: Of a `FrameSpec`.
        rest: The text without it.
        is_supposed: Whether it is said with an "if", which holds for that question alone.
    """

    fields: dict[str, Any]
    rest: str
    is_supposed: bool


def stated_scale(text: str) -> StatedScale | None:
    """Return the size of a pixel that is said after a question, or given or supposed before it."""
    first = _BEFORE.match(text)
    found = [] if first is None else [(first, text[first.end() :])]
    at = 0
    while (said := _AFTER.search(text, at)) is not None:
        mark = "?" if text[said.start()] == "?" else ""
        found.append((said, text[: said.start()] + mark))
        at = said.start() + 1
    for said, rest in found:
        fields = read_scale(normalised_text(said["clause"]))
        if fields is not None and re.search(r"\w", rest):
            return StatedScale(fields, rest.strip(), said["supposed"] is not None)
    return None


def with_pixel_size(text: str, columns: int) -> str:
    """Return `text` with the size of a pixel in place of that of the whole picture.

    Args:
        text: As it was typed.
        columns: Pixels of the picture across.
    """
    return _ACROSS.sub(
        lambda said: f"a pixel is {float(said['number']) / columns:.6g} {said['unit']}", text
    )


def is_courtesy(text: str) -> bool:
    """Tell whether `text` says no more than a thanks or an "ok" before something else."""
    return bool(_COURTESY.fullmatch(text))


def asks_scale(question: str) -> bool:
    """Tell whether a question asks if a pixel is so large: "is the scale 0.06 mm per pixel?"."""
    said = _ASKED.fullmatch(normalised_text(question).strip(" ?!."))
    return said is not None and (said["per"] is not None or " it " not in said[0])


def known_scale_sentence(mm_per_px: float | None) -> str:
    """Say what is known of the pixel size; the recording itself tells none."""
    if mm_per_px is None:
        return "Nothing tells me how large a pixel is: say for example 'a pixel is 0.06 mm'."
    return f"As it was said, a pixel is {mm_per_px:g} mm wide on the gel."


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
