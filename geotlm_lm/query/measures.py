"""How far, how fast and which way what moves goes in each world, and whether it does."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import astuple, replace
from functools import reduce

import numpy as np

from geotlm_lm.core.geometry import travel_scale
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.tolerance import TOLERANCES
from geotlm_lm.core.twist import ASLANT, COMPONENTS, MOVING_PX, Component
from geotlm_lm.query import program as p
from geotlm_lm.query.evaluate import (
    GRID,
    PRIMITIVES,
    Context,
    Floats,
    Numbers,
    Untold,
    contact_unknown,
    grid,
    inside,
    middle,
)
from geotlm_lm.query.program import AXIS, COMPONENT, WAY_ATOMS, WAYS
from geotlm_lm.query.worlds import COUNT, Bools, Happening, Worlds

RATE_S = 0.2
"""Time over which a speed is measured: less is noise."""

BACK = 0.5
"""Share of the way to its farthest point that is left, at the end, of what comes back."""

_PLACE = {"turn": 0, "x": 1, "y": 2, "press": 3}


def net(
    context: Context, component: Component, whole: Context | None = None
) -> tuple[Floats, Floats]:
    """Return the net and the whole motion of a component in a span, up to a moment.

    Both are (..., COUNT, 4); the whole motion is the path of each of its numbers, there and back.
    What is too small to be seen is added where nothing moves in the span, or in the whole of which
    it is a part.
    """
    context.trace.components[component] = None
    begin, end = context.span
    end = end if context.now is None else context.now
    # Adding what is over costs as many numbers as there are worlds, not moments times worlds.
    total, path, moved = np.zeros((COUNT, 4)), np.zeros((COUNT, 4)), np.zeros(COUNT, bool)
    for happening, share in inside(context, component):
        part = share[..., None] * happening.twist
        total, path = total + part, path + np.abs(part)
        moved = moved | _is_measured(happening, share)
    for happening, share in () if whole is None else inside(whole, component):
        moved = moved | _is_measured(happening, share)
    unseen = np.where(moved[..., None], 0.0, context.worlds.unseen)
    shape = (*np.broadcast_shapes(np.shape(begin), np.shape(end), (COUNT,)), 4)
    return np.broadcast_to(total + unseen, shape), np.broadcast_to(path + np.abs(unseen), shape)


def _is_measured(happening: Happening, share: Floats) -> Bools:
    """Tell in which worlds a motion is seen and its way known, unlike that of a sudden release."""
    return happening.is_real & (share > 0) & (happening.path_px > 0)


def scale_of(context: Context) -> tuple[str, tuple[float, float]]:
    """Return "px" or "mm" and how many of it are a pixel of our square across and down."""
    frame, recording = context.frame, context.evidence.recording
    usual = "px" if frame.mm_per_px is None else "mm"
    wanted = context.length if context.length in ("px", "mm") else usual
    if wanted == "mm" and frame.mm_per_px is None:
        raise Untold("scale")
    size = frame.mm_per_px if wanted == "mm" else None
    _, scale = travel_scale(recording.rows, recording.columns, size)
    is_turned = context.view.rotation[0] == 0  # columns are rows then
    return wanted, scale[::-1] if is_turned else scale


def measured(context: Context, atom: str, twist: Floats) -> Numbers:
    """Return how far something goes in a motion (..., 4): with a sign where the atom is a way."""
    component, unit, across, along = COMPONENT[atom], "deg", 1.0, 1.0
    if component is Component.SLIDE:
        unit, (across, along) = scale_of(context)
    elif component is Component.PRESS:
        unit = "mm"
    scaled = twist * np.array([1.0, across, along, 1.0])
    if atom in AXIS:
        far = scaled @ AXIS[atom]
    elif atom == "slide":
        far = np.hypot(scaled[..., 1], scaled[..., 2])
    else:
        far = np.abs(scaled[..., _PLACE[atom]])
    base = "px" if component is Component.SLIDE else unit
    tolerance = TOLERANCES[base] * (along if atom in ("y", "down", "up") else across)
    return Numbers(far, unit, tolerance, atom)


# What moves, and which way


def trait(context: Context, word: str) -> Floats:
    """Tell in which worlds something is so of the span, or of the moment."""
    belief = context.worlds.belief
    if word in ("touch", "none", "in", "out", "press") and not belief.is_contact_known:
        moves = reduce(np.maximum, (_moves(context, component) for component in COMPONENTS[:2]))
        if word == "touch" and np.mean(moves) >= 0.5:
            return moves  # what turns or slides touches
        raise contact_unknown(context)
    if word in ("touch", "none"):
        touches = _touched(context)
        return touches if word == "touch" else 1 - touches
    if word in ("still", "move"):
        is_any = word == "still" or belief.is_contact_known
        parts = COMPONENTS if is_any else COMPONENTS[:2]
        moves = reduce(np.maximum, (_moves(context, component) for component in parts))
        return moves if word == "move" else _touched(context) * (1 - moves)
    if word in ("x", "y"):
        sides = ("left", "right") if word == "x" else ("up", "down")
        return np.maximum(*(_goes(context, side) for side in sides))
    if word in ("tighten", "loosen"):
        ways = [_goes(context, way) * (_tightens(context, way) == (word == "tighten"))
                for way in ("cw", "ccw")]  # fmt: skip
        return np.maximum(*ways)
    context.trace.components[COMPONENT[word]] = None
    return _moves(context, COMPONENT[word]) if word in p.COMPONENTS else _goes(context, word)


def holds(context: Context, word: str) -> Bools:
    """Return the worlds in which something is so of the span, (COUNT,)."""
    return np.broadcast_to(trait(context, word), (COUNT,)) > 0


def _touched(context: Context) -> Floats:
    worlds = context.worlds
    begin, end = context.looked_at
    is_inside = np.zeros(np.broadcast(begin, end).shape, bool)
    for first, last in worlds.contacts:
        is_inside = is_inside | ((np.asarray(begin) <= last) & (np.asarray(end) >= first))
    return (worlds.touches & is_inside).astype(float)


def _parts(context: Context, component: Component) -> Iterator[tuple[Happening, Bools, Floats]]:
    """Yield what moves of a component: in which worlds, and the share of it that lies inside."""
    if context.now is None:
        counts_edges = component is not Component.PRESS or context.has_edges
        for happening, share in inside(context, component):
            least = np.minimum(MOVING_PX, 0.999 * happening.path_px)
            if counts_edges or not happening.is_edge:
                yield happening, happening.is_real & (share * happening.path_px >= least), share
        return
    now = np.asarray(context.now)
    for happening in context.worlds.motions(component):
        is_over = happening.begin_s > np.max(now) or happening.end_s < np.min(now)
        if not is_over:  # while it is pressed against the gel, or lifted, it is not at rest
            goes_on = (happening.begin_s <= now) & (now <= happening.end_s)
            yield happening, happening.is_real & goes_on, np.ones(())


def going_on(context: Context, component: Component) -> tuple[Floats, Floats]:
    """Return the motion of a component that goes on at a moment, from its begin to its end, twice.

    Both are (COUNT, 4), as `net`'s are.
    """
    total = np.zeros((COUNT, 4))
    for happening, is_so, _ in _parts(context, component):
        total = total + np.where(is_so[..., None], happening.twist, 0.0)
    return total, np.abs(total)


def _moves(context: Context, component: Component) -> Floats:
    moves = np.zeros(COUNT, bool)
    for _, is_so, _ in _parts(context, component):
        moves = moves | is_so
    return moves.astype(float)


def _goes(context: Context, way: str) -> Floats:
    """Tell in which worlds it goes a way: by a third of the farthest that it goes any way."""
    component = COMPONENT[way]
    context.trace.components[component] = None
    rivals = [other for other in WAYS if COMPONENT[other] is component]
    axes = np.array([AXIS[rival] for rival in rivals], float).T
    far = np.zeros((COUNT, len(rivals)))
    for happening, is_so, share in _parts(context, component):
        along = np.maximum(happening.twist @ axes, 0.0)
        far = far + np.where(is_so, share, 0.0)[..., None] * along
    own = far[..., rivals.index(way)]
    return ((own > 0) & (own >= ASLANT * far.max(axis=-1))).astype(float)


def _tightens(context: Context, way: str) -> bool:
    frame = context.frame
    if frame.contact_side == "side":
        raise Untold("side")
    if frame.missing_for_thread():
        if _moves(context, Component.TURN).mean() < 0.5:
            return way == "cw"  # it hardly turns: neither is probable, whatever thread
        raise Untold("thread")
    # A mirror that is only supposed would make another thread; who looks from where does not.
    supposed = replace(context.edit, behind=False, sensor=False, rotation=context.edit.image)
    recorded: Motion = context.view.inverse().of_way(WAY_ATOMS[way])
    return bool(frame.tightens(supposed.of_way(recorded)))


# How far and how fast


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


def _readable(context: Context, atom: str) -> str:
    """Return what an atom stands for.

    Raises:
        Untold: If it moves and the picture does not tell how far.
    """
    atom, belief = _atom(context, atom), context.worlds.belief
    component = COMPONENT[atom]
    if not belief.readable.get(component, True) and belief.moves(component) >= 0.5:
        raise Untold("unreadable")
    return atom


def _net(context: Context, atom: str, whole: Context | None = None) -> Numbers:
    atom = _readable(context, atom)
    return measured(context, atom, net(context, COMPONENT[atom], whole)[0])


def _amount(context: Context, atom: str) -> Numbers:
    """Return the net way; of what comes back how far it got, or how far it went a way."""
    if not comes_back(context, atom):
        return _net(context, atom)
    return (path_of if atom in WAYS else _peak)(context, atom)


def comes_back(context: Context, atom: str) -> bool:
    """Tell whether something ends nearer to where it began than to where it got."""
    if context.now is not None or not context.worlds.is_timed:
        return False
    if atom in WAYS:
        atom = list(_PLACE)[np.abs(AXIS[atom]).argmax()]
    atom = _atom(context, atom)
    if not any(True for _ in inside(context, COMPONENT[atom])):
        return False
    far, at_most = (np.median(way(context, atom).values) for way in (_net, _peak))
    return bool(far < BACK * at_most)


def path_of(context: Context, atom: str) -> Numbers:
    """Return how far it goes there and back; of a way all that goes it."""
    atom = _readable(context, atom)
    still = measured(context, atom, np.zeros((COUNT, 4)))
    total = still.values
    for happening, share in inside(context, COMPONENT[atom]):
        part = measured(context, atom, share[..., None] * happening.twist)
        total = total + np.maximum(part.values, 0.0)
    context.trace.components[COMPONENT[atom]] = None
    return still.also(total)


def _edges(context: Context, atom: str) -> tuple[Floats, Numbers]:
    """Return the moments between which nothing turns back, and the way up to each."""
    begin, end = (middle(context, each) for each in context.span)
    times = {float(begin), float(end)}
    for happening in context.worlds.motions(COMPONENT[atom]):
        times |= {t for t in (happening.begin_s, happening.end_s) if begin <= t <= end}
    edges, whole = np.array(sorted(times)), replace(context, now=None)
    return edges, _net(replace(whole, now=edges[:, None]), atom, whole)


def _peak(context: Context, atom: str) -> Numbers:
    _, way = _edges(context, _atom(context, atom))
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
        lasting = np.minimum(end, happening.end_s) - np.maximum(begin, happening.begin_s)
        total = total + happening.is_real * np.maximum(lasting, 0.0)
    return total


def _speed(context: Context, atom: str) -> Numbers:
    atom = _atom(context, atom)
    if context.now is not None:
        return _rate(context, atom, context.now)
    # Of no way in particular all that it goes counts: there and back is no standing still.
    way = path_of(context, atom) if atom in (*p.COMPONENTS, "x", "y") else _net(context, atom)
    if not context.worlds.is_timed:
        seconds = context.evidence.recording.seconds
        if not seconds:
            raise Untold("rate")
        return _over(way, way.values / seconds, "s", seconds)
    moving = _moving_s(context, COMPONENT[atom])
    moving = np.where(moving > 0, moving, np.nan) / context.clock_step
    seconds = float(np.median(moving[np.isfinite(moving)])) if np.isfinite(moving).any() else 1.0
    values = np.where(np.isnan(moving), 0.0, way.values / np.nan_to_num(moving, nan=1.0))
    return _over(way, values, context.clock_unit, seconds)


def _over(way: Numbers, values: Floats, unit: str, time: float) -> Numbers:
    """Return how fast a way is gone."""
    return way.also(values, unit=f"{way.unit}/{unit}", tolerance=way.tolerance / time)


def _rate(context: Context, atom: str, now: Floats) -> Numbers:
    worlds = context.timed()
    early = np.maximum(now - RATE_S / 2, worlds.begin_s)
    late = np.minimum(now + RATE_S / 2, worlds.end_s)
    way = _net(context.within(early, late), atom, replace(context, now=None))
    ticks = np.maximum(late - early, 1e-9) / context.clock_step
    return _over(way, way.values / ticks, context.clock_unit, RATE_S / context.clock_step)


def _fastest(context: Context, atom: str) -> tuple[float, Numbers]:
    """Return when it is fastest, in the middle of the worlds, and how fast it is there."""
    atom, best, times = _atom(context, atom), (-math.inf, 0.0), grid(context)
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
    numbers = measured(context, component.value, np.tile(astuple(belief.at_limit.mean), (COUNT, 1)))
    return numbers.also(np.abs(numbers.values))


PRIMITIVES |= {
    "amount": _amount,
    "net": _net,
    "path": path_of,
    "peak": _peak,
    "speed": _speed,
    "top-speed": lambda context, atom: _fastest(context, atom)[1],
    "limit": _limit,
    "peak-time": _peak_time,
    "top-speed-time": lambda context, atom: np.full(COUNT, _fastest(context, atom)[0]),
    **{word: lambda context, word=word: trait(context, word) for word in p.TRAITS},
    **{
        word: lambda context, word=word: trait(replace(context, has_edges=True), word)
        for word in ("in", "out", "press")
    },  # fmt: skip
}
