"""Measures: how far, how fast, how long and how often, arithmetic, and units."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from geotlm_lm.core.tolerance import TOLERANCES
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.query import program as p
from geotlm_lm.query.evaluate import (
    COMPONENT,
    GRID,
    PRIMITIVES,
    Context,
    Floats,
    Numbers,
    Spot,
    Untold,
    evaluate,
    grid,
    inside,
    middle,
    moments,
)
from geotlm_lm.query.program import Expression
from geotlm_lm.query.units import (
    clock_step,
    clock_unit,
    converted,
    scale_of,
)
from geotlm_lm.query.worlds import COUNT, Worlds
from geotlm_lm.track.events import TOGETHER_S

RATE_S = 0.2
"""Time over which a speed is measured: less is noise."""

BACK = 0.5
"""Share of the way to its farthest point that is left, at the end, of what comes back."""


def net(context: Context, component: Component) -> tuple[Floats, Floats]:
    """Return the net and the whole motion of a component in a span, up to a moment.

    Both are (..., COUNT, 4); the whole motion is the path of each of its numbers, there and back.
    """
    context.trace.components[component] = None
    begin, end = context.span
    end = end if context.now is None else context.now
    shape = np.broadcast_shapes(np.shape(begin), np.shape(end), (COUNT,))
    # Adding what is over costs as many numbers as there are worlds, not moments times worlds.
    total, whole, moved = np.zeros((COUNT, 4)), np.zeros((COUNT, 4)), np.zeros(COUNT, bool)
    for happening, share in inside(context, component):
        part = share[..., None] * happening.twist
        total, whole = total + part, whole + np.abs(part)
        moved = moved | (happening.is_real & (share > 0))
    unseen = np.where(moved[..., None], 0.0, context.worlds.unseen)
    shape = (*shape, 4)
    return np.broadcast_to(total + unseen, shape), np.broadcast_to(whole + np.abs(unseen), shape)


def measured(context: Context, atom: str, twist: Floats) -> Numbers:
    """Return how far something goes in a motion (..., 4): with a sign where the atom is a way."""
    turn, right, down, inward = np.moveaxis(twist, -1, 0)
    component = COMPONENT[atom]
    if component is Component.TURN:
        sign = {"cw": 1, "ccw": -1}.get(atom)
        return Numbers(
            np.abs(turn) if sign is None else sign * turn, "deg", TOLERANCES["deg"], atom
        )
    if component is Component.PRESS:
        sign = {"in": 1, "out": -1}.get(atom)
        far = np.abs(inward) if sign is None else sign * inward
        return Numbers(far, "mm", TOLERANCES["mm"], atom)
    unit, (across, along) = scale_of(context)
    right, down = across * right, along * down
    far = {
        "slide": lambda: np.hypot(right, down),
        "x": lambda: np.abs(right),
        "y": lambda: np.abs(down),
        "right": lambda: right,
        "left": lambda: -right,
        "down": lambda: down,
        "up": lambda: -down,
    }[atom]()
    tolerance = TOLERANCES["px"] * (along if atom in ("y", "down", "up") else across)
    return Numbers(far, unit, tolerance, atom)


def _atom(context: Context, atom: str) -> str:
    """Return what "move" stands for: what has the unit that is wanted, or the farther motion."""
    if atom != "move":
        return atom
    if context.length is not None:
        return "turn" if context.length == "deg" else "slide"
    mains = {_farther(clip.worlds) for clip in context.clips} - {None}
    if len(mains) > 1:  # of two clips that are compared
        raise Untold("unlike")
    return (mains.pop() if mains else Component.TURN).value


def _farther(worlds: Worlds) -> Component | None:
    """Return which of turn and slide goes farther; None where neither moves."""
    paths = {
        component: sum(
            float(np.mean(happening.path_px * happening.is_real))
            for happening in worlds.motions(component)
        )
        for component in COMPONENTS[:2]
    }
    farther = max(paths, key=paths.__getitem__)
    return farther if worlds.belief.moves(farther) >= 0.5 or worlds.is_timed else None


def _net(context: Context, atom: str) -> Numbers:
    atom = _atom(context, atom)
    _require_readable(context, atom)
    return measured(context, atom, net(context, COMPONENT[atom])[0])


def _amount(context: Context, atom: str) -> Numbers:
    """Return the net way; of what comes back how far it got, or how far it went a way."""
    if not comes_back(context, atom):
        return _net(context, atom)
    return (_path if atom in p.WAYS else _peak)(context, atom)


_AXIS = {"cw": "turn", "ccw": "turn", "left": "x", "right": "x", "up": "y", "down": "y",
         "in": "press", "out": "press"}  # fmt: skip


def comes_back(context: Context, atom: str) -> bool:
    """Tell whether something ends nearer to where it began than to where it got."""
    if context.now is not None or not context.worlds.is_timed:
        return False
    atom = _AXIS.get(atom) or _atom(context, atom)
    if not any(True for _ in inside(context, COMPONENT[atom])):
        return False
    far, at_most = (np.median(each(context, atom).values) for each in (_net, _peak))
    return bool(far < BACK * at_most)


def _require_readable(context: Context, atom: str) -> None:
    belief = context.worlds.belief
    component = COMPONENT[atom]
    if not belief.readable.get(component, True) and belief.moves(component) >= 0.5:
        raise Untold("unreadable")


def _path(context: Context, atom: str) -> Numbers:
    """Return how far it goes there and back; of a way all that goes it."""
    atom = _atom(context, atom)
    _require_readable(context, atom)
    component = COMPONENT[atom]
    still = measured(context, atom, np.zeros((COUNT, 4)))
    total = still.values
    for happening, share in inside(context, component):
        part = measured(context, atom, share[..., None] * happening.twist)
        total = total + np.maximum(part.values, 0.0)
    context.trace.components[component] = None
    return still.also(total)


def _edges(context: Context, atom: str) -> tuple[Floats, Numbers]:
    """Return the moments between which nothing turns back, and the way up to each."""
    worlds = context.worlds
    begin, end = (middle(context, each) for each in context.span)
    times = {float(begin), float(end)}
    for happening in worlds.motions(COMPONENT[atom]):
        times |= {t for t in (happening.begin_s, happening.end_s) if begin <= t <= end}
    grid = np.array(sorted(times))
    return grid, _net(replace(context, now=grid[:, None]), atom)


def _peak(context: Context, atom: str) -> Numbers:
    _, way = _edges(context, atom := _atom(context, atom))
    return way.also(way.values.max(axis=0))


def _peak_time(context: Context, atom: str) -> Floats:
    context.timed()
    times, way = _edges(context, _atom(context, atom))
    return times[way.values.argmax(axis=0)]


def _moving_s(context: Context, component: Component) -> Floats:
    """Return for how long a component moves in each world, on the recording's clock."""
    begin, end = context.span
    total = np.zeros(COUNT)
    for happening in context.worlds.motions(component):
        inside = np.minimum(end, happening.end_s) - np.maximum(begin, happening.begin_s)
        total = total + happening.is_real * np.maximum(inside, 0.0)
    return total


def _speed(context: Context, atom: str) -> Numbers:
    atom = _atom(context, atom)
    if context.now is not None:
        return _rate(context, atom, context.now)
    # Of no way in particular all that it goes counts: there and back is no standing still.
    way = _path(context, atom) if atom in (*p.COMPONENTS, "x", "y") else _net(context, atom)
    if not context.worlds.is_timed:
        seconds = context.evidence.recording.seconds
        if not seconds:
            raise Untold("rate")
        return way.also(
            way.values / seconds, unit=f"{way.unit}/s", tolerance=way.tolerance / seconds
        )
    moving = _moving_s(context, COMPONENT[atom])
    moving = np.where(moving > 0, moving, np.nan) / clock_step(context)
    seconds = float(np.median(moving[np.isfinite(moving)])) if np.isfinite(moving).any() else 1.0
    values = np.where(np.isnan(moving), 0.0, way.values / np.nan_to_num(moving, nan=1.0))
    return way.also(
        values, unit=f"{way.unit}/{clock_unit(context)}", tolerance=way.tolerance / seconds
    )


def _rate(context: Context, atom: str, now: Floats) -> Numbers:
    worlds = context.timed()
    early = np.maximum(now - RATE_S / 2, worlds.begin_s)
    late = np.minimum(now + RATE_S / 2, worlds.end_s)
    way = _net(context.within(early, late), atom)
    ticks = np.maximum(late - early, 1e-9) / clock_step(context)
    return way.also(way.values / ticks, unit=f"{way.unit}/{clock_unit(context)}",
                    tolerance=way.tolerance * clock_step(context) / RATE_S)  # fmt: skip


def _fastest(context: Context, atom: str) -> tuple[float, Numbers]:
    """Return when it is fastest, in the middle of the worlds, and how fast it is there."""
    best: tuple[float, float] = (-math.inf, 0.0)
    times = grid(context)
    for first in range(0, len(times), GRID):
        part = times[first : first + GRID]
        speeds = np.median(_rate(context, atom, part[:, None]).values, axis=1)
        place = int(speeds.argmax())
        best = max(best, (float(speeds[place]), float(part[place])))
    return best[1], _rate(context, atom, np.asarray(best[1]))


def _limit(context: Context, atom: str) -> Numbers:
    component = COMPONENT[_atom(context, atom)]
    belief = context.worlds.belief
    if component not in belief.limits:
        raise Untold("contact")
    mean = belief.at_limit.mean
    twist = np.array([mean.turn_deg, mean.right_px, 0.0, mean.inward_mm])
    numbers = measured(context, component.value, np.tile(twist, (COUNT, 1)))
    return numbers.also(np.abs(numbers.values))


def duration(context: Context, clock_s: Floats) -> Numbers:
    """Return times of the track's clock in seconds, or in frames where no rate is known."""
    step = clock_step(context)
    return Numbers(clock_s / step, clock_unit(context), TOGETHER_S / step)


def length_of(spot: Spot) -> Floats:
    """Return how long a span is in each world, (COUNT,)."""
    return np.broadcast_to(np.asarray(spot.end) - np.asarray(spot.begin), (COUNT,))


def _length(context: Context, span: Expression) -> Numbers:
    context.timed()
    return duration(context, length_of(evaluate(span, context)))


def _lasts(context: Context, events: Expression) -> Numbers:
    """Return for how long some events go on, all together; what overlaps counts once."""
    context.timed()
    lasting = evaluate(events, context)
    total, until = np.zeros(COUNT), np.full(COUNT, -math.inf)
    begin, end = context.span
    for happening, is_so in zip(lasting.happenings, lasting.is_so, strict=True):
        first = np.maximum(np.maximum(happening.begin_s, begin), until)
        last = np.minimum(happening.end_s, end)
        total = total + np.where(is_so, np.maximum(last - first, 0.0), 0.0)
        until = np.where(is_so, np.maximum(until, last), until)
    return duration(context, total)


def _time_while(context: Context, inner: Expression) -> Numbers:
    """Return for how long something is so: each frame stands for the time around it."""
    times = grid(context)
    weights = np.gradient(times) if len(times) > 1 else np.zeros(1)
    weights[[0, -1]] /= 2
    total, at = np.zeros(COUNT), 0
    for part, holds in moments(context, inner):
        total = total + weights[at : at + len(part)] @ holds
        at += len(part)
    return duration(context, total)


def _share(context: Context, inner: Expression) -> Numbers:
    length = length_of(Spot(*context.span))
    share = _time_while(context, inner).values / np.maximum(length, 1e-9)
    return Numbers(100 * np.minimum(share, 1.0), "percent", 2.0)


def _count(context: Context, events: Expression) -> Numbers:
    return Numbers(evaluate(events, context).is_so.sum(axis=0).astype(float), "")


def _delay(context: Context, early: Expression, late: Expression) -> Numbers:
    far = np.asarray(evaluate(late, context)) - np.asarray(evaluate(early, context))
    return duration(context, np.broadcast_to(far, (COUNT,)))


def _clock(context: Context, time: Expression) -> Numbers:
    at = np.asarray(evaluate(time, context)) - context.timed().begin_s
    return duration(context, np.broadcast_to(at, (COUNT,)))


def _fact(context: Context, value: float | None, unit: str, reason: str = "rate") -> Numbers:
    if value is None:
        raise Untold(reason)
    return Numbers(np.full(COUNT, float(value)), unit)


def placed(context: Context) -> tuple[float, float]:
    """Return where the middle of the contact lies: shares of the width and of the height."""
    area = context.evidence.area
    if area is None:
        raise Untold("place")
    a, b, c, d = context.view.rotation
    x, y = area.across - 0.5, area.down - 0.5
    return a * x + b * y + 0.5, c * x + d * y + 0.5


def _size(context: Context, pixels: int) -> Numbers:
    return converted(context, Numbers(np.full(COUNT, float(pixels)), "px"), scale_of(context)[0])


def _area(context: Context) -> Numbers:
    area = context.evidence.area
    if area is None:
        raise Untold("share")
    return Numbers(np.full(COUNT, 100 * area.share), "percent", 5.0)


def _chance(context: Context, inner: Expression) -> Numbers:
    holds = np.nan_to_num(evaluate(inner, context))
    share = np.broadcast_to(holds, np.broadcast_shapes(holds.shape, (COUNT,))).mean(-1)
    return Numbers(np.repeat(100 * share[..., None], COUNT, axis=-1), "percent", 2.0)


PRIMITIVES |= {
    "amount": _amount,
    "net": _net,
    "path": _path,
    "peak": _peak,
    "speed": _speed,
    "top-speed": lambda context, atom: _fastest(context, _atom(context, atom))[1],
    "limit": _limit,
    "length": _length,
    "lasts": _lasts,
    "time-while": _time_while,
    "share": _share,
    "count": _count,
    "delay": _delay,
    "clock": _clock,
    "area": _area,
    "place-x": lambda context: _fact(context, 100 * placed(context)[0], "percent"),
    "place-y": lambda context: _fact(context, 100 * placed(context)[1], "percent"),
    "frame-rate": lambda context: _fact(context, context.evidence.recording.rate_hz, "frame/s"),
    "frame-width": lambda context: _size(context, context.evidence.recording.columns),
    "frame-height": lambda context: _size(context, context.evidence.recording.rows),
    "frame-count": lambda context: _fact(context, context.evidence.recording.frames, ""),
    "chance": _chance,
    "peak-time": _peak_time,
    "top-speed-time": lambda context, atom: np.full(
        COUNT, _fastest(context, _atom(context, atom))[0]
    ),
}
