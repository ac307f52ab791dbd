"""What happens in a track: touch, press, turn, slide, stick, slip, release; all defined here.

Events are found while the frames come, some tenths of a second late: whether a motion is over, or
whether it counts at all, shows only afterwards. Each component of the way is cut into legs, which
go one way between rests and ways back; a leg that goes far enough is an event.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, STILL_MM, STILL_PX, Component, Twist

Floats = NDArray[np.float64]

SPAN_DEVIATIONS = 1.645
"""Deviations either side that hold nine tenths of a bell."""

SYSTEMATIC = (0.16, 0.16, 0.25)
"""Share of a net turn, slide and press that is doubted beside what is measured step by step: what
the pad holds back, it holds back in every step. Of 68 recordings that things are chosen by spans of
nine in ten then hold the net turn in 0.93; with a tenth in 0.82."""

ENDS = (0.8, 0.6, 0.06)
"""Deviation of any span, however short: degrees, pixels, mm."""

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


def amount_of(component: Component, twist: Floats, covariance: Floats) -> Span:
    """Return how far a component goes in a twist (4,) with the covariance (4, 4) of its steps."""
    part, place = COLUMNS[component], COMPONENTS.index(component)
    way, own = twist[part], covariance[part, part]
    far = float(np.linalg.norm(way))
    along = way / far if far > 0 else np.eye(len(way))[0]
    doubt = math.hypot(SYSTEMATIC[place] * far, ENDS[place])
    deviation = math.sqrt(float(along @ own @ along) + doubt**2)
    return Span(far if component is Component.SLIDE else float(way[0]), deviation)


LOOK_BACK_S = 1.0
"""Time in which a path must leave its place by the least way: what creeps more slowly rests."""

REST_S = 0.24
"""Time without progress that ends a leg."""

EDGE = 0.15
"""Share of the least way up to which a path is at its beginning, and from its end on at its end."""

NEAR, FAR = 0.1, 0.25
"""Shares of a leg's way through which its beginning and its end are extrapolated."""

MOST_POINTS = 256
"""Of a leg that are kept: its beginning and its recent part are all that is looked at."""


@dataclass(frozen=True, eq=False)
class Point:
    """A place of the path: which it is, when, and where, (d,)."""

    place: int
    time_s: float
    at: Floats


@dataclass(frozen=True)
class Leg:
    """The places at which a leg begins and ends."""

    begin: int
    end: int


class Legs:
    """Finds the legs of one path, a point at a time.

    A leg begins where the path leaves the place it was at by the least way, and ends where it rests
    or has come back, or aside, from its farthest point by as much.
    """

    def __init__(self, least: float) -> None:
        self._least = least
        self._recent: deque[Point] = deque()
        self._leg: list[Point] = []

    @property
    def begun(self) -> int | None:
        """Place at which the leg that is not over yet began; None at rest."""
        return self._leg[0].place if self._leg else None

    def push(self, point: Point) -> list[Leg]:
        """Take in the next point and return the leg that it ends, if any."""
        self._recent.append(point)
        while point.time_s - self._recent[0].time_s > LOOK_BACK_S:
            self._recent.popleft()
        if not self._leg:
            self._begin(point)
            return []
        far = self._leg[-1]
        way = point.at - far.at
        ahead = float(way @ self._heading())
        if ahead > 0:
            self._leg.append(point)
            if len(self._leg) > MOST_POINTS:
                self._leg = [self._leg[0], *self._leg[-MOST_POINTS // 2 :]]
            return [self._closed()] if self._has_stalled(point.time_s) else []
        if np.linalg.norm(way) >= self._least:
            closed = self._closed(after=far.place)
            self._begin(point)
            return [closed]
        return [self._closed()] if self._has_stalled(point.time_s) else []

    def finish(self) -> list[Leg]:
        """Return the leg that is not over."""
        return [self._closed()] if self._leg else []

    def _begin(self, point: Point) -> None:
        apart = [float(np.linalg.norm(point.at - past.at)) for past in self._recent]
        start = int(np.argmax(apart)) if apart else 0
        if not apart or apart[start] < self._least:
            return
        recent = list(self._recent)
        heading = (point.at - recent[start].at) / apart[start]
        progress = [float((past.at - recent[start].at) @ heading) for past in recent[start:]]
        near = [k for k, far in enumerate(progress) if far <= EDGE * self._least]
        self._leg = recent[start + near[-1] :]

    def _closed(self, after: int | None = None) -> Leg:
        """End the leg; what follows its farthest point may begin the next one."""
        leg = self._trimmed()
        keep_from = leg.end if after is None else after
        self._recent = deque(past for past in self._recent if past.place >= keep_from)
        self._leg = []
        return leg

    def _trimmed(self) -> Leg:
        """Return the leg without the creeping before and after it, by its way in between."""
        first, last = self._leg[0], self._leg[-1]
        way = last.at - first.at
        done = np.array([float((past.at - first.at) @ way) for past in self._leg])
        done = np.maximum.accumulate(done / max(float(way @ way), 1e-12))
        places = np.array([past.place for past in self._leg], float)

        def extrapolated(near: float, far: float) -> int:
            # Places in the order of the way that is done, which only grows.
            at_near, at_far = np.interp([near, far], done, places)
            return round(float(at_near - (at_far - at_near) * NEAR / (FAR - NEAR)))

        begin = min(max(extrapolated(NEAR, FAR), first.place), last.place - 1)
        end = min(max(extrapolated(1 - NEAR, 1 - FAR), begin + 1), last.place)
        return Leg(begin, end)

    def _heading(self) -> Floats:
        """Return the way the leg has gone lately, of length 1."""
        far = self._leg[-1].at
        for past in reversed(self._leg[:-1]):
            way = far - past.at
            length = float(np.linalg.norm(way))
            if length >= self._least:
                return way / length
        way = far - self._leg[0].at
        return way / max(float(np.linalg.norm(way)), 1e-12)

    def _has_stalled(self, now_s: float) -> bool:
        earlier = [past for past in self._leg if past.time_s <= now_s - REST_S]
        if not earlier:
            return False
        gained = float((self._leg[-1].at - earlier[-1].at) @ self._heading())
        return gained < EDGE * self._least


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

LEAST_DEG, LEAST_TURN_PX, LEAST_SLIDE_PX, LEAST_MM = 2.5, 1.5, 2.0, 0.15
"""Way without which a turn (in degrees, and as a path at the contact's radius), a slide or a press
is no event: between the noise of a held object's track and what `core.twist` counts."""

LEAK = 0.25
"""Share of a slide that may be read as a turn, as a path at the contact's radius, too."""

KEPT = 512
"""Moments kept at the least: more than a rest is looked back over."""

JERK_S = 0.13
"""Time below which a turn may be a step that was measured wrong: it must go twice as far."""


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
        self._free_since, self._least_deg = 0, LEAST_DEG
        self._waiting: list[Event] = []

    def push(self, moment: Moment) -> list[Event]:
        """Take in the next frame and return the events that are over."""
        events: list[Event] = []
        self._moments[moment.place] = moment
        if moment.is_touched:
            if self._touched is None:
                self._touch(moment)
            for component, legs in self._legs.items():
                point = Point(moment.place, moment.time_s, moment.way[COLUMNS[component]])
                for leg in legs.push(point):
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
        least = math.degrees(LEAST_TURN_PX / max(moment.radius_px, 1.0))
        self._least_deg = max(LEAST_DEG, least)
        self._legs = {
            Component.TURN: Legs(self._least_deg),
            Component.SLIDE: Legs(LEAST_SLIDE_PX),
            Component.PRESS: Legs(LEAST_MM),
        }
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
        if kind is EventKind.TURN and not self._is_sure(moved, end.radius_px):
            return []
        # A rest ends where the leg begins, or one that is not over yet.
        until = min([leg.begin, *self._moving_since()])
        stick = [] if component is Component.PRESS else self._stick(until)
        is_slip = stick and stick[0].end == begin.number
        slip = [self._event(EventKind.SLIP, begin, end, component)] if is_slip else []
        self._free_since = max(self._free_since, leg.end)
        return [*stick, moved, *slip]

    def _is_sure(self, turn: Event, radius_px: float) -> bool:
        """Tell whether a turn is more than what a slide or a step gone wrong may look like."""
        leak = math.degrees(LEAK * turn.twist.slide_px / max(radius_px, 1.0))
        doubt = SPAN_DEVIATIONS * math.hypot(turn.amount.deviation, leak)
        least = self._least_deg * (2 if turn.seconds < JERK_S else 1)
        return abs(turn.amount.mean) > max(doubt, least)

    def _moving_since(self) -> list[int]:
        """Return where the turn and the slide that are not over yet began."""
        legs = (self._legs[component].begun for component in (Component.TURN, Component.SLIDE))
        return [begun for begun in legs if begun is not None]

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
            events.append(self._event(EventKind.RELEASE, begin, last, Component.PRESS))
        is_touch = last.time_s - self._touched.time_s >= TOUCH_S
        events, self._waiting = [*self._waiting, *events], []
        self._touched, self._legs = None, {}
        return events if is_touch else []

    def _event(
        self, kind: EventKind, begin: Moment, end: Moment, component: Component | None = None
    ) -> Event:
        way, own = end.way - begin.way, end.doubt - begin.doubt
        amount = Span(0.0, 0.0) if component is None else amount_of(component, way, own)
        ends = (begin.number, end.number, begin.time_s, end.time_s)
        sure = self._probability(kind, amount, begin, end)
        return Event(kind, *ends, Twist(*map(float, way)), amount, sure, component)

    def _probability(self, kind: EventKind, amount: Span, begin: Moment, end: Moment) -> float:
        contact = max(begin.contact, end.contact)
        if kind not in COMPONENT_OF or kind is EventKind.RELEASE:
            return contact
        still = {
            EventKind.TURN: math.degrees(STILL_PX / max(end.radius_px, 1.0)),
            EventKind.SLIDE: STILL_PX,
            EventKind.PRESS: STILL_MM,
        }[kind]
        beyond = (abs(amount.mean) - still) / max(amount.deviation, 1e-6)
        return contact * 0.5 * (1 + math.erf(beyond / math.sqrt(2)))

    def _forget(self) -> None:
        """Drop the moments that no event can begin or end at any more."""
        if len(self._moments) < 2 * KEPT:
            return
        begun = [legs.begun for legs in self._legs.values() if legs.begun is not None]
        held = {*begun, self._free_since}
        recent = sorted(self._moments)[-KEPT:]
        self._moments = {k: m for k, m in self._moments.items() if k >= recent[0] or k in held}
