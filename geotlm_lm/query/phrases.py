"""Words that several sentences share: the point of view, amounts, the names of atoms."""

from __future__ import annotations

from collections.abc import Sequence

from geotlm_lm.core.edit import Edit, opposite
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import Measure
from geotlm_lm.query.decision import Decision, Movement

GOES = {Component.TURN: "turns", Component.SLIDE: "slides"}
UNSEEN = {
    Component.TURN: "how far cannot be seen",
    Component.SLIDE: "how far along the edge cannot be seen",
    Component.PRESS: "how deep cannot be seen",
}
"""Said in place of an amount that the picture does not tell."""

_IMAGE_WORDS = {
    "mirror": "mirrored",
    "flip": "flipped upside down",
    "half": "turned by 180 degrees",
    "quarter-cw": "turned by 90 degrees clockwise",
    "quarter-ccw": "turned by 90 degrees counterclockwise",
}
_UNIT_NAMES = {"deg": "degrees", "rad": "radians", "turn": "turns", "inch": "inches"}
_PER = {"s": " per second", "min": " per minute", "frame": " per frame"}

WORDS = {atom: way.value for atom, way in t.WAY_ATOMS.items()} | {
    "in": "pressing in",
    "out": "lifting off",
    "x": "horizontally",
    "y": "vertically",
    "none": "no contact",
    "turn": "turning",
    "slide": "sliding",
    "press": "pressing in",
    "move": "moving",
    "still": "holding still",
    "touch": "touching",
    "tighten": "tightening",
    "loosen": "loosening",
}
"""Atoms as words, where these differ."""


def frame_phrase(edit: Edit) -> str:
    """Return the point of view as a phrase: "in the camera image, played backwards"."""
    place = "seen from the object's side" if edit.behind else "in the camera image"
    image = [_IMAGE_WORDS[word] for word in edit.words if word in _IMAGE_WORDS]
    if image:
        place += f"{' with the image' if edit.behind else ''} {' and '.join(image)}"
    return place + ", played backwards" * edit.backwards


def in_frame(decision: Decision) -> str:
    """Return ", in the camera image" and the like; nothing where it was named before."""
    return "" if decision.is_frame_known else f", {where_phrase(decision)}"


def where_phrase(decision: Decision) -> str:
    """Return the point of view of a decision: what was stated of the image, or supposed."""
    edit, frame = decision.part.edit, decision.frame
    is_stated = edit.rotation == Edit().rotation and not edit.behind
    if not is_stated or (not frame.turning() and not frame.image_mirrored):
        return frame_phrase(decision.edit)
    seen = "seen from the object's side" if decision.edit.behind else "in the camera image"
    changed = ["the mirror undone"] * frame.image_mirrored
    if frame.turning():
        # Of a quarter turn and a mirror the order matters, and is that of `FrameSpec`.
        turned = f"the image {frame.turning()}"
        changed = [turned, *changed] if frame.image_quarter_turn else [*changed, turned]
    return f"{seen} with {joined(changed)}" + ", played backwards" * decision.edit.backwards


def joined(parts: Sequence[str]) -> str:
    """Return phrases as a list: "a, b and c"."""
    *others, last = parts
    return f"{', '.join(others)} and {last}" if others else last


def amount_phrase(amount: Measure, *, with_span: bool = False) -> str:
    """Return an amount with its unit: "12 degrees", "3.5 mm per second"."""
    unit, _, per = amount.unit.partition("/")
    name = _UNIT_NAMES.get(unit, unit)
    if amount.value == 1:
        name = name.removesuffix("s")
    text = f"{amount.value:g} {name}{_PER.get(per, '')}"
    low, high = amount.span
    return f"{text}, likely {low:g} to {high:g}" if with_span else text


def limit_phrase(limits: Sequence[Measure]) -> str:
    """Return how far what is not seen may go: " by more than 0.15 px (0.012 mm)"."""
    if not limits:
        return ""
    first, *others = (f"{each.limit:g} {_UNIT_NAMES.get(each.unit, each.unit)}" for each in limits)
    return f" by more than {first}" + "".join(f" ({other})" for other in others)


def movement_phrase(move: Movement) -> str:
    """Return one component with its amount: "turns clockwise, about 12 degrees"."""
    if move.component is Component.PRESS:
        text = "presses in" if move.way is Motion.PRESS else "lifts off"
    else:
        text = f"{GOES[move.component]} {way_words(move)}"
    if move.amount is None:
        return f"{text} ({UNSEEN[move.component]})"
    return f"{text}, {'barely: ' * move.barely}about {amount_phrase(move.amount)}"


def way_words(move: Movement) -> str:
    """Return where it goes: "left and a little up"."""
    return f"{move.way.value} and a little {move.aslant.value}" if move.aslant else move.way.value


def undoing_phrase(moves: Sequence[Movement], edit: Edit) -> str:
    """Return the command that takes a motion back, for either mover."""
    verbs = {Component.TURN: "turn", Component.SLIDE: "slide"}
    found: dict[bool, list[str]] = {False: [], True: []}
    for move in moves:
        for is_other in found:
            if move.component is Component.PRESS:
                found[is_other].append("press it in" if move.way is Motion.PRESS else "lift it off")
                continue
            way = opposite(move.way) if is_other else move.way
            far = "" if move.amount is None else f", about {amount_phrase(move.amount)}"
            found[is_other].append(
                f"{verbs[move.component]} {{}} {way.value}{'' if is_other else far}"
            )
    movers = ("the sensor", "the object") if edit.sensor else ("the object", "the sensor")
    one, other = (
        joined(found[key]).replace("{}", who, 1).replace("{}", "it")
        for key, who in zip(found, movers, strict=True)
    )
    return one if one == other else f"{one}, or {other}"
