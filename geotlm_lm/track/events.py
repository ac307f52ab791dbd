"""What happens in a track: touch, press, turn, slide, stick, slip, release; all defined here.

Events are found while the frames come, some tenths of a second late: whether a motion is over, or
whether it counts at all, shows only afterwards. Each component of the way is cut into legs, which
go one way between rests and ways back; a leg that goes far enough is an event.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, Component, Twist

Floats = NDArray[np.float64]

SPAN_DEVIATIONS = 1.645
"""Deviations either side that hold nine tenths of a bell."""

SYSTEMATIC = (0.16, 0.16, 0.25)
"""Share of a turn, a slide and a press that is doubted beside what is measured step by step: what
the pad holds back, it holds back in every step."""

FLOOR_PX, FLOOR_MM = 0.13, 0.06
"""Deviation of any leg, however short: of a turn as a path at the contact's radius."""

STEPS = (0.12, 0.12, 0.7)
"""Deviation of a turn's, a slide's and a press's leg per formal one of its steps. Key frames keep
the steps' errors from adding up, the model's belief of a depth does not: 59 real imprints held for
1.7 s over their own idle frames wander by 0.11, 0.12 and 0.26 formal ones (median), 0.21, 0.27 and
1.1 in 95 of 100."""

SIGNIFICANT = 2.6
"""Deviations from which on a leg is a motion: of a bell one in a hundred lies beyond."""

COLUMNS = {Component.TURN: slice(0, 1), Component.SLIDE: slice(1, 3), Component.PRESS: slice(3, 4)}
"""Where a component stands in a twist of four numbers."""


@dataclass(frozen=True)
class Span:
    """An amount that was measured, with the span that holds nine tenths of the probability.

    The mean is in signed degrees, pixels or mm; of a slide and of a path not negative.
    """

    mean: float
    deviation: float

    @property
    def low(self) -> float:
        """Lower end."""
        return self.mean - SPAN_DEVIATIONS * self.deviation

    @property
    def high(self) -> float:
        """Upper end."""
        return self.mean + SPAN_DEVIATIONS * self.deviation

    def holds(self, truth: float) -> bool:
        """Tell whether a true amount lies inside."""
        return self.low <= truth <= self.high


def noise_of(component: Component, covariance: Floats, radius_px: float) -> float:
    """Return the deviation by noise alone of a leg with the covariance (4, 4) of its steps.

    In the component's unit: degrees, pixels, mm.
    """
    part, place = COLUMNS[component], COMPONENTS.index(component)
    own = covariance[part, part]
    return math.hypot(
        floor_of(component, radius_px), STEPS[place] * math.sqrt(max(np.trace(own) / len(own), 0.0))
    )


def floor_of(component: Component, radius_px: float) -> float:
    """Return the deviation of a leg of no length, in the component's unit."""
    if component is Component.TURN:
        return math.degrees(FLOOR_PX / max(radius_px, 1.0))
    return FLOOR_PX if component is Component.SLIDE else FLOOR_MM


def amount_of(
    component: Component, twist: Floats, covariance: Floats, radius_px: float
) -> Span:
    """Return how far a component goes in a twist (4,) with the covariance (4, 4) of its steps."""
    way = twist[COLUMNS[component]]
    far = float(np.linalg.norm(way))
    systematic = SYSTEMATIC[COMPONENTS.index(component)] * far
    deviation = math.hypot(noise_of(component, covariance, radius_px), systematic)
    return Span(far if component is Component.SLIDE else float(way[0]), deviation)


REST_S = 0.24
"""Time without progress that ends a leg."""

RESTING, RESTING_SPEED = 0.25, 0.05
"""Progress at rest: share of what is significant, and share of the leg's own mean speed."""

EDGE = 0.5
"""Share of what is significant up to which a path is at its beginning, and from its end on at its
end."""

MOST_POINTS = 256
"""Of a leg, or of a rest, that are kept, its ends whole."""


@dataclass(frozen=True, eq=False)
class Point:
    """A place of the path: which it is, when, and where, (d,), and what noise adds up to there."""

    place: int
    time_s: float
    at: Floats
    variance: float = 0.0  # by noise, summed since the first frame
    floor: float = 0.0  # deviation of any leg that ends here


@dataclass(frozen=True)
class Leg:
    """The places at which a leg begins and ends."""

    begin: int
    end: int


def significant(before: Point, after: Point) -> float:
    """Return how far it is at the least from one point to another if that is no noise."""
    own = max(after.variance - before.variance, 0.0)
    return SIGNIFICANT * math.sqrt(after.floor**2 + own)


def _far(before: Point, after: Point) -> float:
    return float(np.linalg.norm(after.at - before.at))


def _thinned(points: list[Point]) -> list[Point]:
    quarter = MOST_POINTS // 4
    if len(points) <= MOST_POINTS:
        return points
    return [*points[:quarter], *points[quarter:-quarter:2], *points[-quarter:]]


class Legs:
    """Finds the legs of one path, a point at a time.

    A leg begins where the path leaves significantly, and ends where it rests or has come back, or
    aside, from its farthest point significantly.
    """

    def __init__(self) -> None:
        self._recent: list[Point] = []
        self._leg: list[Point] = []
        self._reach = 0.0

    @property
    def begun(self) -> int | None:
        """Place at which the leg that is not over yet began; None at rest."""
        return self._leg[0].place if self._leg else None

    @property
    def places(self) -> set[int]:
        """Places at which a leg may begin or end yet."""
        return {point.place for point in (*self._recent, *self._leg)}

    def push(self, point: Point) -> list[Leg]:
        """Take in the next point and return the leg that it ends, if any."""
        self._recent = _thinned([*self._recent, point])
        if not self._leg:
            self._begin(point)
            return []
        first, far = self._leg[0], self._leg[-1]
        way, reached = point.at - far.at, _far(first, point)
        if float(way @ self._heading()) > 0 and reached > self._reach - significant(far, point):
            self._leg = _thinned([*self._leg, point])
            self._reach = max(self._reach, reached)
        elif np.linalg.norm(way) >= significant(far, point):
            closed = self._closed(after=far.place)
            self._begin(point)
            return [closed]
        return [self._closed()] if self._has_stalled(point.time_s) else []

    def finish(self) -> list[Leg]:
        """Return the leg that is not over."""
        return [self._closed()] if self._leg else []

    def _begin(self, point: Point) -> None:
        past = self._recent
        beyond = [_far(one, point) / max(significant(one, point), 1e-12) for one in past]
        start = int(np.argmax(beyond))
        if beyond[start] >= 1:
            self._leg, self._reach = past[start:], _far(past[start], point)

    def _closed(self, after: int | None = None) -> Leg:
        """End the leg; what follows its farthest point may begin the next one."""
        leg = self._trimmed()
        keep_from = leg.end if after is None else after
        self._recent = [past for past in self._recent if past.place >= keep_from]
        self._leg = []
        return leg

    def _trimmed(self) -> Leg:
        """Return the leg without what is no progress yet, or no more."""
        first, last = self._leg[0], self._leg[-1]
        way = last.at - first.at
        far = max(float(np.linalg.norm(way)), 1e-12)
        done = [float((past.at - first.at) @ way) / far for past in self._leg]
        edge = min(EDGE * SIGNIFICANT * last.floor, far / 4)
        begin = max(k for k, one in enumerate(done) if one <= edge)
        end = min(k for k, one in enumerate(done) if one >= far - edge)
        return Leg(self._leg[begin].place, self._leg[max(end, begin + 1)].place)

    def _heading(self) -> Floats:
        """Return the way the leg has gone lately, of length 1."""
        far = self._leg[-1]
        for past in reversed(self._leg[:-1]):
            if _far(past, far) >= significant(past, far):
                break
        else:
            past = self._leg[0]
        way = far.at - past.at
        return way / max(float(np.linalg.norm(way)), 1e-12)

    def _has_stalled(self, now_s: float) -> bool:
        first, last = self._leg[0], self._leg[-1]
        least, speed = significant(first, last), self._reach / max(now_s - first.time_s, 1e-9)
        # What creeps is given the time that it takes to go anywhere.
        window = max(REST_S, least / max(speed, 1e-12))
        earlier = [past for past in self._leg if past.time_s <= now_s - window]
        if not earlier:
            return False
        gained = float((last.at - earlier[-1].at) @ self._heading())
        return gained < max(RESTING * least, RESTING_SPEED * speed * window)


class EventKind(StrEnum):
    """The kinds of events."""

    TOUCH = "touch"
    """Contact begins; an instant."""
    PRESS = "press"
    """It goes deeper into the gel without a rest or a way back."""
    TURN = "turn"
    """It turns one way without a rest or a way back."""
    SLIDE = "slide"
    """Its contact travels one way, likewise."""
    STICK = "stick"
    """It is held for `STICK_S` or longer and neither turns nor slides."""
    SLIP = "slip"
    """A turn or a slide that sets in after a stick: the same frames as that event."""
    RELEASE = "release"
    """It is lifted off the gel, until contact ends if it does."""


MOVING = (EventKind.TURN, EventKind.SLIDE)

COMPONENT_OF = {
    EventKind.PRESS: Component.PRESS,
    EventKind.TURN: Component.TURN,
    EventKind.SLIDE: Component.SLIDE,
    EventKind.RELEASE: Component.PRESS,
}

STICK_S = 0.3

TOGETHER_S = 0.2
"""Events that begin or end no farther apart are told to do so in the same moment."""

TOUCH_S = 0.15
"""Time that contact must last to be a touch: a lamp, or a codec that starts sharp, is shorter."""

LEAK = 0.25
"""Share of a slide that may be read as a turn, as a path at the contact's radius, too."""

KEPT = 512
"""Moments kept at the least: more than a rest is looked back over."""


@dataclass(frozen=True)
class Event:
    """Something that happened."""

    kind: EventKind  # what
    begin: int  # frame number of its beginning, and likewise `end`
    end: int
    begin_s: float  # in seconds, and likewise `end_s`
    end_s: float
    twist: Twist  # the whole motion in this time, all components of it
    amount: Span  # of its own component, signed: degrees, pixels, mm; zero of a touch or a stick
    probability: float  # that it happened
    component: Component | None = None  # what of the motion it is of; None of a touch or a stick
    is_let_go: bool = False  # whether contact ends with it

    @property
    def motion(self) -> Motion:
        """Which of the ten words it is, in the recorded image."""
        if self.kind is EventKind.TOUCH:
            return Motion.PRESS
        if self.kind is EventKind.STICK:
            return Motion.STILL
        return self.twist.way(self.component)

    @property
    def seconds(self) -> float:
        """How long it took."""
        return self.end_s - self.begin_s


@dataclass(frozen=True, eq=False)
class Moment:
    """A frame as events are found in it."""

    place: int  # of the frame among those tracked, from 0
    number: int  # of the frame in the recording
    time_s: float  # when it was taken
    contact: float  # probability that something touches
    is_touched: bool  # whether something does; hysteresis keeps it from flickering
    way: Floats  # integrated motion since the first frame, (4,)
    doubt: Floats  # sum of the steps' covariances, (4, 4)
    radius_px: float  # of the contact


class EventFinder:
    """Turns moments into events, in the order in which they end."""

    def __init__(self) -> None:
        self._moments: dict[int, Moment] = {}
        self._legs: dict[Component, Legs] = {}
        self._touched: Moment | None = None
        self._last: Moment | None = None
        self._free_since = 0
        self._waiting: list[Event] = []

    def push(self, moment: Moment) -> list[Event]:
        """Take in the next frame and return the events that are over."""
        events: list[Event] = []
        self._moments[moment.place] = moment
        if moment.is_touched:
            if self._touched is None:
                self._touch(moment)
            for component, legs in self._legs.items():
                for leg in legs.push(_point(component, moment)):
                    self._waiting += self._over(component, leg)
            if moment.time_s - self._touched.time_s >= TOUCH_S:
                events, self._waiting = self._waiting, []
        elif self._touched is not None:
            events = self._closed(self._last, is_let_go=True)
        self._last = moment
        self._forget()
        return events

    def finish(self) -> list[Event]:
        """Return the events that the end of the recording cuts off."""
        return [] if self._touched is None else self._closed(self._last)

    def _touch(self, moment: Moment) -> None:
        self._touched, self._free_since = moment, moment.place
        self._legs = {component: Legs() for component in COMPONENTS}
        self._waiting = [self._event(EventKind.TOUCH, moment, moment)]

    def _stick(self, until: int) -> list[Event]:
        since, end = self._moments.get(self._free_since), self._moments.get(until)
        if since is None or end is None or end.time_s - since.time_s < STICK_S:
            return []
        self._free_since = until
        return [self._event(EventKind.STICK, since, end)]

    def _over(self, component: Component, leg: Leg) -> list[Event]:
        begin, end = self._moments[leg.begin], self._moments[leg.end]
        way = float((end.way - begin.way)[3])
        kinds = {Component.TURN: EventKind.TURN, Component.SLIDE: EventKind.SLIDE}
        kind = kinds.get(component, EventKind.PRESS if way > 0 else EventKind.RELEASE)
        moved = self._event(kind, begin, end, component)
        if not _is_significant(moved, begin, end):
            return []
        # A rest ends where the leg begins, or one that is not over yet.
        until = min([leg.begin, *self._moving_since()])
        stick = [] if component is Component.PRESS else self._stick(until)
        is_slip = stick and stick[0].end == begin.number
        slip = [self._event(EventKind.SLIP, begin, end, component)] if is_slip else []
        self._free_since = max(self._free_since, leg.end)
        return [*stick, moved, *slip]

    @property
    def going_on(self) -> dict[Component, int]:
        """Places at which legs begin that are not over yet."""
        begun = {component: legs.begun for component, legs in self._legs.items()}
        return {component: place for component, place in begun.items() if place is not None}

    def _moving_since(self) -> list[int]:
        """Return where the turn and the slide that are not over yet began."""
        begun = self.going_on
        return [begun[one] for one in (Component.TURN, Component.SLIDE) if one in begun]

    def _closed(self, last: Moment, *, is_let_go: bool = False) -> list[Event]:
        events, lifting, moving = [], None, self._moving_since()
        for component, legs in self._legs.items():
            for leg in legs.finish():
                over = self._over(component, leg)
                if is_let_go and over and over[0].kind is EventKind.RELEASE:
                    lifting = leg.begin
                    continue
                events += over
        if not moving:
            events += self._stick(last.place)
        if is_let_go:
            begin = last if lifting is None else self._moments[lifting]
            let_go = self._event(EventKind.RELEASE, begin, last, Component.PRESS)
            events.append(replace(let_go, is_let_go=True, probability=max(begin.contact, last.contact)))
        is_touch = last.time_s - self._touched.time_s >= TOUCH_S
        events, self._waiting = [*self._waiting, *events], []
        self._touched, self._legs = None, {}
        return events if is_touch else []

    def _event(
        self, kind: EventKind, begin: Moment, end: Moment, component: Component | None = None
    ) -> Event:
        way, own = end.way - begin.way, end.doubt - begin.doubt
        amount = Span(0.0, 0.0) if component is None else amount_of(component, way, own, end.radius_px)
        ends = (begin.number, end.number, begin.time_s, end.time_s)
        sure = max(begin.contact, end.contact)
        if component is not None:
            noise = noise_of(component, own, end.radius_px)
            sure *= math.erf(abs(amount.mean) / noise / math.sqrt(2))
        return Event(kind, *ends, Twist(*map(float, way)), amount, sure, component)

    def _forget(self) -> None:
        """Drop the moments that no event can begin or end at any more."""
        if len(self._moments) < 2 * KEPT:
            return
        held = {self._free_since}
        for legs in self._legs.values():
            held |= legs.places
        recent = sorted(self._moments)[-KEPT:]
        self._moments = {k: m for k, m in self._moments.items() if k >= recent[0] or k in held}


def _point(component: Component, moment: Moment) -> Point:
    part, place = COLUMNS[component], COMPONENTS.index(component)
    own = moment.doubt[part, part]
    variance = STEPS[place] ** 2 * float(np.trace(own)) / len(own)
    floor = floor_of(component, moment.radius_px)
    return Point(moment.place, moment.time_s, moment.way[part], variance, floor)


def _is_significant(moved: Event, begin: Moment, end: Moment) -> bool:
    """Tell whether a leg is more than noise, and a turn more than what a slide looks like."""
    noise = noise_of(moved.component, end.doubt - begin.doubt, end.radius_px)
    if moved.component is Component.TURN:
        leak = math.degrees(LEAK * moved.twist.slide_px / max(end.radius_px, 1.0))
        noise = math.hypot(noise, SPAN_DEVIATIONS / SIGNIFICANT * leak)
    return abs(moved.amount.mean) >= SIGNIFICANT * noise
