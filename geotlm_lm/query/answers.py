"""What each thing that is asked comes to: arrays over the worlds made into one value.

A value is what holds in most worlds; its probability is the share of worlds in which all of it is
so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.edit import EDIT_WORDS, opposite
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.query import program as p
from geotlm_lm.query import spans  # noqa: F401  (adds its primitives)
from geotlm_lm.query.amounts import Measure
from geotlm_lm.query.evaluate import (
    MOVERS,
    Context,
    Events,
    Evidence,
    Floats,
    Trace,
    Untold,
    evaluate,
    middle,
    of_clip,
)
from geotlm_lm.query.facts import with_facts
from geotlm_lm.query.measures import comes_back
from geotlm_lm.query.measures import placed as where_touched
from geotlm_lm.query.moving import (
    moved,
    moved_along,
    moved_on_thread,
    of_components,
    shown,
    shown_in,
    spread,
    story_of,
)
from geotlm_lm.query.program import Case, Expression, Program, of
from geotlm_lm.query.truths import trait
from geotlm_lm.query.types import ATOM_OF, WAY_ATOMS
from geotlm_lm.query.values import (
    Amount,
    Choice,
    Moved,
    Placed,
    Record,
    Remark,
    Times,
    Truth,
    Unknown,
    Value,
)
from geotlm_lm.query.worlds import COUNT, Happening
from geotlm_lm.track.events import TOGETHER_S

FINEST = 6
"""Decimals of a number that was rounded to a step of the asker's own."""


def answers(program: Program, clips: tuple[Evidence, ...], frame: FrameSpec) -> tuple[Value, ...]:
    """Return what each thing that a program asks comes to.

    Args:
        program: With its numbers and words filled in.
        clips: The recording that is asked about, behind the one before it if there is one.
        frame: What held before; the program's own facts are added.
    """
    try:
        frame = with_facts(frame, program.facts, clips[-1].recording.columns)
    except UsageError:  # no camera has such pixels
        return tuple(Unknown(of=each, reason="pixel") for each in program.answers)
    rated = tuple(
        replace(clip, recording=clip.recording.at_rate(frame.rate_hz, overrides=len(clips) == 1))
        for clip in clips
    )
    return tuple(answer(each, Context(rated, frame)) for each in program.answers)


def answer(expression: Expression, context: Context) -> Value:
    """Return what an expression comes to; `Unknown` with its reason where it cannot be told."""
    context = replace(context, trace=Trace())
    try:
        if p.head_of(expression).word == "again":  # nothing was asked before
            raise Untold("before")
        if p.head_of(expression).word == "if":
            return _either(*_placed(expression, context))
        return _TELLS[p.type_of(expression)](expression, context)
    except Untold as lacks:
        supposing = None
        if str(lacks) == "thread":
            frame = replace(context.frame, thread=context.frame.thread or "right",
                            contact_side=context.frame.contact_side or "head")  # fmt: skip
            supposing = answer(expression, replace(context, frame=frame))
        return Unknown(of=expression, reason=str(lacks), edit=context.view, supposing=supposing)


_AROUND = (*EDIT_WORDS, *MOVERS, "of-first", "of-second", "of-previous", "within", "at", "plain")


def _placed(expression: Expression, context: Context) -> tuple[Expression, Context]:
    """Return an expression without the views, clips and spans around it, and their context."""
    while expression.word in _AROUND:
        *outer, inner = expression.arguments
        if expression.word == "at":
            context.timed()
            context = replace(context, now=evaluate(outer[0], context))
        elif expression.word == "plain":
            context = context.plain()
        elif expression.word == "within":
            spot = evaluate(outer[0], context)
            context = context.within(spot.begin, spot.end)
        elif expression.word in (*EDIT_WORDS, *MOVERS):
            context = context.edited(expression.word)
        else:
            context = of_clip(context, expression.word)
        expression = inner
    if expression.word in p.LEANING:
        raise Untold("before")
    return expression, context


def _either(expression: Expression, context: Context) -> Value:
    """Return the one of two answers that a condition likely calls for."""
    condition, *branches = expression.arguments
    chance, known = _chance(evaluate(condition, context), context)
    holds = chance >= known / 2
    value = answer(branches[not holds], context)
    return replace(value, probability=value.probability * (chance if holds else known - chance))


def _truth(expression: Expression, context: Context) -> Value:
    chance, known = _chance(evaluate(expression, context), context)
    holds = chance >= known / 2
    inner, placed = _placed(expression, context)
    amounts = tuple(_compared(inner, placed))
    components = tuple(context.trace.components)
    motion = _motion_of(components, placed)
    return Truth(
        of=expression, holds=holds, chance=chance, probability=max(chance, known - chance),
        motion=motion, amounts=amounts, times_s=tuple(_times_of(inner, placed)),
        each=_of_two(inner, placed), edit=placed.view,
        shown=of_components(shown_in(placed), components or COMPONENTS),
    )  # fmt: skip


def _compared(inner: Expression, context: Context) -> Iterator[Amount]:
    """Yield the numbers that a truth compares, but for those that were stated."""
    if inner.word in ("not", "and", "or", "xor"):
        for part in inner.arguments:
            yield from _compared(*_placed(part, context))
    elif inner.word in (">", "<", "=", "~", "in-range"):
        measured_first = inner.arguments[0]
        if measured_first.value is None and isinstance(
            value := answer(measured_first, context), Amount
        ):
            yield value


def _of_two(inner: Expression, context: Context) -> tuple[Value, ...]:
    """Return what is so of each of two clips that are compared; nothing where none are."""
    if inner.word not in p.TWO_CLIPS or len(context.clips) < 2:
        return ()
    return tuple(_of_clip(inner.arguments[0], context, word) for word in ("of-first", "of-second"))


def _times_of(inner: Expression, context: Context) -> Iterator[float]:
    """Yield when what is asked about happens, or both of what is put in order."""
    if inner.word == "happens":
        for happening, is_so in _likely(evaluate(inner.arguments[0], context)):
            if is_so:
                yield happening.begin_s
    elif inner.word in ("before", "after"):
        for time in inner.arguments:
            known = np.broadcast_to(evaluate(time, context), (COUNT,))
            if np.isfinite(known).mean() >= 0.5:
                yield middle(context, known)


def _likely(events: Events) -> Iterator[tuple[Happening, bool]]:
    """Yield events and whether each likely happens."""
    return zip(events.happenings, events.is_so.mean(axis=1) >= 0.5, strict=True)


def chance_of(expression: Expression, context: Context) -> float:
    """Return how probable it is that something holds.

    Raises:
        Untold: If that cannot be told.
    """
    return _chance(evaluate(expression, context), context)[0]


def _chance(holds: Floats, context: Context) -> tuple[float, float]:
    """Return in which share of the worlds something is so, and in which it can be told."""
    holds = np.broadcast_to(holds, (COUNT,))
    known = float(np.isfinite(holds).mean())
    if known < 0.5:
        raise Untold(context.trace.reason or "none-such")
    return float(np.nansum(holds)) / COUNT, known


def _motion_of(components: tuple[Component, ...], context: Context) -> Moved | None:
    try:
        return moved(context, components)
    except Untold:
        return None


def _amount(expression: Expression, context: Context) -> Value:
    numbers = evaluate(expression, context)
    inner, placed = _placed(expression, context)
    components = tuple(context.trace.components)
    motion = moved(placed, components) if components else None
    measure = p.measure_of(inner)
    at_rest = None if motion is None else _at_rest(inner, motion, components, placed)
    if at_rest is not None:
        return replace(at_rest, of=expression)
    middle(context, numbers.values)
    amount, right = spread(numbers, _moving(placed, components), context)
    rounded = next((each.arguments[0] for each in expression if each.word == "round"), None)
    if rounded is not None:
        amount = replace(amount, decimals=int(rounded), is_padded=True)
    if any(each.word == "nearest" for each in expression):
        amount = replace(amount, decimals=FINEST)
    at_s = None
    most, of_what = measure.word, measure.arguments
    if most == "amount" and of_what[0] not in p.WAYS and comes_back(placed, *of_what):
        most = "peak"
    if most in ("peak", "top-speed") and placed.worlds.is_timed:
        at_s = middle(placed, evaluate(of(f"{most}-time", *of_what), placed))
    return Amount(
        of=expression, amount=amount, probability=right, motion=motion, at_s=at_s,
        both=tuple(_both_ways(measure, motion, placed)),
        edit=placed.view, shown=of_components(shown_in(placed), components or COMPONENTS),
    )  # fmt: skip


def _at_rest(
    inner: Expression, motion: Moved, components: tuple[Component, ...], context: Context
) -> Moved | None:
    """Return that what is measured, or measured by, does not move; None where it does."""
    measure = p.measure_of(inner)
    if measure.word in p.GOING and measure.arguments[0] in ("x", "y"):
        motion = moved_along(context, *measure.arguments)
        if motion.still_axis is not None:
            return motion
    if inner.word in ("/", "percent-of"):
        context = replace(context, trace=Trace())
        evaluate(inner.arguments[1], context)
        components = tuple(context.trace.components)
    elif measure.word not in p.GOING:
        return None
    return motion if components and set(components) <= _unmoved(motion, components) else None


def _both_ways(measure: Expression, motion: Moved | None, context: Context) -> Iterator[Measure]:
    """Yield how far something goes the way that is asked about, and the other, if it goes both."""
    (atom,) = measure.arguments if measure.word in ("amount", "net") else ("",)
    if motion is not None and atom in p.WAYS and comes_back(context, atom):
        back = opposite(WAY_ATOMS[atom])
        for way in (atom, ATOM_OF[back]):
            numbers = evaluate(of("path", way), context)
            yield spread(numbers, np.ones(COUNT, bool), context)[0]


def _unmoved(motion: Moved, components: tuple[Component, ...]) -> set[Component]:
    return set(components) if motion.rest else set(motion.denied)


def _moving(context: Context, components: tuple[Component, ...]) -> NDArray[np.bool_]:
    """Return the worlds in which all that likely moves of some components does."""
    moving = np.ones(COUNT, bool)
    for component in components:
        moves = np.broadcast_to(trait(context, component.value), (COUNT,)) > 0
        moving &= moves if moves.mean() >= 0.5 else True
    return moving


def _times(expression: Expression, context: Context) -> Value:
    times = np.broadcast_to(evaluate(expression, context), (COUNT,))
    known = np.isfinite(times)
    _, placed = _placed(expression, context)
    if known.mean() < 0.5:
        return Times(of=expression, times_s=(), probability=1 - float(known.mean()),
                     edit=placed.view)  # fmt: skip
    at = float(np.median(times[known]))
    near = known & (np.abs(times - at) <= TOGETHER_S)
    return Times(of=expression, times_s=(at,), probability=float(near.mean()), edit=placed.view,
                 shown=shown_in(placed, at))  # fmt: skip


def _event(expression: Expression, context: Context) -> Value:
    spot = evaluate(expression, context)
    begin, end = (np.broadcast_to(each, (COUNT,)) for each in (spot.begin, spot.end))
    known = np.isfinite(begin)
    if known.mean() < 0.5:
        raise Untold(context.trace.reason or "none-such")
    ends = tuple(float(np.median(each[known])) for each in (begin, end))
    right = known & (np.abs(begin - ends[0]) <= TOGETHER_S)
    _, placed = _placed(expression, context)
    return Times(of=expression, times_s=ends, probability=float(right.mean()), edit=placed.view,
                 shown=shown_in(placed, sum(ends) / 2))  # fmt: skip


def _way(expression: Expression, context: Context) -> Value:
    inner, placed = _placed(expression, context)
    if inner.word == "story":
        value = moved(placed, ())
        return replace(value, of=expression, shown=story_of(placed))
    asked = inner.arguments[0] if inner.word == "way" else "all"
    if asked == "thread":
        shown = of_components(story_of(placed), (Component.TURN,))
        return replace(moved_on_thread(placed), of=expression, shown=shown)
    if asked in ("x", "y"):
        return replace(moved_along(placed, asked), of=expression)
    part = () if asked == "all" else (Component("turn" if asked == "sign" else asked),)
    value = moved(placed, part)
    shown = story_of(placed) if inner.word in ("way", "extent") else ()
    return replace(value, of=expression, shown=of_components(shown, part or COMPONENTS))


def _label(expression: Expression, context: Context) -> Value:
    inner, placed = _placed(expression, context)
    if inner.word == "which-clip":
        cases = tuple(Case(of(clip, inner.arguments[0])) for clip in ("of-first", "of-second"))
    elif inner.word in ("which-more", "which-less"):
        first, second = (of(clip, inner.arguments[0]) for clip in ("of-first", "of-second"))
        sign = {"which-more": ">", "which-less": "<"}[inner.word]
        unlike = of("not", of("~", first, second))
        cases = tuple(
            Case(of("and", unlike, of(sign, *pair))) for pair in ((first, second), (second, first))
        )
    else:
        cases = inner.arguments[0]
    named = {
        place: np.nan_to_num(np.broadcast_to(evaluate(case.holds, placed), (COUNT,))) > 0
        for place, case in enumerate(cases)
        if case.holds.word not in ("other", "unknown")
    }
    none = ~np.any(list(named.values()), axis=0) if named else np.ones(COUNT, bool)
    held = [named.get(place, none if case.holds.word == "other" else np.zeros(COUNT, bool))
            for place, case in enumerate(cases)]  # fmt: skip
    chances = tuple(float(each.mean()) for each in held)
    order = sorted(range(len(cases)), key=lambda place: -chances[place])
    if inner.word == "choose-not":
        chosen = tuple(place for place in order if chances[place] < 0.5)
        right = np.all([~held[place] for place in chosen], axis=0) if chosen else none
    else:
        chosen = tuple(place for place in order if chances[place] >= 0.5) or tuple(order[:1])
        chosen = tuple(place for place in chosen if place in named) or chosen[:1]
        chosen = () if chances[chosen[0]] < min(none.mean(), 0.5) else chosen
        right = np.all([held[place] for place in chosen], axis=0) if chosen else none
    motion = _motion_of(tuple(context.trace.components), placed)
    return Choice(of=expression, chosen=chosen, chances=chances, probability=float(np.mean(right)),
                  motion=motion, each=_of_two(inner, placed), edit=placed.view,
                  shown=shown_in(placed))  # fmt: skip


def _record(expression: Expression, context: Context) -> Value:
    inner, placed = _placed(expression, context)
    if inner.word == "record":
        fields = [(each.key, answer(each.answer, placed)) for each in inner.arguments[0]]
    elif inner.word == "each-clip":
        fields = [(word.removeprefix("of-"), _of_clip(inner.arguments[0], placed, word))
                  for word in ("of-first", "of-second")]  # fmt: skip
    else:
        events = evaluate(inner.arguments[0], placed)
        is_likely = events.is_so.mean(axis=1) >= 0.5
        likely = [each for each, is_so in _likely(events) if is_so]
        if inner.word in ("begins", "ends"):
            times = tuple(each.begin_s if inner.word == "begins" else each.end_s for each in likely)
            right = (events.is_so == is_likely[:, None]).all(axis=0).mean()
            return Times(of=expression, times_s=times, probability=float(right), edit=placed.view,
                         shown=tuple(shown(placed, each) for each in likely))  # fmt: skip
        ends = [(np.asarray(each.begin_s), np.asarray(each.end_s)) for each in likely]
        fields = [(None, answer(inner.arguments[1], placed.within(*each))) for each in ends]
    right = min((value.probability for _, value in fields), default=1.0)
    return Record(of=expression, fields=tuple(fields), probability=right, edit=placed.view)


def _of_clip(inner: Expression, context: Context, word: str) -> Value:
    return replace(answer(inner, of_clip(context, word)), clip=word.removeprefix("of-"))


def _remark(expression: Expression, context: Context) -> Value:
    inner, placed = _placed(expression, context)
    word = inner.word
    if word in ("sure-of", "why-of"):
        value = _truth(inner.arguments[0], placed)
        return replace(value, of=expression)
    if word == "alternatives":
        return replace(_label(of("choose", _possible(placed)), placed), of=expression)
    if word in ("sure", "sure-amount", "why"):
        return replace(moved(placed, ()), of=expression)
    if word == "place":
        across, down = where_touched(placed)
        return Placed(of=expression, across=across, down=down, share=placed.evidence.area.share,
                      edit=placed.view)  # fmt: skip
    topic = inner.arguments[0] if inner.arguments else None
    frame = placed.frame
    if topic == "world" and (frame.turn_deg or frame.image_mirrored):  # the mounting is stated
        return replace(moved(placed, ()), of=of("way", "all"))
    return Remark(of=expression, kind=word, topic=topic, recording=placed.evidence.recording,
                  edit=placed.view)  # fmt: skip


def _possible(context: Context) -> tuple[Case, ...]:
    """Return every way and rest that may be told."""
    is_known = context.worlds.belief.is_contact_known
    words = (*p.WAYS[:6], *(("in", "out", "still", "none") if is_known else ()))
    return tuple(Case(of(word)) for word in words)


_TELLS: dict[str, Callable[[Expression, Context], Value]] = {
    "bool": _truth,
    "number": _amount,
    "time": _times,
    "event": _event,
    "way": _way,
    "label": _label,
    "record": _record,
    "talk": _remark,
}
