"""Parts of sentences: points of view, amounts, movements, options and facts of a file."""

from __future__ import annotations

from collections.abc import Sequence

from geotlm_lm.core.edit import Edit, opposite
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.query.amounts import Measure, Recording
from geotlm_lm.query.program import EVENTS, Case, Expression
from geotlm_lm.query.replies import replies
from geotlm_lm.query.restated import one_of, phrase
from geotlm_lm.query.values import Movement

GOES = {Component.TURN: "turns", Component.SLIDE: "slides"}
DENIED = {
    Component.TURN: "turn",
    Component.SLIDE: "slide",
    Component.PRESS: "press in or lift off",
}
UNSEEN = {
    Component.TURN: "how far cannot be seen",
    Component.SLIDE: "how far along the edge cannot be seen",
    Component.PRESS: "how deep cannot be seen",
}
_UNITS = {"deg": "degrees", "rad": "radians", "gon": "gradians", "turn": "turns", "inch": "inches",
          "frame": "frames", "percent": "%"}  # fmt: skip
_PER = {"s": "second", "min": "minute", "frame": "frame", "ms": "millisecond", "deg": "degree",
        "rad": "radian"}  # fmt: skip
_IMAGE = {
    "mirror": "mirrored",
    "flip": "flipped upside down",
    "half": "turned by 180 degrees",
    "quarter-cw": "turned by 90 degrees clockwise",
    "quarter-ccw": "turned by 90 degrees counterclockwise",
}
TRAIT_WORDS = {
    "cw": "clockwise", "ccw": "counterclockwise", "in": "pressing in", "out": "lifting off",
    "x": "horizontally", "y": "vertically", "none": "no contact", "turn": "turning",
    "slide": "sliding", "press": "pressing in", "move": "moving", "still": "holding still",
    "touch": "touching", "tighten": "tightening", "loosen": "loosening",
}  # fmt: skip


def where_phrase(edit: Edit, frame: FrameSpec) -> str:
    """Return a point of view: what was stated of the image, or what is supposed."""
    stated = frame.edit
    is_stated = edit.rotation == stated.rotation and edit.behind == stated.behind
    place = "seen from the object's side" if edit.behind else "in the camera image"
    if is_stated and (frame.turning() or frame.image_mirrored):
        changed = ["the mirror undone"] * frame.image_mirrored
        if frame.turning():
            # Of a quarter turn and a mirror the order matters, and is that of `FrameSpec`.
            turned = f"the image {frame.turning()}"
            changed = [turned, *changed] if frame.image_quarter_turn else [*changed, turned]
        place += f" with {joined(changed)}"
    else:
        image = [_IMAGE[word] for word in edit.words if word in _IMAGE]
        if image:
            place += f"{' with the image' if edit.behind else ''} {' and '.join(image)}"
    return place + ", played backwards" * edit.backwards


def joined(parts: Sequence[str]) -> str:
    """Return phrases as a list: "a, b and c"."""
    *others, last = parts
    return f"{', '.join(others)} and {last}" if others else last


def amount_phrase(amount: Measure, *, with_span: bool = False) -> str:
    """Return an amount with its unit: "12 degrees", "3.5 mm per second, likely 3 to 4"."""
    text = f"{amount.figure}{unit_phrase(amount)}"
    low, high = amount.span
    is_spread = with_span and amount.deviation > 0 and low != high
    return f"{text}, likely {low:.10g} to {high:.10g}" if is_spread else text


def count_phrase(count: Measure, events: Expression) -> str:
    """Return how many events there are: "2 turns"."""
    nouns = phrase(events) if events.word.endswith(EVENTS) else "times"
    return f"{count.value:g} {one_of(nouns) if count.value == 1 else nouns}"


def unit_phrase(amount: Measure) -> str:
    """Return the unit behind a number: " degrees", "%", " mm per second"."""
    unit, _, per = amount.unit.partition("/")
    name = _UNITS.get(unit, unit)
    if amount.value == 1:
        name = name.removesuffix("s") if name not in ("s", "ms", "us") else name
    per_phrase = f" per {_PER.get(per, per)}" if per else ""
    gap = "" if name in ("", "%") else " "
    return f"{gap}{name}{per_phrase}"


def limit_phrase(limits: Sequence[Measure]) -> str:
    """Return how far what is not seen may go: " by more than 0.15 px (0.012 mm)"."""
    if not limits:
        return ""
    first, *others = (f"{each.limit:g} {_UNITS.get(each.unit, each.unit)}" for each in limits)
    return f" by more than {first}" + "".join(f" ({other})" for other in others)


def way_phrase(move: Movement) -> str:
    """Return where it goes: "left and a little up"."""
    return f"{move.way.value} and a little {move.aslant.value}" if move.aslant else move.way.value


def movement_phrase(move: Movement) -> str:
    """Return one component with its amount: "turns clockwise, about 12 degrees"."""
    if move.component is Component.PRESS:
        text = "presses in" if move.way is Motion.PRESS else "lifts off"
        return text if move.amount is None else f"{text} about {amount_phrase(move.amount)}"
    text = f"{GOES[move.component]} {way_phrase(move)}"
    if move.amount is None:
        return f"{text} ({UNSEEN[move.component]})"
    return f"{text}, {'barely: ' * move.barely}about {amount_phrase(move.amount)}"


def label_of(case: Case) -> str:
    """Return what an option is called: its label, or what it says."""
    if case.label is None:
        return case_phrase(case)
    return case.label if isinstance(case.label, str) else f"{case.label.value:g}"


def case_phrase(case: Case) -> str:
    """Return an option in words."""
    return TRAIT_WORDS.get(case.holds.word) or phrase(case.holds)


def all_of(parts: Sequence[str]) -> str:
    """Return phrases that hold commas as a list."""
    *others, last = parts
    return f"{', '.join(others)}, and {last}" if others else last


def undoing_phrase(moves: Sequence[Movement], edit: Edit) -> str:
    """Return the command that takes a motion back."""
    verbs = {Component.TURN: "turn", Component.SLIDE: "slide"}
    mover = "the sensor" if edit.sensor else "the object"
    parts = []
    for move in moves:
        if move.component is Component.PRESS:
            parts.append("press it in" if move.way is Motion.PRESS else "lift it off")
            continue
        far = "" if move.amount is None else f", about {amount_phrase(move.amount)}"
        parts.append(f"{verbs[move.component]} {{}} {move.way.value}{far}")
    return all_of(parts).replace("{}", mover, 1).replace("{}", "it")


def file_phrase(topic: str, recording: Recording, frame: FrameSpec) -> str:
    """Return a fact about the file."""
    rate, length = recording.rate_hz, recording.duration_s
    if topic == "frames":
        return f"{recording.frames} frames"
    if topic == "used":
        return f"frames {joined([str(number) for number in recording.used])}"
    if topic == "size":
        return f"{recording.columns} by {recording.rows} pixels"
    if topic == "scale":
        size = frame.mm_per_px
        return replies()["missing"]["scale"] if size is None else f"{size:g} mm per pixel"
    if rate is None:
        return replies()["missing"]["rate"]
    if topic == "rate":
        return f"{rate:g} frames per second"
    if topic == "interval":
        return f"{1000 / rate:.3g} ms from frame to frame"
    return f"{length or (recording.frames - 1) / rate:.3g} s"


def opposite_phrase(way: Motion) -> str:
    """Return the way that takes another one back."""
    return opposite(way).value
