"""Programs composed at random and put into words, as deep as nobody asks but as regular as any.

They teach that parts mean the same wherever they stand. The words are those of `restated`.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

from geotlm_lm.core.edit import EDIT_WORDS
from geotlm_lm.query.lines import normal, write
from geotlm_lm.query.phrases import restated
from geotlm_lm.query.program import (
    ACCEPTED,
    COUNTS,
    GOING,
    LEANING,
    MOST_SLOTS,
    NAMES,
    TWO_CLIPS,
    Case,
    Expression,
    Field,
    Program,
    Slot,
    is_void,
    number,
    of,
    with_parts,
)
from geotlm_lm.query.quantities import Quantity, find
from geotlm_lm.training.grammar import Pair

FAMILY = "composed.train"
MOST_TEXT, MOST_PROGRAM = 40, 24
"""Words of a text and of a program, at most."""

_ASKED = ("bool", "bool", "number", "number", "number", "way", "label", "record", "time", "event")
_LEFT_OUT = {
    *LEANING, *TWO_CLIPS, *COUNTS, "again", "plain", "of-first", "of-second", "of-previous",
    *ACCEPTED["talk"].keys() - {"within", "at", "if"},
    "limit", "pi", "here", "unit", "per", "chance",
}  # fmt: skip
_RARE = {
    **dict.fromkeys((*EDIT_WORDS, "as-object", "as-sensor"), 0.1),
    **dict.fromkeys(("low", "high", "sigma", "margin", "floor", "ceil", "negate", "xor"), 0.4),
}
"""How often a word is drawn against 1 for the others."""
_OPENERS = (
    "{}", "{}?", "{}.", "tell me {}", "tell me {}.", "say {}", "i want to know {}", "please say {}",
    "could you tell me {}?", "i need {}", "find {}", "report {}", "what about this: {}?",
)  # fmt: skip
_UNITS = {
    "turn": ("deg", "deg", "rad"), "cw": ("deg",), "ccw": ("deg",), "move": ("px", "deg"),
    **dict.fromkeys(("slide", "left", "right", "up", "down", "x", "y"), ("px", "mm", "mm")),
    **dict.fromkeys(("press", "in", "out"), ("mm",)),
    **dict.fromkeys(("length", "lasts", "time-while", "delay", "clock", "t"), ("s", "s", "ms")),
    **dict.fromkeys(("share", "area"), ("percent",)),
}  # fmt: skip
"""Units that stand beside what is measured."""


def composed(rng: random.Random) -> Iterator[Pair]:
    """Yield pairs without end."""
    while True:
        asked = rng.choice(_ASKED)
        program = Program((_drawn(rng, asked, rng.choice((2, 3, 3, 4))),))
        pair = None if is_void(program) else _pair(rng, program)
        if pair is not None:
            yield pair


def _pair(rng: random.Random, program: Program) -> Pair | None:
    """Return a program in words, its numbers as slots; None where they do not fit together."""
    text = rng.choice(_OPENERS).format(restated(program))
    stated = [each.quantity for each in find(text)]
    if len(stated) > MOST_SLOTS or len(text.split()) > MOST_TEXT:
        return None
    try:
        line = write(_placed(normal(program), stated))
    except LookupError:
        return None
    return Pair(text, line, (FAMILY,)) if len(line.split()) <= MOST_PROGRAM else None


def _placed(value: Any, stated: list[Quantity]) -> Any:
    """Return a program, or a part of one, with its numbers as the slots that they stand in.

    Raises:
        LookupError: If one stands in none, or in two.
    """
    if isinstance(value, Quantity):
        if stated.count(value) != 1:
            raise LookupError(f"{value} stands in {stated.count(value)} places")
        return Slot(stated.index(value) + 1)
    return with_parts(value, lambda part: _placed(part, stated))


def _drawn(rng: random.Random, wanted: str, depth: int) -> Expression | str:
    """Return an expression of a type, no deeper than `depth`."""
    if wanted in NAMES:
        return rng.choice(NAMES[wanted])
    accepted = {word: takes for word, takes in ACCEPTED[wanted].items() if word not in _LEFT_OUT}
    leaves = [word for word, takes in accepted.items() if all(each in NAMES for each in takes)]
    if wanted == "number" and (depth <= 0 or rng.random() < 0.1):
        return of(rng.choice(GOING[:2]), rng.choice(("turn", "slide", "cw", "left")))
    if wanted == "time" and rng.random() < 0.4:
        return of("t", _quantity(rng, ("s", "s", "ms", "frame")))
    if wanted == "events" and rng.random() < 0.8:
        return of(rng.choice(leaves))
    words = leaves if depth <= 0 and leaves else list(accepted)
    (word,) = rng.choices(words, [_RARE.get(each, 1.0) for each in words])
    return _with(rng, word, accepted, depth)


def _with(rng: random.Random, word: str, accepted: dict, depth: int) -> Expression:
    takes = accepted[word]
    if word in (">", "<", "=", "~", "in-range", "margin") and "number" in takes:
        measure = _measure(rng, depth)
        units = _UNITS.get(_subject(measure), ("",))
        return of(word, measure, *(_quantity(rng, units) for _ in takes[1:]))
    arguments = []
    for each in takes:
        if each == "cases":
            count = rng.choice((2, 2, 3))
            arguments.append(tuple(Case(_drawn(rng, "bool", 0)) for _ in range(count)))
        elif each == "fields":
            kinds = rng.sample(("way", "number", "bool", "time"), rng.choice((2, 2, 3)))
            arguments.append(tuple(Field(_drawn(rng, kind, min(depth - 1, 1))) for kind in kinds))
        elif each == "number" and word in ("initial", "final", "around", "later", "earlier"):
            arguments.append(_quantity(rng, ("s", "ms", "frame")))
        elif each == "number" and word in ("nth", "part", "nearest"):
            arguments.append(_quantity(rng, ("",)))
        else:
            arguments.append(_drawn(rng, each, depth - 1))
    return of(word, *arguments)


def _measure(rng: random.Random, depth: int) -> Expression:
    if rng.random() < 0.6:
        return of(rng.choice(GOING[:4]), _drawn(rng, "of", 0))
    return _drawn(rng, "number", min(depth - 1, 2))


def _subject(measure: Expression) -> str:
    """Return what a number measures, as `_UNITS` names it."""
    if measure.word in _UNITS:
        return measure.word
    inner = [each for each in measure.arguments if isinstance(each, str) and each in _UNITS]
    return inner[0] if inner else ""


def _quantity(rng: random.Random, units: tuple[str, ...]) -> Expression:
    unit = rng.choice(units)
    most = {"": 9, "rad": 3, "mm": 9, "s": 12, "ms": 900, "percent": 99, "frame": 200}
    value = rng.uniform(1, most.get(unit, 180))
    whole = unit in ("", "frame", "percent", "deg", "px", "ms") or rng.random() < 0.4
    return number(Quantity(float(round(value)) if whole else round(value, 1), unit))
