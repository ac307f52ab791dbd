"""Explain a motion in words, by rule, from the geometry that a model read; knows no model.

The shear change of a contact is a common shift and what its halves do against each other. The mean
is the shift: differences cancel in it. The differences of opposite halves are free of the shift:
those across (upper and lower along x, left and right along y) add up in a turn, those along (left
and right along x, upper and lower along y) add up where the gel is pressed apart.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, signed_amount
from geotlm_lm.query.answers import answers
from geotlm_lm.query.evaluate import Evidence
from geotlm_lm.query.phrases import phrase
from geotlm_lm.query.program import (
    AROUND,
    Expression,
    Program,
    dimension_of,
    head_of,
    of,
    type_of,
)
from geotlm_lm.query.reader import MISSING
from geotlm_lm.query.stories import MOST_TOLD, most
from geotlm_lm.query.telling import Teller
from geotlm_lm.query.values import Amount, Record, Times, Unknown, Value

Regions = Mapping[str, Mapping[str, float]]
"""Shear change (x right, y down, unitless) and contact mass of each of the seven regions."""

FAINT = 0.15
"""A shift below this share of the greatest one is not said to go anywhere."""

EMPTY_HALF = 0.01
"""Contact mass below which a half counts as untouched."""

LOPSIDED = 1.5
"""How many times more contact makes a half the one where the contact is."""


@dataclass(frozen=True)
class Pattern:
    """The common shift and the differences of the seven regions, unitless.

    Args:
        turn: How far a half is carried by the turn, positive clockwise as drawn in the image.
        slide_x: Mean to the right.
        slide_y: Mean down.
        apart: How far a half is pressed outwards, negative when the halves close up.
    """

    turn: float
    slide_x: float
    slide_y: float
    apart: float

    def along(self, motion: Motion) -> float | None:
        """Return how strongly the pattern goes the way of `motion`, negative against it.

        None for motions that no shift shows: still and untouched.
        """
        return signed_amount(
            motion, turn=self.turn, right=self.slide_x, down=self.slide_y, inward=self.apart
        )


def pattern_of(regions: Regions) -> Pattern:
    """Return the pattern of the regions' shear changes.

    A turn carries the upper half right and the lower half left by as much as the left half up and
    the right half down, so each of the two differences is twice a half's own shift.
    """
    x = {name: values["shear_change_x"] for name, values in regions.items()}
    y = {name: values["shear_change_y"] for name, values in regions.items()}
    return Pattern(
        turn=(x["upper_minus_lower"] - y["left_minus_right"]) / 4,
        slide_x=x["global"],
        slide_y=y["global"],
        apart=-(x["left_minus_right"] + y["upper_minus_lower"]) / 4,
    )


def halves(regions: Regions) -> str:
    """Describe the shift of the whole contact, and of its halves against each other."""
    differences = ("upper_minus_lower", "left_minus_right")
    shifts = [_shift(regions, name) for name in (*differences, "global")]
    greatest = max(abs(value) for shift in shifts for value in shift)
    whole = _way(_shift(regions, "global"), greatest)
    parts = [f"the whole contact goes {whole}" if whole else "the whole contact stays"]
    for name in differences:
        first, second = name.split("_minus_")
        empty = [half for half in (first, second) if regions[half]["contact_mass"] < EMPTY_HALF]
        way = _way(_shift(regions, name), greatest)
        if empty:
            parts.append(f"the {empty[0]} half is untouched")
        elif way:
            parts.append(f"the {first} half goes {way} against the {second} half")
        else:
            parts.append(f"the {first} and {second} halves go alike")
    return ", ".join(parts)


def contact_place(regions: Regions, share: float) -> str:
    """Return how much of the view is touched, and where, as one clause."""
    parts = [_heavier(regions, "upper", "lower"), _heavier(regions, "left", "right")]
    where = " ".join(part for part in parts if part) or "in the middle"
    return f"contact fills {share:.0%} of the square looked at, most of it {where}"


def reasoning_steps(
    evidence: Mapping[str, Any],
    conclusion: str,
    motion: Motion | None,
    *,
    is_as_seen: bool = True,
) -> tuple[str, ...]:
    """Return the steps from the contact to the conclusion, one sentence each.

    Args:
        evidence: Contact share and regions, as an answer carries them.
        conclusion: The answer's sentence.
        motion: The motion the model claims, in the camera image; None if none.
        is_as_seen: Whether the conclusion names directions as the camera image shows them; the
            steps before it, which always do, say so where it does not.

    Returns:
        Where the contact is; how its halves go; what adds up and what cancels; the conclusion.
    """
    where = "" if is_as_seen else "in the camera image"
    sums = _sums(pattern_of(evidence["regions"]), motion, where)
    steps = (*contact_steps(evidence, where), *([sums] if sums else []))
    return (*steps, f"Therefore: {conclusion}")


def contact_steps(evidence: Mapping[str, Any], where: str = "") -> tuple[str, str]:
    """Return where the contact is and how its halves go, one sentence each."""
    regions = evidence["regions"]
    place = contact_place(regions, evidence["contact_share"])
    return _sentence(place), _sentence(f"{where} {halves(regions)}".strip())


def times_step(values: Sequence[Value], evidence: Evidence, frame: FrameSpec) -> str:
    """Return which events and spans times rest on, from when to when, in a sentence.

    Args:
        values: What was asked came to.
        evidence: Of the clip.
        frame: In which it is told.

    Returns:
        "" where nothing of it is a time.
    """
    teller = Teller(evidence.recording.at_rate(frame.rate_hz, overrides=True), frame)
    parts: list[str] = []
    for value in values:
        if isinstance(value, Record) and value.of.word == "record":
            parts += [times_step([each], evidence, frame) for _, each in value.fields]
        elif _is_of_time(value):
            spans = (_span_text(each, evidence, teller) for each in _spans_in(value.of))
            story = teller.story(value, most(value.shown, MOST_TOLD), value.shown)
            text = "; ".join(dict.fromkeys(filter(None, spans))) or story
            parts.append(f"It rests on this: {text}." if text else "")
    return " ".join(dict.fromkeys(filter(None, parts)))


def _is_of_time(value: Value) -> bool:
    if isinstance(value, Amount):
        return dimension_of(value.amount.unit) == "time"
    return bool(getattr(value, "times_s", ()))


def _spans_in(expression: Expression) -> Iterator[Expression]:
    """Yield the events and spans of an expression, each with the views and spans around it."""
    if expression.word in AROUND:
        *outer, inner = expression.arguments
        yield from (of(expression.word, *outer, each) for each in _spans_in(inner))
    elif expression.value is None and type_of(expression) in ("event", "span"):
        yield expression
    else:
        for each in expression.arguments:
            if isinstance(each, Expression):
                yield from _spans_in(each)


def _span_text(span: Expression, evidence: Evidence, teller: Teller) -> str:
    """Return "the first turn, from 1.2 to 3.4 s"; "" where that is not known."""
    ends = (_placed_end(span, end) for end in ("begin", "end"))
    values = answers(Program(tuple(ends)), (evidence,), teller.frame)
    begin, end = map(_moment, values)
    if begin is None or end is None:
        return ""
    return f"{phrase(head_of(span))}, {teller.span((begin, end))}"


def _moment(value: Value) -> float | None:
    """Return a time; of a contact that begins or ends outside, from or up to when it is seen."""
    if isinstance(value, Times):
        return value.times_s[0] if value.times_s else None
    return value.at_s if isinstance(value, Unknown) else None


def _placed_end(span: Expression, end: str) -> Expression:
    if span.word not in AROUND:
        return of(end, span)
    *outer, inner = span.arguments
    return of(span.word, *outer, _placed_end(inner, end))


def own_view(slots: Mapping[str, Mapping[str, float]], sentence: str, *, is_same: bool) -> str:
    """Return what the language model itself makes of a clip, as one sentence.

    Args:
        slots: Of each slot its words' probabilities.
        sentence: Its own; it is quoted where it is whole.
        is_same: Whether that is the answer.
    """
    likeliest = {slot: max(shares, key=shares.__getitem__) for slot, shares in slots.items()}
    words = (f"{slot} {word} ({slots[slot][word]:.0%})" for slot, word in likeliest.items())
    slots_text = ", ".join(words)
    is_whole = sentence and MISSING not in sentence
    own = "; it says the same" if is_same else f"; it says {sentence!r}" if is_whole else ""
    return f"The language model itself: {slots_text}{own}."


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}."


def _sums(pattern: Pattern, motion: Motion | None, where: str) -> str:
    """Return what adds up and what cancels for the claimed motion; "" where nothing does.

    `where` is told after the way; "" leaves that out.
    """
    strength = None if motion is None else pattern.along(motion)
    if strength is None:
        return ""
    if motion in (Motion.CLOCKWISE, Motion.COUNTERCLOCKWISE):
        turn = Motion.CLOCKWISE if pattern.turn > 0 else Motion.COUNTERCLOCKWISE
        text = f"The common shift cancels in the differences of the halves, which add up {turn}"
    elif motion in (Motion.PRESS, Motion.RELEASE):
        way = "outwards" if pattern.apart > 0 else "inwards"
        text = f"The common shift cancels in the differences of the halves, which add up {way}"
    else:
        text = "What the halves do against each other cancels in the mean, which goes "
        text += _way((pattern.slide_x, pattern.slide_y), 0.0)
    text += f" {where}" if where else ""
    if strength < 0:
        text += "; this speaks against the conclusion, which rests on the whole token"
    return f"{text}."


def _shift(regions: Regions, name: str) -> tuple[float, float]:
    return regions[name]["shear_change_x"], regions[name]["shear_change_y"]


def _way(shift: tuple[float, float], greatest: float) -> str:
    """Return the way of the greater component; "" if it is faint beside `greatest`."""
    x, y = shift
    if max(abs(x), abs(y)) <= FAINT * greatest:
        return ""
    if abs(x) >= abs(y):
        return "right" if x > 0 else "left"
    return "down" if y > 0 else "up"


def _heavier(regions: Regions, first: str, second: str) -> str:
    one, other = (regions[half]["contact_mass"] for half in (first, second))
    if one > LOPSIDED * other:
        return first
    return second if other > LOPSIDED * one else ""
