"""Parts of sentences: points of view, amounts, movements, options and facts of a file."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from geotlm_lm.core.edit import Edit
from geotlm_lm.core.files import resource_dir
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component, way_words
from geotlm_lm.query.lines import Fact
from geotlm_lm.query.program import (
    EVENTS,
    Case,
    Expression,
    Field,
    Program,
    Text,
    head_of,
    type_of,
)
from geotlm_lm.query.quantities import Quantity
from geotlm_lm.query.values import Measure, Movement, Recording, Shown


@lru_cache(maxsize=1)
def replies() -> dict[str, Any]:
    """Return the replies: `help`, and by reason or topic `missing`, `untold` and `talk`."""
    return tomllib.loads((resource_dir("prompts") / "replies.toml").read_text("utf-8"))


_SO = {
    "turn": "it turns", "slide": "it slides", "press": "it presses in or lifts off",
    "cw": "it turns clockwise", "ccw": "it turns counterclockwise", "left": "it slides left",
    "right": "it slides right", "up": "it slides up", "down": "it slides down",
    "in": "it presses in", "out": "it lifts off", "x": "it slides along x",
    "y": "it slides along y", "move": "it moves", "tighten": "it tightens",
    "loosen": "it loosens", "still": "it is held still", "touch": "something touches",
    "none": "nothing touches", "slip": "it slips", "pause": "it pauses", "reverse": "it turns back",
    "other": "none of these", "unknown": "it cannot be told",
}  # fmt: skip
"""What is so or happens, as a clause."""

_TOPICS = {
    "rate": "frame rate", "interval": "time from frame to frame", "size": "size in pixels",
    "used": "frames that were looked at", "scale": "size of a pixel",
}  # fmt: skip
"""What is asked of a file, as a noun."""

_NOUNS = {
    "turn": "turns", "slide": "slides", "press": "presses", "cw": "clockwise turns",
    "ccw": "counterclockwise turns", "left": "slides to the left", "right": "slides to the right",
    "up": "slides up", "down": "slides down", "in": "presses", "out": "lift-offs",
    "x": "slides along x", "y": "slides along y", "move": "motions", "still": "rests",
    "touch": "touches", "none": "releases", "slip": "slips", "pause": "pauses",
    "reverse": "reversals", "contact": "contacts", "any": "events",
}  # fmt: skip
"""What happens, as a noun."""

_PHRASES = {
    "not": "it is not so that {0}", "and": "{0} and {1}", "or": "{0} or {1}",
    "xor": "either {0} or {1}, not both",
    ">": "{0} is more than {1}", "<": "{0} is less than {1}", "=": "{0} is {1}",
    "~": "{0} is about {1}", "in-range": "{0} is between {1} and {2}",
    "speeds-up": "{0} and gets faster", "slows-down": "{0} and gets slower",
    "happens": "there are any {0}", "before": "{0} comes before {1}",
    "after": "{0} comes after {1}", "ever": "at some moment {0}", "always": "all the time {0}",
    "lies": "the contact lies in the {0}", "same": "both clips have the same of {0}",
    "opposite": "the clips have the opposite of {0}", "mirrored": "the clips mirror {0}",
    "more": "the first clip has more of {0}", "less": "the first clip has less of {0}",
    "as-far": "both clips have about the same of {0}", "both": "in both clips {0}",
    "either": "in either clip {0}", "neither": "in neither clip {0}",
    "only-one": "in just one clip {0}",
    "amount": "how far {0}", "path": "how far {0}, there and back", "peak": "how far {0} at most",
    "net": "how far {0} net",
    "speed": "how fast {0}", "top-speed": "how fast {0} at most",
    "limit": "how little could be seen where {0}", "length": "how long {0} takes",
    "lasts": "how long the {0} take", "time-while": "for how long {0}",
    "share": "the share of time in which {0}", "count": "how many {0} there are",
    "delay": "the time from {0} to {1}", "clock": "{0}, from the recording's start",
    "area": "how much of the image is touched", "place-x": "where across the image the contact is",
    "place-y": "where down the image the contact is", "frame-rate": "the frame rate",
    "frame-count": "the number of frames", "frame-width": "the image's width",
    "frame-height": "the image's height", "chance": "how probable it is that {0}",
    "+": "{0} plus {1}", "-": "{0} minus {1}", "*": "{0} times {1}", "/": "{0} over {1}",
    "percent-of": "{0} in percent of {1}", "min": "the lesser of {0} and {1}",
    "max": "the greater of {0} and {1}", "abs": "the size of {0}", "negate": "minus {0}",
    "floor": "{0}, rounded down", "ceil": "{0}, rounded up", "sigma": "the deviation of {0}",
    "margin": "how far it is from it that {0}", "spread-of": "the deviation over the {0} of {1}",
    "then": "that moment", "those": "those", "gaps": "times between the {0}",
    "instead": "{1}, but of the {0}", "with": "{1}, but with {0}",
    "low": "the least that may be {0}", "high": "the most that may be {0}",
    "mean-of": "the mean over the {0} of {1}", "median-of": "the median over the {0} of {1}",
    "sum-of": "the sum over the {0} of {1}", "most-of": "the greatest over the {0} of {1}",
    "least-of": "the least over the {0} of {1}", "nearest": "{1}, to the nearest {0}",
    "unit": "{1}, in {0}", "per": "{1}, {0}", "round": "{1}, to {0} decimals",
    "t": "{0}", "begin": "the beginning of {0}", "end": "the end of {0}", "later": "{1} after {0}",
    "earlier": "{1} before {0}", "first-time": "when first {0}", "last-time": "when last {0}",
    "peak-time": "when {0} farthest", "top-speed-time": "when {0} fastest",
    **{pick: f"the {pick} {{0}}" for pick in ("first", "last", "largest", "longest", "fastest")},
    **{pick: f"the {pick} {{0}}" for pick in ("smallest", "shortest", "slowest")},
    "nth": "{1} number {0}", "next": "the next {1} after {0}",
    "previous": "the last {1} before {0}", "it": "that",
    "recording": "the whole recording", "contact": "the contact", "here": "it",
    "between": "from {0} to {1}", "initial": "the first {0} of {1}", "final": "the last {0} of {1}",
    "until": "the time up to {0}", "since": "the time from {0} on",
    "part": "part {0} of {1} of {2}",
    "around": "the {1} around {0}", "such": "those of the {1} for which {0}",
    "kind": "what kind of motion it is", "extent": "how far it goes", "story": "what happens",
    "which-clip": "in which clip {0}", "which-more": "which clip has more of {0}",
    "which-less": "which clip has less of {0}", "each": "of each of the {0}: {1}",
    "each-clip": "of each clip: {0}", "begins": "when each of the {0} begins",
    "ends": "when each of the {0} ends", "why": "why I say so", "sure": "how sure I am",
    "sure-amount": "how exact the amount is", "alternatives": "what else it could be",
    "place": "where the contact is", "help": "what can be asked", "why-of": "why {0}",
    "sure-of": "how sure it is that {0}", "setup": "which set-up I take it to have",
    "file": "the recording's {0}", "talk": "nothing", "cannot": "something that I cannot tell",
    "not-understood": "something that I did not understand", "again": "the same again",
    "within": "{1}, in {0}", "at": "{1}, at {0}", "if": "if {0}: {1}, else {2}",
    "plain": "{0}, as recorded", "of-first": "{0}, of the first clip",
    "of-second": "{0}, of the second clip", "of-previous": "{0}, of the clip before",
    "as-object": "{0}, of the object", "as-sensor": "{0}, of the sensor",
    "mirror": "{0}, in the mirror", "flip": "{0}, with the image upside down",
    "half": "{0}, with the image turned by 180 degrees",
    "quarter-cw": "{0}, with the image turned by 90 degrees clockwise",
    "quarter-ccw": "{0}, with the image turned by 90 degrees counterclockwise",
    "behind": "{0}, seen from the object's side", "backwards": "{0}, played backwards",
    "undo": "{0}, to undo it", "sensor": "{0}, of the sensor's own motion",
}  # fmt: skip
"""Every primitive with its arguments' words in their places."""

_UNIT = "turns"
"""The unit's name, which what moves is called as well."""

_ASKED = {"all": "it moves", "thread": "it tightens or loosens", "sign": "it turns, as a sign"}

_FACTS = {
    "mirrored": "the image is mirrored", "turned": "the image is turned", "thread": "thread",
    "side": "side that is touched", "scale": "size of a pixel", "view": "width of the view",
    "rate": "frame rate", "seen": "point of view", "moves": "what moves",
}  # fmt: skip


def restated(program: Program) -> str:
    """Return what a program asks as a phrase: "which way it turns, played backwards"."""
    facts = facts_phrase(program.facts)
    if not program.answers:
        return f"that {facts}"
    asked = "; ".join(map(_asked, program.answers))
    return f"{asked}, where {facts}" if program.facts else asked


def _asked(answer: Expression) -> str:
    words = phrase(answer)
    return f"whether {words}" if type_of(answer) == "bool" else words


def phrase(value: Any) -> str:
    """Return an expression, or a part of one, in words."""
    if isinstance(value, tuple):
        joint = " or " if value and isinstance(value[0], Case) else ", "
        return joint.join(map(phrase, value))
    if isinstance(value, Case):
        return phrase(value.holds)
    if isinstance(value, Field):
        return _asked(value.answer)
    if isinstance(value, Text):
        return f"word {value.index}"
    if isinstance(value, str):
        return _SO.get(value) or _TOPICS.get(value, value.replace("-", " "))
    if value.value is not None:
        return _number(value.value)
    word = value.word
    if word.endswith(EVENTS):
        return _NOUNS[word.removesuffix(EVENTS)]
    if word == "way":
        of = value.arguments[0]
        return f"which way {_ASKED.get(of) or _SO[of]}"
    if word in ("choose", "choose-not"):
        return f"which holds{' not' * (word == 'choose-not')}: {phrase(value.arguments[0])}"
    if word == "record":
        return phrase(value.arguments[0])
    if word in (">", "<", "~", "=", "in-range") and value.arguments[0].word == "amount":
        (atom,), *numbers = value.arguments[0].arguments, *map(phrase, value.arguments[1:])
        how = {">": "more than ", "<": "less than ", "~": "about ", "in-range": "between "}
        return f"{_SO[atom]} by {how.get(word, '')}{' and '.join(numbers)}"
    if not value.arguments and word in _SO:
        return _SO[word]
    if type_of(value) == "event" and word in _PHRASES and value.arguments:
        *others, events = map(phrase, value.arguments)
        return _PHRASES[word].format(*others, one_of(events))
    arguments = [_UNIT if each == "turn" and word == "unit" else phrase(each)
                 for each in value.arguments]  # fmt: skip
    return _PHRASES.get(word, word).format(*arguments)


def one_of(events: str) -> str:
    """Return the noun for one of several: "turn" of "turns", "slide to the left"."""
    noun, gap, rest = events.partition(" to the ")
    noun = noun.removesuffix("es") if noun.endswith(("sses", "ches")) else noun.removesuffix("s")
    return f"{noun}{gap}{rest}"


_ORDINALS = dict(enumerate(("", "second ", "third ", "fourth ", "fifth ", "sixth "), 1))


def which_phrase(event: Expression) -> str | None:
    """Return which of what happens is spoken of: "second turn"; None of what has no short name."""
    place, events = event.arguments if event.word == "nth" else (None, event)
    if not events.word.endswith(EVENTS):
        return None
    count, noun = None if place is None else phrase(place), one_of(phrase(events))
    if count is None:
        return noun
    ordinal = _ORDINALS.get(int(count)) if count.isdigit() else None
    return f"{noun} number {count}" if ordinal is None else f"{ordinal}{noun}"


def _number(value: Any) -> str:
    if not isinstance(value, Quantity):
        return f"number {value.index}"
    unit = {"percent": "%", "deg": "degrees", "frame": "frames"}.get(value.unit, value.unit)
    return f"{value.value:g} {unit}".strip()


def facts_phrase(facts: tuple[Fact, ...]) -> str:
    """Return what was stated: "left-hand thread, 0.06 mm per pixel"."""
    return ", ".join(map(_fact, facts)) or "nothing"


def _fact(fact: Fact) -> str:
    if fact.name == "everything":
        return "all that was stated is taken back"
    if fact.denied:
        if fact.name in ("mirrored", "turned"):
            return f"the image is not {fact.name}"
        return f"{_FACTS.get(fact.name, fact.name)} no longer stated"
    numbers = " ".join(map(_number, fact.numbers))
    return {
        "mirrored": "the image is mirrored",
        "turned": "the image is turned by "
        + {"half": "180 degrees", "quarter-cw": "90 degrees clockwise",
           "quarter-ccw": "90 degrees counterclockwise"}.get(fact.value, "nothing"),
        "seen": f"seen from the {fact.value}'s side",
        "moves": f"the {fact.value}'s motion is told",
        "thread": f"{fact.value}-hand thread",
        "side": f"touched at the {fact.value}",
        "scale": f"a pixel measures {numbers}",
        "view": f"the image shows {numbers}",
        "rate": f"{numbers.removesuffix('frame/s').strip()} frames per second",
        "unclear": "something that I did not understand",
    }[fact.name]  # fmt: skip


def is_talk(program: Program) -> bool:
    """Tell whether nothing is asked that an answer would claim anything of, nor refuse."""
    return all(head_of(each).word in ("talk", "help", "not-understood") for each in program.answers)


def is_refused(program: Program) -> bool:
    """Tell whether all that is asked is what touch cannot tell."""
    heads = {head_of(each).word for each in program.answers}
    return heads == {"cannot"}


DENIED = {"turn": "turn", "slide": "slide", "press": "press in or lift off"}
KIND_WORDS = {"turn": "rotation", "slide": "slide", "press": "press"}
UNSEEN = {
    Component.TURN: "how far cannot be seen",
    Component.SLIDE: "how far along the edge cannot be seen",
    Component.PRESS: "how deep cannot be seen",
}
_UNITS = {"deg": "degrees", "rad": "radians", "gon": "gradians", "turn": "turns", "inch": "inches",
          "frame": "frames", "percent": "%"}  # fmt: skip
_SINGULARS = {
    name: name.removesuffix("es" if name == "inches" else "s") for name in _UNITS.values()
}
"""Units' names, and what they are called of one."""
_A_UNIT = re.compile(rf"(?<![\d.])1 ({'|'.join(_SINGULARS)}|{'|'.join(_SINGULARS.values())})\b")
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
        name = _SINGULARS.get(name, name)
    per_phrase = f" per {_PER.get(per, per)}" if per else ""
    gap = "" if name in ("", "%") else " "
    return f"{gap}{name}{per_phrase}"


def with_plurals(text: str) -> str:
    """Return a text in which units are those of many, whatever number is copied before them."""
    plurals = {singular: plural for plural, singular in _SINGULARS.items()}
    return _A_UNIT.sub(lambda match: f"1 {plurals.get(match[1], match[1])}", text)


def with_singulars(text: str) -> str:
    """Return `with_plurals`' text as it was."""
    return _A_UNIT.sub(lambda match: f"1 {_SINGULARS.get(match[1], match[1])}", text)


def limit_phrase(limits: Sequence[Measure]) -> str:
    """Return how far what is not seen may go: " by more than 0.15 px (0.012 mm)"."""
    if not limits:
        return ""
    first, *others = (f"{each.limit:g} {_UNITS.get(each.unit, each.unit)}" for each in limits)
    return f" by more than {first}" + "".join(f" ({other})" for other in others)


def way_phrase(move: Movement | Shown) -> str:
    """Return where it goes: "left and a little up", "left and up"."""
    return way_words(move.way, move.aslant, is_diagonal=move.is_diagonal)


def movement_phrase(move: Movement) -> str:
    """Return one component with its amount: "turns clockwise, about 12 degrees"."""
    if move.component is Component.PRESS:
        text = "presses in" if move.way is Motion.PRESS else "lifts off"
        return text if move.amount is None else f"{text} about {amount_phrase(move.amount)}"
    text = f"{move.component}s {way_phrase(move)}"
    if move.amount is None:
        return f"{text} ({UNSEEN[move.component]})"
    return f"{text}, {'barely: ' * move.barely}about {amount_phrase(move.amount)}"


def label_of(case: Case) -> str:
    """Return what an option is called: its label, or what it says."""
    if case.label is None:
        return TRAIT_WORDS.get(case.holds.word) or phrase(case.holds)
    return case.label if isinstance(case.label, str) else f"{case.label.value:g}"


def all_of(parts: Sequence[str]) -> str:
    """Return phrases that hold commas as a list."""
    *others, last = parts
    return f"{', '.join(others)}, and {last}" if others else last


def undoing_phrase(moves: Sequence[Movement], edit: Edit) -> str:
    """Return the command that takes a motion back."""
    mover = "the sensor" if edit.sensor else "the object"
    parts = []
    for move in moves:
        if move.component is Component.PRESS:
            parts.append("press it in" if move.way is Motion.PRESS else "lift it off")
            continue
        far = "" if move.amount is None else f", about {amount_phrase(move.amount)}"
        parts.append(f"{move.component} {{}} {move.way.value}{far}")
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
