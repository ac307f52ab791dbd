"""Tell how far or how fast it went, and judge an amount that a question claims."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from geotlm_lm.answering.abstention import (
    LEAST_SURE,
    neutral_answer,
    tentative_text,
    too_little_contact,
)
from geotlm_lm.answering.amounts import NAMES, Amount
from geotlm_lm.answering.answer import Answer
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.measured_motion import AXES, MeasuredMotion, felt_of, measured, travel
from geotlm_lm.answering.model_query import Heard
from geotlm_lm.answering.track_wording import there_and_back, times_of_component
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.amount_questions import asks_depth
from geotlm_lm.conversation.axis_claims import asks_components, axes_named
from geotlm_lm.conversation.felt import Claim, Felt, claim_of, subjects_of
from geotlm_lm.conversation.motion_answers import asked_components
from geotlm_lm.conversation.motion_claims import claimed_motions
from geotlm_lm.conversation.requested_units import asks_per_frame, requested_unit
from geotlm_lm.conversation.stated_amounts import Stated, denies_amount, without_amount
from geotlm_lm.conversation.telling import Told, cannot_be_seen, tell
from geotlm_lm.conversation.text_normalisation import normalised_text
from geotlm_lm.conversation.wording import capitalised, decapitalised, direction_clause
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import SLIDES, Motion, MotionClass, motion_class
from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE
from geotlm_lm.core.twist import WAYS, Component

AMOUNT_KINDS = ("magnitude", "rate")
"""Kinds of amounts."""

PIXELS_NOTE = (
    "Pixels of the recording's {}x{} frames: nothing tells how large one is on the gel; say for "
    "example '0.06 mm per pixel'."
)
NO_LENGTH = " In millimetres only if you tell me the size of a pixel."

_LENGTH = re.compile(
    r"\b(?:mm|cm|um|millimet(?:er|re)s?|centimet(?:er|re)s?|micromet(?:er|re)s?|microns?|inch(?:es)?)\b",
    re.IGNORECASE,
)
"""Asks for a length on the gel."""

NO_TIME = "I cannot tell the speed: it takes 3 frames and a frame rate; give it by fps."

_CLASS = {Component.TURN: MotionClass.ROTATION, Component.SLIDE: MotionClass.SLIDE}
_CLASS |= {Component.PRESS: MotionClass.PRESS}
_DISTANCES = (Component.TURN, Component.SLIDE)
"""What goes a distance in the image; how deep a press goes is told where that is asked."""

_UNIT_OF = {"deg": Component.TURN, "px": Component.SLIDE, "mm": Component.SLIDE}
_DENIALS = {True: "Yes, that is so: ", False: "No, that is not so: "}
"""Before the amount, where a question denies one: a bare "no" could be read either way."""


def told_amount(encoded: Encoded, component: Component, frame: FrameSpec) -> Amount | None:
    """Return how far a component goes as it is told; None where the picture does not tell."""
    if not encoded.belief.readable[component]:
        return None
    return measured(encoded, component, frame).amount()


def answer_amount(
    bundle: Bundle,
    encoded: Encoded,
    question: str,
    kind: str,
    frame: FrameSpec,
    heard: Heard | None = None,
) -> Answer:
    """Answer how far it went, or how fast: of the component asked about, else of all that count.

    Withheld where next to nothing touches, where a speed has no time, where the picture does not
    tell, and where it may as well not move at all; the number is told however unsure it is, with
    its span.
    """
    timing = {} if heard is None else heard.timing_ms
    if encoded.contact_share < bundle.calibration.contact_threshold:
        what = "say how fast" if kind == "rate" else "say how far"
        text = too_little_contact(what, encoded.contact_share)
        return neutral_answer(encoded, text, kind, frame, timing)
    if kind == "rate" and not encoded.seconds:
        return neutral_answer(encoded, NO_TIME, kind, frame, timing)
    felt = felt_of(encoded, frame).seen(frame.tell)
    asked = _asked(question)
    going = [one for one in felt.components if one in (asked or _DISTANCES)]
    answer = neutral_answer(encoded, "", kind, frame, timing)
    answer = replace(
        answer, options=_options(felt), motion=MeasuredMotion.of(encoded, frame), abstained=False
    )
    if not going:
        return _no_amount(bundle, answer, felt, asked, heard)
    if not encoded.belief.readable[going[0]]:
        return replace(answer, text=cannot_be_seen(going[0]), abstained=True)
    return _told(encoded, question, answer, felt, going, kind)


def _asked(question: str) -> tuple[Component, ...]:
    """Return the component whose amount a question asks for; none where it asks for any."""
    if asks_depth(question):
        return (Component.PRESS,)
    if axes_named(question.lower()) or asks_components(normalised_text(question)):
        return (Component.SLIDE,)
    return asked_components(question)


def _options(felt: Felt) -> dict[str, float]:
    words = felt.words
    shares = {kind.value: felt.counts(one) for one, kind in _CLASS.items()}
    return shares | {one.value: words[one.value] for one in (Motion.STILL, Motion.NONE)}


def _no_amount(
    bundle: Bundle, answer: Answer, felt: Felt, asked: Sequence[Component], heard: Heard | None
) -> Answer:
    """Return that there is no such amount, and what there is instead."""
    told = tell(felt, answer.frame, asked)
    answer = replace(answer, direction=told.direction)
    what = "No distance" if answer.kind == "magnitude" else "No speed to tell"
    text = f"{capitalised(told.text)}." if asked else f"{what}: {told.text}."
    if not asked and heard is not None:
        parse, options = bundle.grammar.parse, bundle.grammar.options_for(answer.kind)
        own = heard.written([one for one in options if parse(one).direction == told.direction])
        stages = answer.timing_ms | heard.timing_ms | {"total": 0.0}
        answer = replace(answer, timing_ms=stages | {"total": sum(stages.values())})
        if own is not None:
            text, answer = own, replace(answer, told_by="rule" if heard.is_by_rule else "model")
    if told.confidence < LEAST_SURE:
        text = tentative_text(text, told.confidence)
        return replace(answer, text=text, abstained=True, direction=None)
    decided = motion_class(told.direction).value if asked else told.direction.value
    return replace(answer, text=text, confidence=told.confidence, decided=decided)


def _told(
    encoded: Encoded,
    question: str,
    answer: Answer,
    felt: Felt,
    going: Sequence[Component],
    kind: str,
) -> Answer:
    """Return the amounts of the components that go, the larger first."""
    frame, parts = answer.frame, []
    axis, before = _along_axis(encoded, question, felt, answer)
    for one in going:
        if not encoded.belief.readable[one]:
            continue
        whole = measured(encoded, one, frame, axis if one is Component.SLIDE else None).amount()
        amount = whole.per_second(encoded.seconds) if kind == "rate" else whole
        parts.append((one, whole, amount))
    _, whole, amount = parts[0]
    sentences = [one.sentence(times_of_component(encoded, part)) for part, _, one in parts]
    if kind == "magnitude":
        sentences += [way for part, *_ in parts for way in there_and_back(encoded, part, frame)]
    text = before + " ".join(sentences) + _in_other_units(encoded, question, amount)
    if felt.is_barely(going[0]):
        text = f"Barely: {decapitalised(text)}"
    notes = answer.notes
    if any(one.unit == "px" for _, one, _ in parts):
        rows, columns = encoded.clip.frames.shape[1:3]
        notes = (*notes, PIXELS_NOTE.format(columns, rows))
        text += NO_LENGTH if _LENGTH.search(question) else ""
    sure = min(felt.counts(one) * told.probability for one, _, told in parts)
    return replace(
        answer, text=text, notes=notes, confidence=sure, decided=whole.word, amount=amount
    )


def _along_axis(
    encoded: Encoded, question: str, felt: Felt, answer: Answer
) -> tuple[int | None, str]:
    """Return the axis of the image that alone is asked about, and what is said of the slide.

    An axis is named in the frame's words, and measured in the recorded image.
    """
    frame = answer.frame
    if Component.SLIDE not in felt.components:
        return None, ""
    way = felt.way(Component.SLIDE)
    if asks_components(normalised_text(question)):
        x, y = _in_frame(encoded, frame)
        unit = measured(encoded, Component.SLIDE, frame).unit
        parts = f"{x:+.3g} in x and {y:+.3g} in y, x to the right and y down, in {NAMES[unit][1]}"
        return None, f"{capitalised(direction_clause(way, frame))}. About {parts}. "
    axes = [one for one in axes_named(question.lower()) if one <= set(SLIDES)]
    if len(axes) != 1:
        return None, ""
    return AXES[frame.in_the_image(sorted(axes[0])[0])], ""


def _in_frame(encoded: Encoded, frame: FrameSpec) -> tuple[float, float]:
    """Return the travel right and down as a frame names these ways."""
    found = {Motion.RIGHT: 0.0, Motion.DOWN: 0.0}
    for motion, part in zip((Motion.RIGHT, Motion.DOWN), travel(encoded, frame), strict=True):
        told = frame.tell(motion)
        sign = 1.0 if told in found else -1.0
        axis = Motion.RIGHT if told in (Motion.LEFT, Motion.RIGHT) else Motion.DOWN
        found[axis] = sign * float(part) + 0.0
    return found[Motion.RIGHT], found[Motion.DOWN]


def _in_other_units(encoded: Encoded, question: str, amount: Amount) -> str:
    """Return the amount in the unit that the question names, if it is told in another one."""
    numbers = encoded.clip.frame_numbers
    steps = max(numbers) - min(numbers)
    if asks_per_frame(question) and steps:
        unit, *rate = amount.unit.split("/")
        together = encoded.seconds if rate else 1.0
        return f" {amount.also(together / steps, f'{NAMES[unit][1]} per frame on average')}"
    asked = requested_unit(question, amount.unit)
    return "" if asked is None else f" {amount.also(asked[1], asked[0])}"


def judge_amount_claim(
    bundle: Bundle, encoded: Encoded, question: str, claim: Stated, frame: FrameSpec
) -> Answer:
    """Judge an amount or speed that is claimed: "did it turn 45 degrees?" -> yes or no.

    The way it goes is judged first, where the question claims one: what slid left has not turned by
    any number of degrees. An amount counts as the one claimed within the tolerance of an answer.

    Args:
        bundle: The model.
        encoded: The clip.
        question: What was asked.
        claim: The amount it claims.
        frame: In which to tell.
    """
    is_denied, unit = denies_amount(question), claim.unit.removesuffix("/s")
    component = _UNIT_OF[unit]
    if unit == "px":
        frame = replace(frame, mm_per_px=None)  # judged in the unit it is claimed in
    kind = "rate" if claim.is_speed else "magnitude"
    named = claimed_motions(without_amount(question))
    if unit == "mm" and named and subjects_of(named) == {Component.PRESS}:
        component = Component.PRESS
    felt = felt_of(encoded, frame).seen(frame.tell)
    words = {Component.TURN: "turn", Component.SLIDE: "slide", Component.PRESS: "press in"}
    answer = answer_amount(bundle, encoded, f"How far did it {words[component]}?", kind, frame)
    if answer.abstained:
        return answer
    told = tell(felt, frame, {component})
    if named is not None and not claim_of(named)(felt.state) and not is_denied:
        return _judged(answer, claim_of(named), felt, tell(felt, frame, subjects_of(named)), False)
    if answer.amount is None:
        goes = claim_of(frozenset(WAYS[component]))
        return _judged(answer, goes, felt, told, is_denied)
    if unit == "mm" and answer.amount.unit.startswith("px"):
        text = f"I cannot judge millimetres: {decapitalised(answer.text)}{NO_LENGTH}"
        return replace(answer, text=text, abstained=True, confidence=0.0, decided=None)
    share = felt.counts(component) * _share(encoded, claim, component, frame)
    share = 1.0 - share if is_denied else share
    is_so = share >= 0.5
    verdict = _DENIALS[is_so] if is_denied else ("Yes, " if is_so else "No, ")
    return replace(
        answer,
        text=f"{verdict}{decapitalised(answer.text)}",
        confidence=share if is_so else 1.0 - share,
        options={"yes": share, "no": 1.0 - share},
        decided="yes" if is_so else "no",
    )


def _judged(answer: Answer, claim: Claim, felt: Felt, told: Told, is_denied: bool) -> Answer:
    """Return that what goes so far does not go at all."""
    share = felt.probability(claim)
    options = {"yes": share, "no": 1.0 - share}
    if is_denied:
        options = {"yes": 1.0 - share, "no": share}
    word = "yes" if is_denied else "no"
    text = f"{_DENIALS[True] if is_denied else 'No, '}{told.text}."
    sure = min(told.confidence, options[word])
    return replace(answer, text=text, confidence=sure, options=options, decided=word, amount=None)


def _share(encoded: Encoded, claim: Stated, component: Component, frame: FrameSpec) -> float:
    """Return the probability that the amount is as claimed, given that the component counts."""
    measure = measured(encoded, component, frame)
    seconds = encoded.seconds if claim.is_speed else 1.0
    least = measure.tolerance / seconds
    tolerances = [max(least, RELATIVE_TOLERANCE * end) for end in claim.ends]
    places = [(place + 0.5) / _PLACES for place in range(_PLACES)]
    amounts = [max(measure.bell.inv_cdf(place), 0.0) / seconds for place in places]
    return sum(claim.holds(amount, *tolerances) for amount in amounts) / _PLACES


_PLACES = 200
"""Equally probable amounts that stand for a bell."""
