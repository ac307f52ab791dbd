"""Put decisions into words: short, what is asked first, the frame named once."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion, MotionClass, reverse
from geotlm_lm.core.twist import WAYS, Component
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import Measure, Recording
from geotlm_lm.query.decision import Decision, Movement
from geotlm_lm.query.edit import Edit
from geotlm_lm.query.replies import replies

_GOES = {Component.TURN: "turns", Component.SLIDE: "slides"}
_DENIED = {
    Component.TURN: "turn",
    Component.SLIDE: "slide",
    Component.PRESS: "press in or lift off",
}
_REST = {Motion.STILL: "it touches but does not move", Motion.NONE: "nothing touches the gel"}
_UNSEEN = {
    Component.TURN: "how far cannot be seen",
    Component.SLIDE: "how far along the edge cannot be seen",
    Component.PRESS: "how deep cannot be seen",
}
_KINDS = {
    Component.TURN: MotionClass.ROTATION,
    Component.SLIDE: MotionClass.SLIDE,
    Component.PRESS: MotionClass.PRESS,
}
_IMAGE_WORDS = {
    "mirror": "mirrored",
    "flip": "flipped upside down",
    "half": "turned by 180 degrees",
    "quarter-cw": "turned by 90 degrees clockwise",
    "quarter-ccw": "turned by 90 degrees counterclockwise",
}
_UNIT_NAMES = {
    "deg": "degrees",
    "rad": "radians",
    "turn": "turns",
    "inch": "inches",
}
_ATOMS = {"move": "it moves", "touch": "it touches", "still": "it holds still"}
SECOND_CLIP = ("the first", "the second")


def tell(decision: Decision, recording: Recording | None = None) -> str:
    """Return a decision as a sentence or two.

    Args:
        decision: What is told.
        recording: For questions on the file itself.
    """
    ask = decision.part.ask
    if decision.missing is not None:
        return replies()["missing"][decision.missing]
    if ask.kind == "unanswerable":
        return replies()["untold"][ask.topic]
    if ask.kind == "talk":
        return replies()["talk"][ask.topic]
    if ask.kind == "recording":
        return _recording(ask.topic, recording or Recording(), decision.frame)
    if ask.kind == "setup":
        return f"I tell it in this frame: {decision.frame.sentence()}."
    is_of_two = decision.part.subject.clip in t.OF_SEVERAL
    teller = _compare if is_of_two else _TELLERS.get(ask.kind)
    return replies()["help"] if teller is None else _sentence(teller(decision))


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}" + "." * (text[-1:] not in ".?!")


def frame_phrase(edit: Edit) -> str:
    """Return the point of view as a phrase: "in the camera image, played backwards"."""
    place = "seen from the object's side" if edit.behind else "in the camera image"
    image = [_IMAGE_WORDS[word] for word in edit.words if word in _IMAGE_WORDS]
    if image:
        place += f"{' with the image' if edit.behind else ''} {' and '.join(image)}"
    return place + ", played backwards" * edit.backwards


def _clause(decision: Decision, *, with_denied: bool = True) -> str:
    """Return what moves, what of the asked does not, and the frame where a way is named."""
    edit = decision.edit
    who = "the sensor" if edit.sensor else "it"
    denied = " or ".join(_DENIED[one] for one in decision.denied) if with_denied else ""
    if decision.rest is not None:
        rest = _REST[decision.rest]
        return f"{who} does not {denied}: {rest}" if denied else rest
    parts = _joined([_movement(one) for one in decision.movements])
    where = ""
    if any(one.way in DIRECTED for one in decision.movements):
        where = f"{',' * (',' in parts)} {frame_phrase(edit)}"
    if edit.undo:
        return _undoing(decision.movements, edit) + where
    told = f"{who} {parts}{where}"
    asked = [one.component for one in decision.movements]
    if not denied:
        return told
    is_instead = not set(asked) & set(_asked(decision.part.ask))
    return f"{who} does not {denied}; {told}" if is_instead else f"{told}; {who} does not {denied}"


def _asked(ask: t.Ask) -> tuple[Component, ...]:
    return (t.COMPONENT_ATOMS[ask.of],) if ask.of in t.COMPONENT_ATOMS else ()


def _movement(move: Movement, *, verb: str | None = None) -> str:
    way = f"{move.way.value} and a little {move.aslant.value}" if move.aslant else move.way.value
    if move.component is Component.PRESS:
        text = "presses in" if move.way is Motion.PRESS else "lifts off"
        text = text if verb is None else {"turn": "press", "slide": "press"}.get(verb, text)
    else:
        text = f"{verb or _GOES[move.component]} {way}"
    if move.amount is None:
        return f"{text} ({_UNSEEN[move.component]})"
    return f"{text}, {'barely: ' * move.barely}about {amount_phrase(move.amount)}"


def _undoing(moves: Sequence[Movement], edit: Edit) -> str:
    """Return the command that takes a motion back, for either mover."""
    verbs = {Component.TURN: "turn", Component.SLIDE: "slide"}
    found: dict[bool, list[str]] = {False: [], True: []}
    for move in moves:
        for is_other in found:
            if move.component is Component.PRESS:
                text = "press it in" if move.way is Motion.PRESS else "lift it off"
                found[is_other].append(text)
                continue
            way = reverse(move.way) if is_other else move.way
            found[is_other].append(f"{verbs[move.component]} {{}} {way.value}")
    movers = ("the sensor", "the object") if edit.sensor else ("the object", "the sensor")
    one, other = (_joined(found[key]).replace("{}", who, 1).replace("{}", "it")
                  for key, who in zip(found, movers, strict=True))  # fmt: skip
    return one if one == other else f"{one}, or {other}"


def _joined(parts: Sequence[str]) -> str:
    *others, last = parts
    return f"{', '.join(others)} and {last}" if others else last


def amount_phrase(amount: Measure, *, with_span: bool = False) -> str:
    """Return an amount with its unit: "12 degrees", "3.5 mm per second"."""
    unit, _, per = amount.unit.partition("/")
    name = _UNIT_NAMES.get(unit, unit)
    if amount.value == 1 and name.endswith("s"):
        name = name[:-1]
    per = {"s": " per second", "min": " per minute", "frame": " per frame"}.get(per, "")
    text = f"{amount.value:g} {name}{per}"
    low, high = amount.span
    return f"{text}, likely {low:g} to {high:g}" if with_span else text


def _claim(decision: Decision) -> str:
    word = "yes" if decision.verdict else "no"
    # A bare "no" to a denial could be read either way.
    if decision.part.ask.proposition.denies:
        word += ", that is so" if decision.verdict else ", that is not so"
    return f"{word}: {_clause(decision)}"


def _choice(decision: Decision) -> str:
    options = decision.part.ask.options
    chosen = [options[at] for at in decision.options]
    labels = [one.label for one in chosen if one.label]
    told = _clause(decision)
    if decision.part.ask.denied:
        names = _joined([_option(one) for one in chosen]) if chosen else "none of them"
        return f"not {names}: {told}"
    if not chosen:
        return f"none of these: {told}"
    if len(options) == 2 and len(chosen) == 2:
        told = f"both: {told}"
    if any(one.proposition.literals[0].atom in t.THREAD_ATOMS for one in chosen):
        told = f"it {_option(chosen[0])}s: {told}"
    return f"{told}: {' and '.join(labels)}" if labels else told


def _option(option: t.Option) -> str:
    joint = f" {option.proposition.joint} "
    return joint.join(
        "not " * one.denied + WORDS.get(one.atom, one.atom) for one in option.proposition.literals
    )


WORDS = {atom: way.value for atom, way in t.WAY_ATOMS.items()} | {"in": "pressing in"}
WORDS |= {"out": "lifting off", "x": "horizontally", "y": "vertically", "none": "no contact"}
"""Atoms as words, where these differ."""


def _amount(decision: Decision) -> str:
    if not decision.amounts:
        return _clause(decision)
    told = _joined([f"about {amount_phrase(one, with_span=True)}" for one in decision.amounts])
    if decision.rest is not None:
        return f"{told}; {_REST[decision.rest]}"
    names = [one.way.value for one in decision.movements]
    return f"{told}: {' and '.join(names)} {frame_phrase(decision.edit)}"


def _kind(decision: Decision) -> str:
    if decision.rest is not None:
        return {Motion.STILL: "a still contact", Motion.NONE: "no contact"}[decision.rest]
    kinds = [_KINDS[one.component].value for one in decision.movements]
    return f"a {' and a '.join(kinds)}: {_clause(decision)}"


def _how_sure(decision: Decision) -> str:
    return f"about {decision.probability:.0%}: {_clause(decision)}"


def _alternatives(decision: Decision) -> str:
    ways = [way for ways in WAYS.values() for way in ways]
    told = {one.way for one in decision.movements}
    ranked = sorted(zip(decision.chances, ways, strict=True), key=lambda one: -one[0])
    chance, way = next(one for one in ranked if one[1] not in told)
    return f"next likeliest is {way.value}, {chance:.0%}; {_clause(decision)}"


def _times(decision: Decision) -> str:
    ask, times = decision.part.ask, decision.times
    if ask.kind == "how-often":
        return f"{times[0]:g} time{'s' * (times[0] != 1)}"
    if ask.kind == "how-long":
        return f"for {times[0]:.2g} s altogether"
    if decision.verdict is not None:
        return "yes" if decision.verdict else "no"
    if not times:
        return "never in this recording"
    return f"at {_joined([f'{one:.2f} s' for one in times])}"


def _compare(decision: Decision) -> str:
    word = {True: "yes: ", False: "no: ", None: ""}[decision.verdict]
    if decision.amounts:
        parts = [amount_phrase(one) for one in decision.amounts]
    else:
        parts = [_movement(one) for one in decision.movements] or ["neither moves"]
    if len(parts) == 2:
        parts = [f"{who}, {one}" for who, one in zip(SECOND_CLIP, parts, strict=True)]
    if decision.options:
        word = f"{' and '.join(SECOND_CLIP[at] for at in decision.options)}: "
    has_way = any(one.way in DIRECTED for one in decision.movements)
    return f"{word}{'; '.join(parts)}" + f" ({frame_phrase(decision.edit)})" * has_way


def _which(decision: Decision) -> str:
    return " and ".join(SECOND_CLIP[at] for at in decision.options) or "neither"


def _recording(topic: str, recording: Recording, frame: FrameSpec) -> str:
    rate = recording.rate_hz
    found = {
        "frames": f"{recording.frames} frames",
        "size": f"{recording.columns} x {recording.rows} pixels",
        "used": f"frames {', '.join(map(str, recording.used))}",
        "rate": f"{rate:g} frames per second" if rate else None,
        "interval": f"{1000 / rate:.3g} ms" if rate else None,
        "duration": f"{recording.frames / rate:.3g} s" if rate else None,
        "scale": frame.mm_per_px and f"{frame.mm_per_px:g} mm per pixel",
    }[topic]
    lacking = "scale" if topic == "scale" else "rate"
    return replies()["missing"][lacking] if found is None else _sentence(found)


_TELLERS: dict[str, Callable[[Decision], str]] = {
    "way": _clause,
    "why": _clause,
    "kind": _kind,
    "claim": _claim,
    "choice": _choice,
    "amount": _amount,
    "how-sure": _how_sure,
    "alternatives": _alternatives,
    "when": _times,
    "how-long": _times,
    "how-often": _times,
    "order": _times,
    "compare": _compare,
    "which-clip": _which,
}
