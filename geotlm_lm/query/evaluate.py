"""Evaluate an expression in every possible world side by side.

Pure and total: each primitive is one function from a context and its arguments to an array over the
worlds. Truths are 1, 0, or NaN where a world lacks what is spoken of; logic is Kleene's. What no
world can tell is `Untold`, with its reason. Truths, measures and spans each add their primitives.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.edit import EDIT_WORDS, Edit
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.query import program as p
from geotlm_lm.query.amounts import Recording
from geotlm_lm.query.program import Expression
from geotlm_lm.query.worlds import COUNT, Happening, Worlds

Floats = NDArray[np.float64]

GRID = 512
"""Moments that are looked at together: what is over before them is added once for all of them."""

WAY = {
    "cw": (Component.TURN, (1, 0, 0, 0)),
    "ccw": (Component.TURN, (-1, 0, 0, 0)),
    "right": (Component.SLIDE, (0, 1, 0, 0)),
    "left": (Component.SLIDE, (0, -1, 0, 0)),
    "down": (Component.SLIDE, (0, 0, 1, 0)),
    "up": (Component.SLIDE, (0, 0, -1, 0)),
    "in": (Component.PRESS, (0, 0, 0, 1)),
    "out": (Component.PRESS, (0, 0, 0, -1)),
}
"""Component and axis of each way: turn, right, down, inward."""

COMPONENT = {
    **{word: component for word, (component, _) in WAY.items()},
    **{component.value: component for component in COMPONENTS},
    "x": Component.SLIDE,
    "y": Component.SLIDE,
}


MOVERS = {"as-object": False, "as-sensor": True}


class Untold(Exception):  # noqa: N818  (no error: what an answer lacks)
    """Why something cannot be told, a name of `replies.toml`."""


@dataclass(frozen=True)
class ContactArea:
    """Where the recorded image is touched.

    Args:
        across: Share of the width from its left border to the middle of the contact.
        down: Share of the height from its top.
        share: Of the image that is covered.
    """

    across: float
    down: float
    share: float


@dataclass(frozen=True, eq=False)
class Evidence:
    """What answers about one recording rest on."""

    worlds: Worlds
    recording: Recording = field(default_factory=Recording)
    area: ContactArea | None = None
    reasons: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Numbers:
    """A number in every world."""

    values: Floats  # (..., COUNT)
    unit: str  # "deg", "px", "mm", "s", "frame", "percent", "" of a count; "deg/s" of a speed
    tolerance: float = 0.0  # least error that still counts as right
    atom: str | None = None  # what is measured, a word of `program.MEASURED`
    slack: float = 0.0  # error that the terms of a sum may have
    is_signed: bool = False  # a difference, which may be below zero

    def also(self, values: Floats, **changes: Any) -> Numbers:
        """Return other values of the same kind."""
        return replace(self, values=values, **changes)


@dataclass(frozen=True, eq=False)
class Events:
    """What happens of a kind, and in which worlds; by when it begins."""

    happenings: tuple[Happening, ...]
    is_so: NDArray[np.bool_]  # (events, COUNT)


@dataclass(frozen=True, eq=False)
class Spot:
    """One event or span in every world; NaN where there is none."""

    begin: Floats
    end: Floats


@dataclass
class Trace:
    """What an evaluation has looked at."""

    components: dict[Component, None] = field(default_factory=dict)
    happenings: dict[int, Happening] = field(default_factory=dict)
    reason: str | None = None  # why a world lacks what is spoken of


@dataclass(frozen=True, eq=False)
class Context:
    """Where and when an expression is evaluated."""

    clips: tuple[Evidence, ...]  # the one asked about is the last
    frame: FrameSpec
    place: int = -1  # of the clip
    edit: Edit = field(default_factory=Edit)
    begin: Floats | None = None  # the usual span where None
    end: Floats | None = None
    now: Floats | None = None  # of a moment
    length: str | None = None  # "px" or "mm" that travel is measured in, "deg" of a turn
    trace: Trace = field(default_factory=Trace)

    @property
    def evidence(self) -> Evidence:
        """The clip asked about."""
        return self.clips[self.place]

    @cached_property
    def view(self) -> Edit:
        """The whole point of view, from the recorded image."""
        return self.edit.within(self.frame.edit)

    @cached_property
    def worlds(self) -> Worlds:
        """The worlds of the clip as it is seen."""
        return self.evidence.worlds.seen(self.view)

    @property
    def span(self) -> tuple[Floats, Floats]:
        """From when to when: from touch to release, or all of it where contact is not known."""
        if self.begin is not None:
            return self.begin, self.end
        return self.contact

    @property
    def contact(self) -> tuple[Floats, Floats]:
        """From the first touch to the last release."""
        worlds = self.worlds
        spans = worlds.contacts or ((worlds.begin_s, worlds.end_s),)
        return np.asarray(spans[0][0]), np.asarray(spans[-1][1])

    def timed(self) -> Worlds:
        """Return the worlds of a recording that was followed.

        Raises:
            Untold: If it was not.
        """
        if not self.worlds.is_timed:
            raise Untold("track")
        return self.worlds

    def edited(self, word: str) -> Context:
        """Return the context seen from another point of view; a span stays the same frames."""
        is_mover = word in MOVERS
        changed = (
            replace(self.edit, sensor=MOVERS[word]) if is_mover else self.edit.then(Edit.of(word))
        )
        edited = replace(self, edit=changed)
        if self.begin is None or edited.view.backwards == self.view.backwards:
            return edited
        total = self.worlds.begin_s + self.worlds.end_s
        return edited.within(total - self.end, total - self.begin)

    def plain(self) -> Context:
        """Return the context without the views and spans that were asked for."""
        return replace(self, edit=Edit(), begin=None, end=None, now=None)

    def within(self, begin: Floats, end: Floats) -> Context:
        """Return the context of a span.

        Raises:
            Untold: If it lies outside the recording.
        """
        worlds, begins, ends = self.worlds, np.asarray(begin), np.asarray(end)
        if np.min(begins) > worlds.end_s + 1e-9 or np.max(ends) < worlds.begin_s - 1e-9:
            raise Untold("span")
        return replace(self, begin=begin, end=end, now=None)


PRIMITIVES: dict[str, Callable[..., Any]] = {}
"""What each primitive does: (context, *arguments) -> arrays over the worlds."""


def evaluate(expression: Expression, context: Context) -> Any:
    """Return what an expression is in every world: an array of truths, `Numbers`, times and so on.

    Raises:
        Untold: If no world can tell.
    """
    word, arguments = expression.word, expression.arguments
    if expression.value is not None:
        return PRIMITIVES["#"](context, expression.value)
    if word in MOVERS or word in EDIT_WORDS:
        return evaluate(arguments[0], context.edited(word))
    if word in _CLIPS:
        return evaluate(arguments[0], of_clip(context, word))
    if word == "within":
        spot = evaluate(arguments[0], context)
        return _where(spot, evaluate(arguments[1], context.within(spot.begin, spot.end)))
    if word == "at":
        context.timed()
        return evaluate(arguments[1], replace(context, now=evaluate(arguments[0], context)))
    if word == "plain":
        return evaluate(arguments[0], context.plain())
    if word == "if":
        return _if(context, *arguments)
    return PRIMITIVES[word](context, *arguments)


def _where(spot: Spot, values: Any) -> Any:
    """Return what was evaluated in a span, lacking in the worlds that lack the span."""
    is_there = np.isfinite(spot.begin)
    if is_there.all():
        return values
    if isinstance(values, Numbers):
        return values.also(np.where(is_there, values.values, np.nan))
    if isinstance(values, Events):
        return Events(values.happenings, values.is_so & is_there)
    if isinstance(values, Spot):
        return Spot(*(np.where(is_there, each, np.nan) for each in (values.begin, values.end)))
    return np.where(is_there, values, np.nan)


def middle(context: Context, values: Floats) -> float:
    """Return the median over the worlds that have a number.

    Raises:
        Untold: If fewer than half of them do.
    """
    known = np.isfinite(values)
    if known.mean() < 0.5:
        raise Untold(context.trace.reason or "none-such")
    return float(np.median(values[known]))


_CLIPS = {"of-first": 0, "of-second": 1, "of-previous": 0}


def of_clip(context: Context, word: str) -> Context:
    """Return the context of the first or the second of two clips."""
    if len(context.clips) < 2:
        if word == "of-first":
            return context
        raise Untold("second")
    return replace(context, place=_CLIPS[word])


def _if(context: Context, condition: Expression, then: Expression, other: Expression) -> Any:
    if p.type_of(then) != p.type_of(other):
        raise Untold("unit")
    holds = evaluate(condition, context)
    one, two = evaluate(then, context), evaluate(other, context)
    if isinstance(one, Numbers):
        two = PRIMITIVES["in-unit"](context, two, one.unit)
        return one.also(np.where(holds > 0, one.values, two.values) + 0 * holds)
    if isinstance(one, np.ndarray):
        return np.where(holds > 0, one, two) + 0 * holds
    return one if np.nan_to_num(holds).mean() >= 0.5 else two


def _clips(combine: Callable[[Expression, Expression], Expression]):
    """Return what asks the same of both clips and combines it."""

    def combined(context: Context, inner: Expression) -> Any:
        return evaluate(combine(p.of("of-first", inner), p.of("of-second", inner)), context)

    return combined


# Truths


def grid(context: Context) -> Floats:
    """Return the moments of a span at which a frame was taken."""
    worlds = context.timed()
    times = worlds.track.times_s
    if context.view.backwards:
        times = (worlds.begin_s + worlds.end_s - times)[::-1]
    begin, end = (middle(context, each) for each in context.span)
    inside = times[(times >= begin - 1e-9) & (times <= end + 1e-9)]
    if not len(inside):
        raise Untold("span")
    return inside


def moments(context: Context, inner: Expression):
    """Yield the moments of a span, and in which worlds something is so at each of them."""
    times = grid(context)
    for first in range(0, len(times), GRID):
        part = times[first : first + GRID]
        holds = evaluate(inner, replace(context, now=part[:, None]))
        yield part, np.broadcast_to(np.nan_to_num(holds), (len(part), COUNT)) > 0


def inside(context: Context, component: Component) -> Iterator[tuple[Happening, Floats]]:
    """Yield what moves of a component in a span, up to a moment, and the share of it inside.

    What is over before all moments comes first, with one share a world for all of them.
    """
    begin, end = context.span
    end = end if context.now is None else context.now
    first, last = np.min(end), np.max(end)
    for happening in sorted(context.worlds.motions(component), key=lambda each: each.end_s):
        if happening.begin_s >= last or happening.end_s <= np.min(begin):
            continue
        until = 1.0 if happening.end_s <= first else happening.share_at(end)
        yield happening, np.maximum(until - happening.share_at(begin), 0.0)
        context.trace.happenings[id(happening)] = happening


PRIMITIVES |= {
    "both": _clips(lambda one, two: p.of("and", one, two)),
    "either": _clips(lambda one, two: p.of("or", one, two)),
    "neither": _clips(lambda one, two: p.of("not", p.of("or", one, two))),
    "only-one": _clips(
        lambda one, two: p.of("and", p.of("or", one, two), p.of("not", p.of("and", one, two)))
    ),
    "more": _clips(lambda one, two: p.of(">", one, two)),
    "less": _clips(lambda one, two: p.of("<", one, two)),
    "as-far": _clips(lambda one, two: p.of("~", one, two)),
}
