"""What moves in a span: each component as it is told, what does not, and what happens when.

A value is what holds in most worlds; its probability is the share of worlds in which all of it is
so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.edit import opposite
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import SLIDES, Motion
from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE
from geotlm_lm.core.twist import BARELY_MM, BARELY_PX, COMPONENTS, DIAGONAL, WAYS, Component, Twist
from geotlm_lm.motion.belief import PX_PER_MM, SPAN_DEVIATIONS
from geotlm_lm.query.arithmetic import SPAN
from geotlm_lm.query.evaluate import (
    Context,
    Numbers,
    Trace,
    Untold,
    middle,
)
from geotlm_lm.query.measures import going_on, holds, measured, net, path_of
from geotlm_lm.query.program import ATOM_OF, AXIS, UNITS, of
from geotlm_lm.query.values import (
    Measure,
    Moved,
    Movement,
    Shown,
    measure,
)
from geotlm_lm.query.worlds import COUNT, Happening, path_px, way_of

SURELY = 0.9
"""Share of the worlds in which it has to."""

LONGER = 1.25
"""How many times as long as the net way the whole one is where that is told as well."""


def spread(numbers: Numbers, is_so: NDArray[np.bool_], context: Context) -> tuple[Measure, float]:
    """Return a number as it is told, and in which share of the worlds that is right."""
    values = np.broadcast_to(numbers.values, (COUNT,))
    known = is_so & np.isfinite(values)
    if known.mean() < 0.5:
        raise Untold(context.trace.reason or "none-such")
    low, middle, high = np.quantile(values[known], (SPAN[0], 0.5, SPAN[1]))
    if not numbers.unit and numbers.tolerance == 0:  # a count: the likeliest one
        counts, often = np.unique(values[known], return_counts=True)
        middle = counts[often.argmax()]
    deviation = float(high - low) / (2 * SPAN_DEVIATIONS)
    amount = Measure(numbers.atom or "", float(middle), deviation, numbers.unit,
                     numbers.tolerance, is_signed=numbers.is_signed)  # fmt: skip
    far = np.maximum(numbers.tolerance, RELATIVE_TOLERANCE * np.abs(values)) * bool(numbers.unit)
    far = np.maximum(far, numbers.slack)
    far = np.where(numbers.unit == "" and numbers.tolerance > 0, numbers.tolerance, far)
    if numbers.unit in UNITS["time"]:  # as exact as frames are
        whole, finer = numbers.unit in ("frame", "ms", "us"), 2 * (numbers.unit == "min")
        decimals = context.evidence.recording.decimals + finer
        amount = replace(amount, decimals=0 if whole else decimals)
    right = known & (np.abs(values - amount.value) <= far + 1e-9)
    return amount, float(right.mean())


def moved(context: Context, asked: tuple[Component, ...]) -> Moved:
    """Return what moves of what is asked, what of it does not, and what is so instead.

    Where nothing is asked for by name, what moves barely is left out beside what does more.
    """
    belief = context.worlds.belief
    touching = np.ones(COUNT)
    if belief.is_contact_known:
        touching = holds(context, "touch")
    else:
        asked = tuple(each for each in asked if each is not Component.PRESS)
    edit, context = context.view, replace(context, has_edges=Component.PRESS in asked)
    if touching.mean() < 0.5:
        is_brief = bool(context.worlds.contacts and context.worlds.touches.mean() >= 0.5)
        return Moved(of=of("way", "all"), rest=Motion.NONE, is_brief=is_brief, denied=asked,
                     edit=edit, probability=1 - float(touching.mean()))  # fmt: skip
    parts = {each: _movement(context, each) for each in COMPONENTS}
    moving = {each: part for each, part in parts.items() if part is not None}
    main = [each for each, (move, _) in moving.items() if not move.barely] or list(moving)
    named = [each for each in moving if each in asked] or main
    named.sort(key=lambda each: -_path_px(context, each))
    denied = tuple(each for each in asked if each not in moving)
    right = np.ones(COUNT, bool)
    for each in denied:
        right &= ~holds(context, each.value)
    limits = _limits(context, denied, is_at_rest=not named)
    unmoved = {"denied": denied, "limits": limits, "edit": edit, "of": of("way", "all")}
    if not named:
        rest = float(holds(context, "still").mean())
        return Moved(rest=Motion.STILL, probability=rest, **unmoved)
    named = _sure_together(named, asked, moving, right)
    for each in named:
        right = right & moving[each][1]
    movements = tuple(moving[each][0] for each in named)
    return Moved(movements=movements, probability=float(right.mean()), **unmoved)


def _sure_together(named, asked, moving, right) -> list[Component]:
    """Return what is told: of what nobody asked for, none that makes the whole a guess."""
    while (
        len(named) > 1
        and np.all([right, *(moving[each][1] for each in named)], axis=0).mean() < 0.5
    ):
        spare = [each for each in named if each not in asked]
        if not spare:
            break
        doubtful = min(spare, key=lambda each: moving[each][0].chance)
        named = [each for each in named if each is not doubtful]
    return named


def _movement(context: Context, component: Component) -> tuple[Movement, NDArray[np.bool_]] | None:
    """Return a component as it is told and the worlds in which it is so; None where it rests."""
    belief = context.worlds.belief
    if component is Component.PRESS and not belief.is_contact_known:
        return None
    moves = holds(context, component.value)
    if moves.mean() < 0.5:
        return None
    going = net if context.now is None else going_on
    twist = np.broadcast_to(going(context, component)[0], (COUNT, 4))
    # How far it goes each way on the mean; of two ways the rarer does not cancel the other, nor is
    # it told where another is likelier than not.
    axes = {way: AXIS[ATOM_OF[way]] for way in WAYS[component]}
    along = {way: np.maximum(twist[moves] @ axis, 0).mean() for way, axis in axes.items()}
    goes = {each: holds(context, ATOM_OF[each]) for each in along}
    way = max(along, key=lambda each: (goes[each].mean() >= 0.5, along[each]))
    aslant = _aslant(goes, way) if component is Component.SLIDE else None
    right = moves & (goes[way] if aslant is None else goes[way] | goes[aslant])
    far_px = float(np.median(path_px(component, twist, belief.radius_px)[moves]))
    barely = far_px < (BARELY_MM if component is Component.PRESS else BARELY_PX)
    amount = whole = None
    if belief.readable.get(component, True):
        amount, _ = spread(measured(context, component.value, twist), moves, context)
        if context.now is None and context.worlds.is_timed and component is not Component.PRESS:
            whole = _longer_path(context, component.value, moves, amount)
    sides = twist[moves] @ np.array([axes[way], axes[aslant or way]], float).T
    is_diagonal = aslant is not None and (sides[:, 1] >= DIAGONAL * sides[:, 0]).mean() >= SURELY
    return Movement(way, aslant, amount, float(right.mean()), barely,
                    _ends(context, component), whole, bool(is_diagonal)), right  # fmt: skip


def _longer_path(
    context: Context, atom: str, moves: NDArray[np.bool_], amount: Measure
) -> Measure | None:
    """Return how far something goes there and back, if that is well above the net amount."""
    path, _ = spread(path_of(context, atom), moves, context)
    return path if path.mean >= LONGER * amount.mean else None


def _aslant(goes: dict[Motion, NDArray[np.bool_]], way: Motion) -> Motion | None:
    """Return the way across that a slide likely goes as well."""
    others = [each for each in SLIDES if each not in (way, opposite(way))]
    other = max(others, key=lambda each: goes[each].mean())
    return other if goes[other].mean() >= 0.5 else None


def _path_px(context: Context, component: Component) -> float:
    """Return how far a component moves the imprint, by which what is larger comes first."""
    twist = np.broadcast_to(net(context, component)[1], (COUNT, 4))
    far = float(np.median(path_px(component, twist, context.worlds.belief.radius_px)))
    return far * (PX_PER_MM if component is Component.PRESS else 1.0)


def _ends(context: Context, component: Component) -> tuple[float, float] | None:
    """Return from when to when a component moves in the span."""
    if not context.worlds.is_timed:
        return None
    begin, end = (middle(context, np.asarray(each)) for each in context.looked_at)
    inside = [
        (max(each.begin_s, begin), min(each.end_s, end))
        for each in context.worlds.motions(component)
        if each.probability >= 0.5 and each.begin_s < end and each.end_s > begin
    ]
    return (min(a for a, _ in inside), max(b for _, b in inside)) if inside else None


def _limits(context: Context, denied: tuple[Component, ...], *, is_at_rest: bool):
    """Return how far what does not move would have to go to be seen."""
    belief, recording = context.worlds.belief, context.evidence.recording
    if not belief.limits or context.now is not None:  # a moment is no way
        return ()
    if context.begin is not None and context.worlds.track is not None:
        belief = replace(belief, limits=_limits_within(context) or belief.limits)
    # What the picture does not tell, an edge's travel along itself, has no limit.
    seen, slide = belief.at_limit, Component.SLIDE
    both = [part for part in (slide, Component.TURN) if belief.readable.get(part, True)]
    parts = [part for part in denied if belief.readable.get(part, True)]
    if is_at_rest and slide not in parts and slide in both:
        # Neither turns nor slides: the larger path stands for both.
        path = max(belief.limits[part] for part in both)
        seen = replace(seen, mean=replace(seen.mean, right_px=path))
        parts.append(slide)
    limits = []
    for part in parts:
        is_scaled = part is slide and context.frame.mm_per_px is not None
        units = ("px", "mm") if is_scaled else (None,)
        limits.append((part, tuple(
            measure(part.value, seen, context.frame, recording, unit) for unit in units
        )))  # fmt: skip
    return tuple(limits)


def _limits_within(context: Context) -> Mapping[Component, float]:
    """Return the limits of the span that is asked about; none where it holds no two frames."""
    ends = (middle(context, each) for each in context.span)
    try:
        return context.worlds.track.between(*ends, unit="s").limits
    except UsageError:
        return {}


def moved_along(context: Context, axis: str) -> Moved:
    """Return what is told of a slide's part along one axis of the image."""
    slide = moved(context, (Component.SLIDE,))
    if slide.rest or slide.denied:
        return slide
    moving = holds(context, axis)
    if moving.mean() < 0.5:
        right = min(slide.probability, 1 - float(moving.mean()))
        return replace(slide, still_axis=axis, probability=right)
    twist = np.broadcast_to(net(context, Component.SLIDE)[0], (COUNT, 4))
    ways = {"x": (Motion.LEFT, Motion.RIGHT), "y": (Motion.UP, Motion.DOWN)}[axis]
    goes = {way: (twist @ AXIS[ATOM_OF[way]] > 0) & moving for way in ways}
    way = max(goes, key=lambda each: goes[each].mean())
    amount, _ = spread(measured(context, axis, twist), moving, context)
    right = float(goes[way].mean())
    path = None
    if context.now is None and context.worlds.is_timed:
        path = _longer_path(context, axis, moving, amount)
    move = Movement(way, None, amount, right, barely=False, path=path)
    return replace(slide, movements=(move,), probability=right)


def moved_on_thread(context: Context) -> Moved:
    """Return whether a turn tightens or loosens its thread.

    Raises:
        Untold: If a fact on the thread lacks.
    """
    turn = moved(context, (Component.TURN,))
    if turn.rest or turn.denied:
        return turn  # neither tightens nor loosens
    chances = {word: float(holds(context, word).mean()) for word in ("tighten", "loosen")}
    if min(chances.values()) >= 0.5:  # there and back: it does both, one after the other
        return replace(turn, tightens=None, probability=min(chances.values()))
    word = max(chances, key=chances.__getitem__)
    return replace(turn, tightens=word == "tighten", probability=chances[word])


def shown_in(
    context: Context, components: tuple[Component, ...] = COMPONENTS, at_s: float | None = None
) -> tuple[Shown, ...]:
    """Return what an answer has looked at of what likely happens, motions of some components only.

    Of a moment, seconds, what goes on at it.
    """
    seen = context.trace.happenings.values() if context.worlds.is_timed else ()
    likely = (each for each in seen if each.probability >= 0.5)
    if at_s is not None:
        likely = (each for each in likely if each.begin_s - 1e-9 <= at_s <= each.end_s + 1e-9)
    elif context.begin is not None:  # what bounds a span may lie outside it
        begin, end = (middle(context, each) for each in context.span)
        likely = (each for each in likely if each.begin_s < end and each.end_s > begin)
    likely = (each for each in likely if each.component in (None, *components))
    return tuple(shown(context, each) for each in sorted(likely, key=lambda each: each.begin_s))


def story_of(context: Context, components: tuple[Component, ...] = COMPONENTS) -> tuple[Shown, ...]:
    """Return all that likely happens in the span, by when it begins; motions of some components."""
    if not context.worlds.is_timed:
        return ()
    likely = [each for each in context.worlds.happenings if each.probability >= 0.5]
    own = [each for each in likely if each.component in (None, *components)]
    begin, end = (middle(context, np.asarray(each)) for each in context.looked_at)
    inside = [each for each in own if each.end_s >= begin and each.begin_s <= end]
    if context.now is not None:  # what goes on is told whole
        return tuple(shown(context, each) for each in inside)
    parts = [(each, clipped(each, begin, end)) for each in inside]
    # What only touches the span's border lies outside; what happens at one moment has no length.
    return tuple(shown(context, part) for each, part in parts
                 if part.end_s > part.begin_s or each.begin_s == each.end_s)  # fmt: skip


def clipped(happening: Happening, begin_s: float, end_s: float) -> Happening:
    """Return what of a happening lies in a span."""
    if begin_s <= happening.begin_s and happening.end_s <= end_s:
        return happening
    first, last = max(begin_s, happening.begin_s), min(end_s, happening.end_s)
    share = happening.share_at(np.asarray(last)) - happening.share_at(np.asarray(first))
    return replace(happening, begin_s=first, end_s=last, twist=share[..., None] * happening.twist)


def shown(context: Context, happening: Happening) -> Shown:
    """Return a happening as it is told."""
    is_real = happening.is_real
    mean = happening.twist[is_real].mean(axis=0) if is_real.any() else np.zeros(4)
    amount, readable = None, context.worlds.belief.readable.get(happening.component, True)
    if readable and happening.component is not None and happening.begin_s < happening.end_s:
        numbers = measured(context, happening.component.value, happening.twist)
        amount, _ = spread(numbers, is_real, replace(context, trace=Trace(reason="none-such")))
    path = float(np.median(happening.path_px[is_real])) if is_real.any() else 0.0
    way = way_of(happening.kind, mean)
    aslant, is_diagonal = Twist(*mean).lesser_way() if way in SLIDES else (None, False)
    return Shown(happening.kind, way, happening.begin_s, happening.end_s, amount, path,
                 happening.probability, happening.is_edge, aslant, is_diagonal)  # fmt: skip
