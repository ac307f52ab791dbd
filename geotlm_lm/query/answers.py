"""What each thing that is asked comes to: arrays over the worlds made into one value.

A value is what holds in most worlds; its probability is the share of worlds in which all of it is
so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.edit import opposite
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.query import program as p
from geotlm_lm.query import (
    spans,  # noqa: F401  (adds its primitives)
    truths,  # noqa: F401
)
from geotlm_lm.query.contact_ends import require_seen, seen_times
from geotlm_lm.query.evaluate import (
    Context,
    Evidence,
    Floats,
    Spot,
    Trace,
    Untold,
    area_moment,
    contact_middle,
    evaluate,
    middle,
    of_clip,
    placed,
    with_facts,
)
from geotlm_lm.query.measures import comes_back, holds
from geotlm_lm.query.moving import (
    moved,
    moved_along,
    moved_on_thread,
    shown,
    shown_in,
    spread,
    story_of,
)
from geotlm_lm.query.program import ATOM_OF, WAY_ATOMS, Case, Expression, Program, of
from geotlm_lm.query.values import (
    Amount,
    Choice,
    Measure,
    Moved,
    Placed,
    Record,
    Remark,
    Shown,
    Times,
    Truth,
    Unknown,
    Value,
)
from geotlm_lm.query.worlds import COUNT
from geotlm_lm.track.events import TOGETHER_S

_BOTH = ("of-first", "of-second")
"""Words for each of two clips that are compared."""

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
        # A truth is one in every world, whichever of two it is there.
        if p.head_of(expression).word == "if" and p.type_of(expression) != "bool":
            return _either(*_placed(expression, context))
        return _TELLS[p.type_of(expression)](expression, context)
    except Untold as lacks:
        supposing = None
        if str(lacks) == "thread":
            frame = replace(context.frame, thread=context.frame.thread or "right",
                            contact_side=context.frame.contact_side or "head")  # fmt: skip
            supposing = answer(expression, replace(context, frame=frame))
        lacking = context.trace.lacking if str(lacks) == "none-such" else None
        return Unknown(of=expression, reason=str(lacks), at_s=lacks.at_s, lacking=lacking,
                       edit=context.view, supposing=supposing)  # fmt: skip


def _placed(expression: Expression, context: Context) -> tuple[Expression, Context]:
    """Return `placed`, of what leans on nothing that was asked before, in a span that there is."""
    inner, context = placed(expression, context)
    if inner.word in p.LEANING:
        raise Untold("before")
    if context.begin is not None:
        middle(context, np.broadcast_to(context.begin, (COUNT,)))
    return inner, context


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
    inner, inside = _placed(expression, context)
    amounts = tuple(_compared(inner, inside))
    components = tuple(context.trace.components)
    motion = _motion_of(components, inside)
    return Truth(
        of=expression, holds=holds, chance=chance, probability=max(chance, known - chance),
        motion=motion, amounts=amounts, times_s=tuple(_times_of(inner, inside)),
        each=_of_two(inner, inside), edit=inside.view,
        shown=shown_in(inside, components or COMPONENTS),
    )  # fmt: skip


def _compared(inner: Expression, context: Context) -> Iterator[Amount]:
    """Yield the numbers that a truth compares, but for those that were stated."""
    if inner.word in ("not", "and", "or", "xor"):
        for part in inner.arguments:
            yield from _compared(*placed(part, context))
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
    return tuple(_of_clip(inner.arguments[0], context, word) for word in _BOTH)


def _times_of(inner: Expression, context: Context) -> Iterator[float]:
    """Yield when what is asked about happens, or both of what is put in order."""
    if inner.word == "happens":
        yield from (each.begin_s for each in evaluate(inner.arguments[0], context).likely)
    elif inner.word in ("before", "after"):
        for time in inner.arguments:
            times = np.broadcast_to(evaluate(time, context), (COUNT,))
            if np.isfinite(times).mean() >= 0.5:
                yield middle(context, times)


def chance_of(expression: Expression, context: Context) -> float:
    """Return how probable it is that something holds.

    Raises:
        Untold: If that cannot be told.
    """
    return _chance(evaluate(expression, context), context)[0]


def _chance(is_so: Floats, context: Context) -> tuple[float, float]:
    """Return in which share of the worlds something is so, and in which it can be told."""
    is_so = np.broadcast_to(is_so, (COUNT,))
    known = float(np.isfinite(is_so).mean())
    if known < 0.5:
        raise Untold(context.trace.reason or "none-such")
    return float(np.nansum(is_so)) / COUNT, known


def _motion_of(components: tuple[Component, ...], context: Context) -> Moved | None:
    try:
        return moved(context, components)
    except Untold:
        return None


def _amount(expression: Expression, context: Context) -> Value:
    numbers = evaluate(expression, context)
    inner, inside = _placed(expression, context)
    components, measure = tuple(context.trace.components), p.measure_of(inner)
    until = inside
    if inside.now is not None and measure.word in _UP_TO:
        until = inside.within(inside.span[0], inside.now)
    motion = _motion_measured(measure, components, until)
    at_rest = None if motion is None else _at_rest(inner, motion, components, until)
    if at_rest is not None:
        return replace(at_rest, of=expression)
    middle(context, numbers.values)
    amount, right = spread(numbers, _moving(until, components), context)
    rounded = next((each.arguments[0] for each in expression if each.word == "round"), None)
    if rounded is not None:
        amount = replace(amount, decimals=int(rounded), is_padded=True)
    if any(each.word == "nearest" for each in expression):
        amount = replace(amount, decimals=FINEST)
    at_s = None
    most, of_what = measure.word, measure.arguments
    if most == "amount" and of_what[0] not in p.WAYS and comes_back(inside, *of_what):
        most = "peak"
    if most in ("peak", "top-speed") and inside.worlds.is_timed:
        at_s = middle(inside, evaluate(of(f"{most}-time", *of_what), inside))
    if measure.word == "area" and inside.now is not None and inside.worlds.is_timed:
        at_s = area_moment(inside)
    return Amount(
        of=expression, amount=amount, probability=right, motion=motion, at_s=at_s,
        both=tuple(_both_ways(measure, motion, until)),
        edit=inside.view, shown=shown_in(until, components or COMPONENTS),
    )  # fmt: skip


_UP_TO = ("amount", "net", "path")
"""What of a moment is how far it went until then; of a speed it is the moment's own."""


def _motion_measured(
    measure: Expression, components: tuple[Component, ...], context: Context
) -> Moved | None:
    """Return the motion that a number is of, of one along an axis that part of it."""
    if measure.word in p.GOING and measure.arguments[0] in ("x", "y"):
        return moved_along(context, *measure.arguments)
    return moved(context, components) if components else None


def _at_rest(
    inner: Expression, motion: Moved, components: tuple[Component, ...], context: Context
) -> Moved | None:
    """Return that what is measured, or measured by, does not move; None where it does."""
    measure = p.measure_of(inner)
    if motion.still_axis is not None:
        return motion
    if inner.word in ("/", "percent-of"):
        context = replace(context, trace=Trace())
        evaluate(inner.arguments[1], context)
        components = tuple(context.trace.components)
    elif measure.word not in p.GOING:
        return None
    is_still = components and (motion.rest or set(components) <= set(motion.denied))
    return motion if is_still else None


def _both_ways(measure: Expression, motion: Moved | None, context: Context) -> Iterator[Measure]:
    """Yield how far something goes the way that is asked about, and the other, if it goes both."""
    (atom,) = measure.arguments if measure.word in ("amount", "net") else ("",)
    if motion is not None and atom in p.WAYS and comes_back(context, atom):
        back = opposite(WAY_ATOMS[atom])
        for way in (atom, ATOM_OF[back]):
            numbers = evaluate(of("path", way), context)
            yield spread(numbers, np.ones(COUNT, bool), context)[0]


def _moving(context: Context, components: tuple[Component, ...]) -> NDArray[np.bool_]:
    """Return the worlds in which all that likely moves of some components does."""
    moving = np.ones(COUNT, bool)
    for component in components:
        moves = holds(context, component.value)
        moving &= moves if moves.mean() >= 0.5 else True
    return moving


def _when(expression: Expression, context: Context) -> Value:
    """Return a moment, or when an event or a span begins and ends."""
    require_seen(context, expression)
    value = evaluate(expression, context)
    ends = (value.begin, value.end) if isinstance(value, Spot) else (value,)
    ends = [np.broadcast_to(each, (COUNT,)) for each in ends]
    known = np.isfinite(ends[0])
    if known.mean() < 0.5 and isinstance(value, Spot):
        raise Untold(context.trace.reason or "none-such")
    _, inside = _placed(expression, context)
    if known.mean() < 0.5:
        return Times(of=expression, times_s=(), probability=1 - float(known.mean()),
                     edit=inside.view)  # fmt: skip
    times = tuple(float(np.median(each[known])) for each in ends)
    right = known & (np.abs(ends[0] - times[0]) <= TOGETHER_S)
    return Times(of=expression, times_s=times, probability=float(right.mean()), edit=inside.view,
                 shown=shown_in(inside, at_s=sum(times) / len(times)))  # fmt: skip


def _way(expression: Expression, context: Context) -> Value:
    inner, inside = _placed(expression, context)
    if inside.event is not None and (inner.word != "way" or inner.arguments == ("all",)):
        return _of_event(expression, inside)
    if inner.word == "story":
        value = moved(inside, ())
        return replace(value, of=expression, shown=story_of(inside))
    asked = inner.arguments[0] if inner.word == "way" else "all"
    if asked == "thread":
        story = story_of(inside, (Component.TURN,))
        return replace(moved_on_thread(inside), of=expression, shown=story)
    if asked in ("x", "y"):
        return replace(moved_along(inside, asked), of=expression)
    part = () if asked == "all" else (Component("turn" if asked == "sign" else asked),)
    value = moved(inside, part)
    story = story_of(inside, part or COMPONENTS) if inner.word in ("way", "extent") else ()
    return replace(value, of=expression, shown=story)


def _of_event(expression: Expression, context: Context) -> Value:
    """Return what an event is, or how far it goes, whatever moves beside it."""
    part, event = context.event.component, shown(context, context.event)
    value = moved(context, () if part is None else (part,))
    right = context.event.probability if part is None else value.probability
    return replace(value, of=expression, shown=(event,), probability=right)


def _label(expression: Expression, context: Context) -> Value:
    inner, inside = _placed(expression, context)
    cases = _cases(inner)
    named = {
        place: np.nan_to_num(np.broadcast_to(evaluate(case.holds, inside), (COUNT,))) > 0
        for place, case in enumerate(cases)
        if case.holds.word not in p.OTHERS
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
    motion = _motion_of(tuple(context.trace.components), inside)
    is_of_order = not chosen and {case.holds.word for case in cases} <= {"before", "after"}
    times = tuple(_times_of(cases[0].holds, inside)) if is_of_order else ()
    return Choice(of=expression, chosen=chosen, chances=chances,
                  probability=float(np.mean(right)), motion=motion, each=_of_two(inner, inside),
                  times_s=times, edit=inside.view, shown=shown_in(inside))  # fmt: skip


def _cases(inner: Expression) -> tuple[Case, ...]:
    """Return what is offered, of two clips each of them."""
    if inner.word in ("choose", "choose-not"):
        return inner.arguments[0]
    first, second = (of(clip, inner.arguments[0]) for clip in _BOTH)
    if inner.word == "which-clip":
        return Case(first), Case(second)
    sign = {"which-more": ">", "which-less": "<"}[inner.word]
    unlike, pairs = of("not", of("~", first, second)), ((first, second), (second, first))
    return tuple(Case(of("and", unlike, of(sign, *pair))) for pair in pairs)


def _record(expression: Expression, context: Context) -> Value:
    inner, inside = placed(expression, context)
    if inner.word not in ("record", "each-clip"):  # of those each part lacks what it lacks
        inner, inside = _placed(expression, context)
    events_shown: tuple[Shown, ...] = ()
    if inner.word == "record":
        fields = [(each.key, answer(each.answer, inside)) for each in inner.arguments[0]]
    elif inner.word == "each-clip":
        values = (_of_clip(inner.arguments[0], inside, word) for word in _BOTH)
        fields = [(value.clip, value) for value in values]
    else:
        events = evaluate(inner.arguments[0], inside)
        likely = events.likely
        if inner.word in ("begins", "ends"):
            times = seen_times(inside, inner, likely)
            is_likely = events.is_so.mean(axis=1, keepdims=True) >= 0.5
            right = (events.is_so == is_likely).all(axis=0).mean()
            return Times(of=expression, times_s=times, probability=float(right), edit=inside.view,
                         shown=tuple(shown(inside, each) for each in likely))  # fmt: skip
        is_mixed = any(each.word.removesuffix(p.EVENTS) in p.MIXED for each in inner.arguments[0])
        spans = (replace(inside.within(*each.ends), event=each if is_mixed else None)
                 for each in likely)  # fmt: skip
        fields = [(None, answer(inner.arguments[1], span)) for span in spans]
        events_shown = tuple(shown(inside, each) for each in likely if is_mixed)
    right = min((value.probability for _, value in fields), default=1.0)
    return Record(of=expression, fields=tuple(fields), probability=right, edit=inside.view,
                  shown=events_shown)  # fmt: skip


def _of_clip(inner: Expression, context: Context, word: str) -> Value:
    return replace(answer(inner, of_clip(context, word)), clip=word.removeprefix("of-"))


def _remark(expression: Expression, context: Context) -> Value:
    inner, inside = _placed(expression, context)
    word = inner.word
    if word in ("sure-of", "why-of"):
        value = _truth(inner.arguments[0], inside)
        return replace(value, of=expression)
    if word == "alternatives":
        return replace(_label(of("choose", _possible(inside)), inside), of=expression)
    if word in ("sure", "sure-amount", "why"):
        return replace(moved(inside, ()), of=expression)
    if word == "place":
        across, down = contact_middle(inside)
        return Placed(of=expression, across=across, down=down, share=inside.evidence.area.share,
                      edit=inside.view)  # fmt: skip
    topic = inner.arguments[0] if inner.arguments else None
    frame = inside.frame
    if topic == "world" and (frame.turn_deg or frame.image_mirrored):  # the mounting is stated
        return replace(moved(inside, ()), of=of("way", "all"))
    return Remark(of=expression, kind=word, topic=topic, recording=inside.evidence.recording,
                  edit=inside.view)  # fmt: skip


def _possible(context: Context) -> tuple[Case, ...]:
    """Return every way and rest that may be told."""
    is_known = context.worlds.belief.is_contact_known
    words = (*p.WAYS[:6], *(("in", "out", "still", "none") if is_known else ()))
    return tuple(Case(of(word)) for word in words)


_TELLS: dict[str, Callable[[Expression, Context], Value]] = {
    "bool": _truth,
    "number": _amount,
    "time": _when,
    "event": _when,
    "way": _way,
    "label": _label,
    "record": _record,
    "talk": _remark,
}
