"""Evaluate an expression in every possible world side by side.

Pure and total: each primitive is one function from a context and its arguments to an array over the
worlds. Truths are 1, 0, or NaN where a world lacks what is spoken of; logic is Kleene's. What no
world can tell is `Untold`, with its reason. Truths, measures and spans each add their primitives.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.edit import Edit
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.twist import Component
from geotlm_lm.query import program as p
from geotlm_lm.query.program import AROUND, CLIPS, MOVERS, Expression, Fact, Quantity
from geotlm_lm.query.quantities import FACTORS
from geotlm_lm.query.values import Recording
from geotlm_lm.query.worlds import COUNT, Happening, Worlds

Floats = NDArray[np.float64]

GRID = 512
"""Moments that are looked at together: what is over before them is added once for all of them."""

_PRESENT = p.of("end", p.of("recording"))
"""The moment of which "now" speaks."""


class Untold(Exception):  # noqa: N818  (no error: what an answer lacks)
    """Why something cannot be told, a name of `replies.toml`, and the moment that it names."""

    def __init__(self, reason: str, at_s: float | None = None) -> None:
        super().__init__(reason)
        self.at_s = at_s


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

    @classmethod
    def of(cls, happenings: Sequence[Happening], masks: Sequence[NDArray[np.bool_]]) -> Events:
        """Return events, each with the worlds in which it happens, (COUNT,)."""
        return cls(tuple(happenings), np.array(masks, dtype=bool).reshape(len(masks), COUNT))

    @property
    def likely(self) -> list[Happening]:
        """Those that happen in half of the worlds or more."""
        is_likely = self.is_so.mean(axis=1) >= 0.5
        return [each for each, is_so in zip(self.happenings, is_likely, strict=True) if is_so]


@dataclass(frozen=True, eq=False)
class Spot:
    """One event or span in every world; NaN where there is none."""

    begin: Floats
    end: Floats

    @property
    def length(self) -> Floats:
        """How long it is in each world, (COUNT,)."""
        return np.broadcast_to(np.asarray(self.end) - np.asarray(self.begin), (COUNT,))


@dataclass
class Trace:
    """What an evaluation has looked at."""

    components: dict[Component, None] = field(default_factory=dict)
    happenings: dict[int, Happening] = field(default_factory=dict)
    reason: str | None = None  # why a world lacks what is spoken of
    lacking: Expression | None = None  # of what happens what is spoken of that most worlds lack


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
    # Whether what begins or ends contact counts as pressing in or lifting off: where that is asked,
    # and at every moment.
    has_edges: bool = False
    event: Happening | None = None  # that is looked at, one of several kinds
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
    def looked_at(self) -> tuple[Floats, Floats]:
        """From when to when, of a moment that alone."""
        return self.span if self.now is None else (self.now, self.now)

    @property
    def contact(self) -> tuple[Floats, Floats]:
        """From the first touch to the last release."""
        spans = self.worlds.contacts
        if not spans:
            return self.recorded
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
        edited = replace(self, edit=changed, event=None)
        if self.begin is None or edited.view.backwards == self.view.backwards:
            return edited
        total = self.worlds.begin_s + self.worlds.end_s
        return edited.within(total - self.end, total - self.begin)

    @property
    def recorded(self) -> tuple[Floats, Floats]:
        """From the first frame to the last."""
        return np.asarray(self.worlds.begin_s), np.asarray(self.worlds.end_s)

    @property
    def clock_unit(self) -> str:
        """What the recording's clock counts: seconds, or frames where its rate is not known."""
        return "s" if self.evidence.recording.rate_hz else "frame"

    @property
    def clock_step(self) -> float:
        """How long a unit of that clock is on the track's own, seconds."""
        recording = self.evidence.recording
        return 1.0 if recording.rate_hz else recording.step_s or 1.0

    def plain(self) -> Context:
        """Return the context without the views and spans that were asked for."""
        return replace(self, edit=Edit(), begin=None, end=None, now=None, event=None)

    def within(self, begin: Floats, end: Floats) -> Context:
        """Return the context of a span.

        Raises:
            Untold: If it lies outside the recording.
        """
        worlds, begins, ends = self.worlds, np.asarray(begin), np.asarray(end)
        if np.min(begins) > worlds.end_s + 1e-9 or np.max(ends) < worlds.begin_s - 1e-9:
            raise Untold("span")
        return replace(self, begin=begin, end=end, now=None, event=None)


_FRAME_FIELD = {"seen": "viewpoint", "moves": "actor", "thread": "thread", "side": "contact_side"}
_PLAIN_FRAME = FrameSpec()


def with_facts(frame: FrameSpec, facts: tuple[Fact, ...], columns: int) -> FrameSpec:
    """Return a frame in which some facts hold, in turn.

    Args:
        frame: What held before.
        facts: Filled ones.
        columns: Width of the recording's frames, by which "view" tells the size of a pixel.

    Raises:
        UsageError: If a pixel would be of a size, or frames of a rate, that no camera has.
    """
    for fact in facts:
        frame = replace(frame, **_fields(frame, fact, columns))
    return frame


def _fields(frame: FrameSpec, fact: Fact, columns: int) -> dict[str, Any]:
    if fact.name == "everything":
        return vars(_PLAIN_FRAME)
    if fact.name == "mirrored":
        return {"image_mirrored": not fact.denied}
    if fact.name == "turned":
        degrees = {"half": 180, "quarter-cw": 90, "quarter-ccw": 270}.get(fact.value, 0)
        return FrameSpec.fields_of_turn(0 if fact.denied else degrees)
    if fact.name in _FRAME_FIELD:
        name = _FRAME_FIELD[fact.name]
        return {name: getattr(_PLAIN_FRAME, name) if fact.denied else fact.value}
    if fact.name in ("scale", "view"):
        across = columns if fact.name == "view" else 1
        return {"mm_per_px": None if fact.denied else mm_per_px(fact.numbers[0], across)}
    if fact.name == "rate":
        return {"rate_hz": None if fact.denied else _rate_hz(fact.numbers[0])}
    return {}


def _rate_hz(rate: Quantity) -> float | None:
    """Return frames per second, of a bare number too; None where the quantity is no rate."""
    unit, _, per = rate.unit.partition("/")
    if not rate.unit:
        return rate.value
    second = FACTORS["time"].get(per)
    return rate.value / second if unit == "frame" and second else None


def mm_per_px(size: Quantity, pixels: int = 1) -> float | None:
    """Return the size of a pixel, mm, where so many measure "60 um", or of "20 px/mm".

    A bare number is in mm; None where the quantity is no length.
    """
    unit, _, per = size.unit.partition("/")
    unit = unit or "mm"
    if unit == "px" and per in FACTORS["length"]:
        return FACTORS["length"][per] / size.value if size.value else None
    factor = FACTORS["length"].get(unit)
    return None if factor is None else size.value * factor / pixels


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
    if word == "within":
        spot = evaluate(arguments[0], context)
        return _where(spot, evaluate(arguments[1], context.within(spot.begin, spot.end)))
    if word in AROUND:
        return evaluate(arguments[-1], _inside_of(expression, context))
    return PRIMITIVES[word](context, *arguments)


def placed(expression: Expression, context: Context) -> tuple[Expression, Context]:
    """Return an expression without the views, clips and spans around it, and their context."""
    while expression.word in AROUND:
        context = _inside_of(expression, context)
        expression = expression.arguments[-1]
    return expression, context


def _inside_of(expression: Expression, context: Context) -> Context:
    """Return the context of what stands behind a view, a clip or a span."""
    word = expression.word
    if word in CLIPS:
        return of_clip(context, word)
    if word == "within":
        spot = evaluate(expression.arguments[0], context)
        return context.within(spot.begin, spot.end)
    if word == "at":
        if expression.arguments[0] == _PRESENT and not context.worlds.is_timed:
            return context  # four frames are all of the present
        context.timed()
        now = evaluate(expression.arguments[0], context)
        context.within(now, now)  # it lies in the recording
        return replace(context, now=now)
    return context.plain() if word == "plain" else context.edited(word)


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


def area_moment(context: Context) -> float:
    """Return in the middle of which times of a recording it is known where it is touched."""
    return sum(_area_times(context)) / 2


def _area_times(context: Context) -> tuple[float, float]:
    worlds, used = context.worlds, context.evidence.recording.used
    first, last = np.interp([used[0], used[-1]], worlds.track.numbers, worlds.track.times_s)
    total = worlds.begin_s + worlds.end_s
    return (total - last, total - first) if context.view.backwards else (first, last)


def contact_area(context: Context) -> ContactArea | None:
    """Return where the image is touched, as it is known of the time that is asked about.

    Raises:
        Untold: If nothing touches then, or it is known of another time alone.
    """
    area, is_whole = context.evidence.area, context.begin is None and context.now is None
    if area is None or is_whole or not context.worlds.is_timed:
        return area
    times = [np.asarray(each)[np.isfinite(each)] for each in context.looked_at]
    if not all(each.size for each in times):
        raise Untold(context.trace.reason or "none-such")
    begin, end = times[0].min() - 1e-9, times[1].max() + 1e-9
    if not any(last >= begin and first <= end for first, last in context.worlds.contacts):
        raise Untold("untouched")
    first, last = _area_times(context)
    is_known = begin <= first and last <= end
    if context.now is not None:
        is_known = first <= begin + 2e-9 and end - 2e-9 <= last
    if not is_known:
        raise Untold("area-then", area_moment(context))
    return area


def contact_middle(context: Context) -> tuple[float, float]:
    """Return where the middle of the contact lies: shares of the width and of the height."""
    area = contact_area(context)
    if area is None:
        raise Untold("place")
    a, b, c, d = context.view.rotation
    x, y = area.across - 0.5, area.down - 0.5
    return a * x + b * y + 0.5, c * x + d * y + 0.5


def middle(context: Context, values: Floats) -> float:
    """Return the median over the worlds that have a number.

    Raises:
        Untold: If fewer than half of them do.
    """
    known = np.isfinite(values)
    if known.mean() < 0.5:
        raise Untold(context.trace.reason or "none-such")
    return float(np.median(values[known]))


def of_clip(context: Context, word: str) -> Context:
    """Return the context of the first or the second of two clips."""
    if len(context.clips) < 2:
        if word == "of-first":
            return context
        raise Untold("second")
    return replace(context, place=CLIPS[word])


def _if(context: Context, condition: Expression, then: Expression, other: Expression) -> Any:
    if p.type_of(then) != p.type_of(other):
        raise Untold("unit")
    holds = evaluate(condition, context)
    first, second = evaluate(then, context), evaluate(other, context)
    if isinstance(first, Numbers):
        second = PRIMITIVES["in-unit"](context, second, first.unit)
        return first.also(np.where(holds > 0, first.values, second.values) + 0 * holds)
    if isinstance(first, np.ndarray):
        return np.where(holds > 0, first, second) + 0 * holds
    return first if np.nan_to_num(holds).mean() >= 0.5 else second


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


def moments(context: Context, inner: Expression, times: Floats | None = None):
    """Yield moments, those of a span by default, and in which worlds something is so at each."""
    times = grid(context) if times is None else times
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


def contact_unknown(context: Context) -> Untold:
    """Return why contact is withheld where the untouched gel is not known."""
    belief = context.worlds.belief
    is_moving = max(belief.moves(Component.TURN), belief.moves(Component.SLIDE)) >= 0.5
    return Untold("contact" if is_moving else "reference")


PRIMITIVES["if"] = _if
