"""What each thing that is asked comes to: arrays over the worlds made into one value.

Told is what holds in most worlds; its probability is the share of worlds in which all of it does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.edit import EDIT_WORDS, opposite
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import SLIDES, Motion
from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE
from geotlm_lm.core.twist import BARELY_MM, BARELY_PX, COMPONENTS, WAYS, Component
from geotlm_lm.motion.belief import PX_PER_MM, SPAN_DEVIATIONS
from geotlm_lm.query import program as p
from geotlm_lm.query import spans  # noqa: F401  (adds its primitives)
from geotlm_lm.query.amounts import Measure, measure
from geotlm_lm.query.evaluate import (
    MOVERS,
    Context,
    Evidence,
    Floats,
    Numbers,
    Trace,
    Untold,
    evaluate,
    middle,
    of_clip,
)
from geotlm_lm.query.facts import with_facts
from geotlm_lm.query.measures import measured, net
from geotlm_lm.query.program import Case, Expression, Program, of
from geotlm_lm.query.truths import ASLANT, trait
from geotlm_lm.query.values import (
    Amount,
    Choice,
    Moved,
    Movement,
    Record,
    Remark,
    Shown,
    Times,
    Truth,
    Unknown,
    Value,
)
from geotlm_lm.query.worlds import COUNT, Happening, way_of

LONGER = 1.25
"""How many times as long as the net way the whole one is where that is told as well."""

_NAMES = {
    "cw": Motion.CLOCKWISE, "ccw": Motion.COUNTERCLOCKWISE, "left": Motion.LEFT,
    "right": Motion.RIGHT, "up": Motion.UP, "down": Motion.DOWN, "in": Motion.PRESS,
    "out": Motion.RELEASE,
}  # fmt: skip
_WORDS = {way: word for word, way in _NAMES.items()}


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
        return Unknown(of=expression, reason=str(lacks), edit=context.view)


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
    return expression, context


def _either(expression: Expression, context: Context) -> Value:
    """Return the one of two answers that a condition likely calls for."""
    condition, *branches = expression.arguments
    chance, known = _chance(evaluate(condition, context), context)
    holds = chance >= known / 2
    found = answer(branches[not holds], context)
    return replace(found, probability=found.probability * (chance if holds else known - chance))


# Truths


def _truth(expression: Expression, context: Context) -> Value:
    chance, known = _chance(evaluate(expression, context), context)
    holds = chance >= known / 2
    inner, placed = _placed(expression, context)
    amounts = tuple(
        amount.amount
        for each in inner
        if each.word in ("amount", "path", "peak", "speed")
        and isinstance(amount := answer(each, placed), Amount)
    )
    motion = _motion_of(tuple(context.trace.components), placed)
    return Truth(
        of=expression, holds=holds, chance=chance, probability=max(chance, known - chance),
        motion=motion, amounts=amounts, edit=placed.view, shown=_shown(placed),
    )  # fmt: skip


def _chance(found: Floats, context: Context) -> tuple[float, float]:
    """Return in which share of the worlds something is so, and in which it can be told."""
    found = np.broadcast_to(found, (COUNT,))
    known = float(np.isfinite(found).mean())
    if known < 0.5:
        raise Untold(context.trace.reason or "none-such")
    return float(np.nansum(found)) / COUNT, known


def _motion_of(components: tuple[Component, ...], context: Context) -> Moved | None:
    try:
        return moved(context, components)
    except Untold:
        return None


# Numbers and times


def _amount(expression: Expression, context: Context) -> Value:
    found = evaluate(expression, context)
    middle(context, found.values)
    inner, placed = _placed(expression, context)
    components = tuple(context.trace.components)
    motion = moved(placed, components) if components else None
    if motion is not None and _is_way(inner) and set(components) <= _unmoved(motion, components):
        return replace(motion, of=expression)
    amount, right = _spread(found, _moving(placed, components), context)
    rounded = next((each.arguments[0] for each in expression if each.word == "round"), None)
    if rounded is not None:
        amount = replace(amount, decimals=int(rounded))
    at_s = None
    if inner.word in ("peak", "top-speed") and placed.worlds.is_timed:
        at_s = middle(placed, evaluate(of(f"{inner.word}-time", *inner.arguments), placed))
    return Amount(
        of=expression, amount=amount, probability=right, motion=motion, at_s=at_s,
        edit=placed.view, shown=_shown(placed),
    )  # fmt: skip


def _unmoved(motion: Moved, components: tuple[Component, ...]) -> set[Component]:
    return set(components) if motion.rest else set(motion.denied)


def _is_way(inner: Expression) -> bool:
    """Tell whether what is asked for is how far something goes, and no number made of it."""
    while inner.word in ("unit", "per", "round", "abs"):
        inner = inner.arguments[-1]
    return inner.word in ("amount", "path", "peak", "speed", "top-speed")


def _moving(context: Context, components: tuple[Component, ...]) -> NDArray[np.bool_]:
    """Return the worlds in which all that likely moves of some components does."""
    found = np.ones(COUNT, bool)
    for component in components:
        moves = np.broadcast_to(trait(context, component.value), (COUNT,)) > 0
        found &= moves if moves.mean() >= 0.5 else True
    return found


def _spread(numbers: Numbers, is_so: NDArray[np.bool_], context: Context) -> tuple[Measure, float]:
    """Return a number as it is told, and in which share of the worlds that is right."""
    values = np.broadcast_to(numbers.values, (COUNT,))
    known = is_so & np.isfinite(values)
    if known.mean() < 0.5:
        raise Untold(context.trace.reason or "none-such")
    low, middle, high = np.quantile(values[known], (0.05, 0.5, 0.95))
    if not numbers.unit and numbers.tolerance == 0:  # a count: the likeliest one
        counts, often = np.unique(values[known], return_counts=True)
        middle = counts[often.argmax()]
    deviation = float(high - low) / (2 * SPAN_DEVIATIONS)
    told = Measure(numbers.atom or "", float(middle), deviation, numbers.unit, numbers.tolerance)
    far = np.maximum(numbers.tolerance, RELATIVE_TOLERANCE * np.abs(values)) * bool(numbers.unit)
    far = np.where(numbers.unit == "" and numbers.tolerance > 0, numbers.tolerance, far)
    right = known & (np.abs(values - told.value) <= far + 1e-9)
    return told, float(right.mean())


def _times(expression: Expression, context: Context) -> Value:
    found = np.broadcast_to(evaluate(expression, context), (COUNT,))
    known = np.isfinite(found)
    _, placed = _placed(expression, context)
    if known.mean() < 0.5:
        return Times(of=expression, times_s=(), probability=1 - float(known.mean()),
                     edit=placed.view)  # fmt: skip
    at = float(np.median(found[known]))
    near = known & (np.abs(found - at) <= 0.2)
    return Times(of=expression, times_s=(at,), probability=float(near.mean()), edit=placed.view,
                 shown=_shown(placed, at))  # fmt: skip


def _event(expression: Expression, context: Context) -> Value:
    spot = evaluate(expression, context)
    begin, end = (np.broadcast_to(each, (COUNT,)) for each in (spot.begin, spot.end))
    known = np.isfinite(begin)
    if known.mean() < 0.5:
        raise Untold(context.trace.reason or "none-such")
    ends = tuple(float(np.median(each[known])) for each in (begin, end))
    right = known & (np.abs(begin - ends[0]) <= 0.2)
    _, placed = _placed(expression, context)
    return Times(of=expression, times_s=ends, probability=float(right.mean()), edit=placed.view,
                 shown=_shown(placed, sum(ends) / 2))  # fmt: skip


# What moves


def _way(expression: Expression, context: Context) -> Value:
    inner, placed = _placed(expression, context)
    if inner.word == "story":
        found = moved(placed, ())
        return replace(found, of=expression, shown=_story(placed))
    asked = inner.arguments[0] if inner.word == "way" else "all"
    if asked == "thread":
        return replace(_thread(placed), of=expression)
    if asked in ("x", "y"):
        return replace(_along(placed, asked), of=expression)
    part = {"all": (), "sign": (Component.TURN,)}.get(asked)
    found = moved(placed, (Component(asked),) if part is None else part)
    shown = _story(placed) if asked == "all" and inner.word == "way" else ()
    return replace(found, of=expression, shown=shown)


def moved(context: Context, asked: tuple[Component, ...]) -> Moved:
    """Return what moves of what is asked, what of it does not, and what is so instead.

    Where nothing is asked for by name, what moves barely is left out beside what does more.
    """
    belief = context.worlds.belief
    touching = np.ones(COUNT)
    if belief.is_contact_known:
        touching = np.broadcast_to(trait(context, "touch"), (COUNT,))
    else:
        asked = tuple(each for each in asked if each is not Component.PRESS)
    edit = context.view
    if touching.mean() < 0.5:
        return Moved(of=of("way", "all"), rest=Motion.NONE, denied=asked, edit=edit,
                     probability=1 - float(touching.mean()))  # fmt: skip
    found = {each: _movement(context, each) for each in COMPONENTS}
    moving = {each: part for each, part in found.items() if part is not None}
    main = [each for each, (move, _) in moving.items() if not move.barely] or list(moving)
    named = [each for each in moving if each in asked] or main
    named.sort(key=lambda each: -_path_px(context, each))
    denied = tuple(each for each in asked if each not in moving)
    right = np.ones(COUNT, bool)
    for each in denied:
        right &= np.broadcast_to(trait(context, each.value), (COUNT,)) == 0
    limits = _limits(context, denied, is_at_rest=not named)
    unmoved = {"denied": denied, "limits": limits, "edit": edit, "of": of("way", "all")}
    if not named:
        rest = float(np.broadcast_to(trait(context, "still"), (COUNT,)).mean())
        return Moved(rest=Motion.STILL, probability=rest, **unmoved)
    for each in named:
        right &= moving[each][1]
    movements = tuple(moving[each][0] for each in named)
    return Moved(movements=movements, probability=float(right.mean()), **unmoved)


def _movement(context: Context, component: Component) -> tuple[Movement, NDArray[np.bool_]] | None:
    """Return a component as it is told and the worlds in which it is so; None where it rests."""
    belief = context.worlds.belief
    if component is Component.PRESS and not belief.is_contact_known:
        return None
    moves = np.broadcast_to(trait(context, component.value), (COUNT,)) > 0
    if moves.mean() < 0.5:
        return None
    twist = np.broadcast_to(net(context, component)[0], (COUNT, 4))
    mean = twist[moves].mean(axis=0)
    along = {way: float(mean @ _axis(way)) for way in WAYS[component]}
    way = max(along, key=along.__getitem__)
    aslant = _aslant(along, way) if component is Component.SLIDE else None
    goes = [np.broadcast_to(trait(context, _WORDS[each]), (COUNT,)) > 0
            for each in (way, aslant) if each is not None]  # fmt: skip
    right = moves & np.any(goes, axis=0)
    path = float(np.median(_paths(context, component, twist)[moves]))
    barely = path < (BARELY_MM if component is Component.PRESS else BARELY_PX)
    amount = whole = None
    if belief.readable.get(component, True):
        amount, _ = _spread(measured(context, component.value, twist), moves, context)
        there = measured(context, component.value, net(context, component)[1])
        back_and_forth, _ = _spread(there, moves, context)
        is_longer = back_and_forth.mean >= LONGER * amount.mean and context.worlds.is_timed
        whole = back_and_forth if is_longer and component is not Component.PRESS else None
    return Movement(way, aslant, amount, float(right.mean()), barely,
                    _ends(context, component), whole), right  # fmt: skip


def _axis(way: Motion) -> Floats:
    signs = {Motion.CLOCKWISE: (0, 1), Motion.COUNTERCLOCKWISE: (0, -1), Motion.RIGHT: (1, 1),
             Motion.LEFT: (1, -1), Motion.DOWN: (2, 1), Motion.UP: (2, -1),
             Motion.PRESS: (3, 1), Motion.RELEASE: (3, -1)}  # fmt: skip
    place, sign = signs[way]
    axis = np.zeros(4)
    axis[place] = sign
    return axis


def _aslant(along: dict[Motion, float], way: Motion) -> Motion | None:
    others = [each for each in SLIDES if each not in (way, opposite(way))]
    other = max(others, key=along.__getitem__)
    return other if along[way] > 0 and ASLANT * along[way] <= along[other] else None


def _paths(context: Context, component: Component, twist: Floats) -> Floats:
    radius = max(context.worlds.belief.radius_px, 1.0)
    if component is Component.TURN:
        return np.abs(np.radians(twist[:, 0])) * radius
    return (
        np.hypot(twist[:, 1], twist[:, 2]) if component is Component.SLIDE else np.abs(twist[:, 3])
    )


def _path_px(context: Context, component: Component) -> float:
    """Return how far a component moves the imprint, by which what is larger comes first."""
    twist = np.broadcast_to(net(context, component)[1], (COUNT, 4))
    return float(np.median(_paths(context, component, twist))) * (
        PX_PER_MM if component is Component.PRESS else 1.0
    )


def _ends(context: Context, component: Component) -> tuple[float, float] | None:
    """Return from when to when a component moves in the span."""
    if not context.worlds.is_timed:
        return None
    begin, end = (middle(context, each) for each in context.span)
    inside = [
        (max(each.begin_s, begin), min(each.end_s, end))
        for each in context.worlds.motions(component)
        if each.probability >= 0.5 and each.begin_s < end and each.end_s > begin
    ]
    return (min(a for a, _ in inside), max(b for _, b in inside)) if inside else None


def _limits(context: Context, denied: tuple[Component, ...], *, is_at_rest: bool):
    """Return how far what does not move would have to go to be seen."""
    belief, recording = context.worlds.belief, context.evidence.recording
    if not belief.limits:
        return ()
    # What the picture does not tell, an edge's travel along itself, has no limit.
    seen, slide = belief.at_limit, Component.SLIDE
    both = [part for part in (slide, Component.TURN) if belief.readable.get(part, True)]
    parts = [part for part in denied if belief.readable.get(part, True)]
    if is_at_rest and slide not in parts and slide in both:
        # Neither turns nor slides: the larger path stands for both.
        path = max(belief.limits[part] for part in both)
        seen = replace(seen, mean=replace(seen.mean, right_px=path))
        parts.append(slide)
    found = []
    for part in parts:
        is_scaled = part is slide and context.frame.mm_per_px is not None
        units = ("px", "mm") if is_scaled else (None,)
        found.append((part, tuple(
            measure(part.value, seen, context.frame, recording, unit) for unit in units
        )))  # fmt: skip
    return tuple(found)


def _along(context: Context, axis: str) -> Moved:
    """Return what is told of a slide's part along one axis of the image."""
    found = moved(context, (Component.SLIDE,))
    if found.rest or found.denied:
        return found
    moving = np.broadcast_to(trait(context, axis), (COUNT,)) > 0
    if moving.mean() < 0.5:
        right = min(found.probability, 1 - float(moving.mean()))
        return replace(found, still_axis=axis, probability=right)
    twist = np.broadcast_to(net(context, Component.SLIDE)[0], (COUNT, 4))
    ways = {"x": (Motion.LEFT, Motion.RIGHT), "y": (Motion.UP, Motion.DOWN)}[axis]
    goes = {way: (twist @ _axis(way) > 0) & moving for way in ways}
    way = max(goes, key=lambda each: goes[each].mean())
    amount, _ = _spread(measured(context, axis, twist), moving, context)
    right = float(goes[way].mean())
    move = Movement(way, None, amount, right, barely=False)
    return replace(found, movements=(move,), probability=right)


def _thread(context: Context) -> Moved:
    turn = moved(context, (Component.TURN,))
    if turn.rest or turn.denied:
        return turn  # neither tightens nor loosens
    chances = {word: float(np.mean(trait(context, word))) for word in ("tighten", "loosen")}
    word = max(chances, key=chances.__getitem__)
    return replace(turn, tightens=word == "tighten", probability=chances[word])


def _shown(context: Context, at_s: float | None = None) -> tuple[Shown, ...]:
    """Return what an answer has looked at of what likely happens; of a moment what goes on."""
    found = context.trace.happenings.values() if context.worlds.is_timed else ()
    if at_s is not None:
        found = [each for each in found if each.begin_s - 1e-9 <= at_s <= each.end_s + 1e-9]
    return tuple(shown(context, each) for each in sorted(found, key=lambda each: each.begin_s)
                 if each.probability >= 0.5)  # fmt: skip


def _story(context: Context) -> tuple[Shown, ...]:
    """Return all that likely happens in the span, by when it begins."""
    if not context.worlds.is_timed:
        return ()
    begin, end = (middle(context, each) for each in context.span)
    likely = [each for each in context.worlds.happenings if each.probability >= 0.5]
    inside = [each for each in likely if each.end_s >= begin and each.begin_s <= end]
    return tuple(shown(context, each) for each in inside)


def shown(context: Context, happening: Happening) -> Shown:
    """Return a happening as it is told."""
    is_real = happening.is_real
    mean = happening.twist[is_real].mean(axis=0) if is_real.any() else np.zeros(4)
    amount = None
    if happening.component is not None and happening.begin_s < happening.end_s:
        numbers = measured(context, happening.component.value, happening.twist)
        amount, _ = _spread(numbers, is_real, replace(context, trace=Trace(reason="none-such")))
    path = float(np.median(happening.path_px[is_real])) if is_real.any() else 0.0
    way = way_of(happening.kind, mean)
    return Shown(happening.kind, way, happening.begin_s, happening.end_s, amount, path,
                 happening.probability)  # fmt: skip


# Choices, records, remarks


def _label(expression: Expression, context: Context) -> Value:
    inner, placed = _placed(expression, context)
    if inner.word == "which-clip":
        cases = tuple(Case(of(clip, inner.arguments[0])) for clip in ("of-first", "of-second"))
    elif inner.word in ("which-more", "which-less"):
        first, second = (of(clip, inner.arguments[0]) for clip in ("of-first", "of-second"))
        sign = {"which-more": ">", "which-less": "<"}[inner.word]
        cases = Case(of(sign, first, second)), Case(of(sign, second, first))
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
        chosen = () if chances[chosen[0]] < 0.5 <= none.mean() else chosen
        right = np.all([held[place] for place in chosen], axis=0) if chosen else none
    motion = _motion_of(tuple(context.trace.components), placed)
    return Choice(of=expression, chosen=chosen, chances=chances, probability=float(np.mean(right)),
                  motion=motion, edit=placed.view, shown=_shown(placed))  # fmt: skip


def _record(expression: Expression, context: Context) -> Value:
    inner, placed = _placed(expression, context)
    if inner.word == "record":
        fields = [(each.key, answer(each.answer, placed)) for each in inner.arguments[0]]
    elif inner.word == "each-clip":
        fields = [(word.removeprefix("of-"), _of_clip(inner.arguments[0], placed, word))
                  for word in ("of-first", "of-second")]  # fmt: skip
    else:
        found = evaluate(inner.arguments[0], placed)
        is_likely = found.is_so.mean(axis=1) >= 0.5
        likely = [each for each, is_so in zip(found.happenings, is_likely, strict=True) if is_so]
        if inner.word in ("begins", "ends"):
            times = tuple(each.begin_s if inner.word == "begins" else each.end_s for each in likely)
            right = (found.is_so == is_likely[:, None]).all(axis=0).mean()
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
        found = _truth(inner.arguments[0], placed)
        return replace(found, of=expression)
    if word in ("sure", "alternatives", "why"):
        return replace(moved(placed, ()), of=expression)
    topic = inner.arguments[0] if inner.arguments else None
    return Remark(of=expression, kind=word, topic=topic, edit=placed.view)


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
