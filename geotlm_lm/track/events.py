"""What happens in a track: touch, press, turn, slide, stick, slip, release; all defined here.

Each component of the way is cut into legs, which go one way between rests and ways back; a leg that
is no noise is an event, however short it is.
"""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, Component, Twist
from geotlm_lm.motion.belief import SPAN_DEVIATIONS
from geotlm_lm.track.legs import SIGNIFICANT, Leg, Legs, Point, timed

Floats = NDArray[np.float64]

SURE_SHARE, UNSURE_SHARE, MOST_SHARE = 0.05, 0.16, 0.3
"""Share of a turn that is doubted where kept frames agree on it, where there are only steps, and
where neither tells much."""

SYSTEMATIC = (UNSURE_SHARE, 0.16, 0.25)
"""Share of a turn, a slide and a press that is doubted beside what is measured step by step: what
the pad holds back, it holds back in every step. Of a turn less where kept frames agree on it."""

FLOOR_PX, FLOOR_MM = 0.2, 0.06
"""Deviation of any leg, however short: of a turn as a path at the contact's radius."""

STEPS = (0.15, 0.2, 0.45)
"""Deviation of a turn's, a slide's and a press's leg per formal one of its steps. Key frames keep
the steps' errors from adding up, the model's belief of a depth does not: 59 real imprints held for
1.7 s over their own idle frames wander by 0.11, 0.12 and 0.26 formal ones (median), 0.21, 0.27 and
1.1 in 95 of 100."""

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

    @property
    def is_clear(self) -> bool:
        """Whether it keeps off zero."""
        return self.low > 0 or self.high < 0

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


def chance_of_moving(amount: float, noise: float) -> float:
    """Return how probable it is that a leg is no noise, given its amount and the noise's spread."""
    return math.erf(abs(amount) / max(noise, 1e-9) / math.sqrt(2))


def floor_of(component: Component, radius_px: float) -> float:
    """Return the deviation of a leg of no length, in the component's unit."""
    if component is Component.TURN:
        return math.degrees(FLOOR_PX / max(radius_px, 1.0))
    return FLOOR_PX if component is Component.SLIDE else FLOOR_MM


def doubted_share(turned_deg: Floats, doubted_deg: Floats) -> Floats:
    """Return the share of turns that is doubted, given what was turned there and back, and of it.

    All are of one shape; where nothing turned it is that of steps alone.
    """
    known = doubted_deg / np.maximum(turned_deg, 1e-9)
    return np.where(turned_deg > 0, known, UNSURE_SHARE)


def amount_of(
    component: Component,
    twist: Floats,
    covariance: Floats,
    radius_px: float,
    turn_share: float = UNSURE_SHARE,
) -> Span:
    """Return how far a component goes in a twist (4,) with the covariance (4, 4) of its steps.

    The last is the share of a turn that is doubted.
    """
    way = twist[COLUMNS[component]]
    far = float(np.linalg.norm(way))
    is_turn = component is Component.TURN
    systematic = far * (turn_share if is_turn else SYSTEMATIC[COMPONENTS.index(component)])
    deviation = math.hypot(noise_of(component, covariance, radius_px), systematic)
    return Span(far if component is Component.SLIDE else float(way[0]), deviation)


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
"""Share of a slide that may be read as a turn, as a path at the contact's radius, and of a turn as
a slide: step by step of either, and of all of a slide."""

LEAK_PER_NOISE = LEAK * SPAN_DEVIATIONS / SIGNIFICANT
"""The same as a deviation: a turn is told from `SIGNIFICANT` of them on."""

PRESS_LEAK_PX_PER_MM = 1.2
"""Deviation of the slide that is read of a press: of 34 simulated presses and lifts in place the
median reads 0.95 pixels per mm, nine in ten less than `SIGNIFICANT` times this."""

CHOSEN, MOST_OF_LEG = 2, 0.5
"""How many times as far a part of a leg must turn that is chosen among all its parts, none of them
a jerk, and what share of the leg it must be."""

JERK_S = 0.13
"""Time below which a leg may be a step that was measured wrong: it must go twice as far."""

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
    # numbers of the frames from and to which it creeps besides; the amount is that of all of it
    creeps: tuple[int, int] | None = None
    is_readable: bool = True  # whether the pictures tell how far it goes

    @property
    def motion(self) -> Motion:
        """Which of the ten words it is, in the recorded image."""
        if self.kind is EventKind.TOUCH:
            return Motion.PRESS
        if self.kind is EventKind.STICK:
            return Motion.STILL
        return self.twist.way(self.component)

    @property
    def is_of_contact(self) -> bool:
        """Whether nobody can tell it who does not know the untouched gel."""
        return self.kind not in MOVING

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
    # degrees turned there and back so far, and what of them is doubted
    turned_deg: tuple[float, float] = (0.0, 0.0)


class EventFinder:
    """Turns moments into events, in the order in which they end."""

    def __init__(self) -> None:
        self._moments: dict[int, Moment] = {}
        self._legs: dict[Component, Legs] = {}
        self._touched: Moment | None = None
        self._last: Moment | None = None
        self._free_since, self._surest, self._leaked = 0, 0.0, np.zeros(len(COMPONENTS))
        self._waiting: list[Event] = []

    def copied(self) -> EventFinder:
        """Return another that goes on from here; moments and points are shared, none changes."""
        other = copy(self)
        other._moments, other._waiting = dict(self._moments), [*self._waiting]
        other._legs = {component: copy(legs) for component, legs in self._legs.items()}
        return other

    def push(self, moment: Moment) -> list[Event]:
        """Take in the next frame and return the events that are over."""
        events: list[Event] = []
        self._moments[moment.place] = moment
        if moment.is_touched:
            if self._touched is None:
                self._touch(moment)
            self._surest = max(self._surest, moment.contact)
            if self._last is not None and self._last.is_touched:
                self._leaked = self._leaked + _leaked(self._last, moment)
            for component, legs in self._legs.items():
                for leg in legs.push(_point(component, moment, self._leaked)):
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
        self._touched, self._free_since, self._surest = moment, moment.place, 0.0
        self._legs = {component: Legs() for component in COMPONENTS}
        self._waiting = [self._event(EventKind.TOUCH, moment, moment)]

    def _stick(self, until: int) -> list[Event]:
        since, end = self._moments.get(self._free_since), self._moments.get(until)
        if since is None or end is None or end.time_s - since.time_s < STICK_S:
            return []
        self._free_since = until
        return [self._event(EventKind.STICK, since, end)]

    def _over(self, component: Component, leg: Leg) -> list[Event]:
        first, last = self._moments[leg.creeps_from], self._moments[leg.creeps_to]
        begin, end = self._moments[leg.begin], self._moments[leg.end]
        kinds = {Component.TURN: EventKind.TURN, Component.SLIDE: EventKind.SLIDE}
        is_deeper = last.way[3] > first.way[3]
        kind = kinds.get(component, EventKind.PRESS if is_deeper else EventKind.RELEASE)
        moved = self._event(kind, first, last, component)
        if not _is_significant(moved, first, last):
            apart = self._apart_from_slides(leg) if component is Component.TURN else None
            return [] if apart is None else self._over(component, apart)
        moved = replace(moved, begin=begin.number, end=end.number, begin_s=begin.time_s,
                        end_s=end.time_s, creeps=(first.number, last.number))  # fmt: skip
        # A rest ends where the leg begins, or one that is not over yet.
        until = min([leg.begin, *self._moving_since()])
        stick = self._stick(until)
        is_slip = kind in MOVING and stick and stick[0].end == begin.number
        slip = [replace(moved, kind=EventKind.SLIP)] if is_slip else []
        self._free_since = max(self._free_since, leg.end)
        return [*stick, moved, *slip]

    def _apart_from_slides(self, leg: Leg) -> Leg | None:
        """Return the part of a turn that goes farthest beyond what its slide looks like, if any.

        What slides, turns and slides on is one leg of turning where a slide looks like some of it.
        """
        moments = [self._moments[k] for k in sorted(self._moments)
                   if leg.creeps_from <= k <= leg.creeps_to]  # fmt: skip
        turns, rights, downs, _ = np.array([moment.way for moment in moments]).T
        doubts = np.array([moment.doubt[0, 0] for moment in moments])
        radii = np.maximum([moment.radius_px for moment in moments], 1.0)
        turned = (turns - turns[:, None]) * np.sign(turns[-1] - turns[0])
        slides = np.hypot(rights - rights[:, None], downs - downs[:, None])
        own = STEPS[0] ** 2 * (doubts - doubts[:, None]).clip(min=0)
        looks = np.degrees(LEAK_PER_NOISE * slides / radii)
        noise = np.sqrt(np.degrees(FLOOR_PX / radii) ** 2 + own + looks**2)
        times_s = np.array([moment.time_s for moment in moments])
        is_most = (turned >= MOST_OF_LEG * turned[0, -1]) & (times_s - times_s[:, None] >= JERK_S)
        beyond = np.where(is_most, turned - CHOSEN * SIGNIFICANT * noise, -1.0)
        begin, end = np.unravel_index(np.argmax(beyond), beyond.shape)
        if beyond[begin, end] < 0:
            return None
        points = [_point(Component.TURN, moment, self._leaked) for moment in moments]
        part = timed(points[begin : end + 1])
        is_whole = (part.creeps_from, part.creeps_to) == (leg.creeps_from, leg.creeps_to)
        return None if is_whole else part

    @property
    def way_going_on(self) -> Floats:
        """Way of the legs that are not over yet, (4,)."""
        way = np.zeros(4)
        for component, place in self.going_on.items():
            part = COLUMNS[component]
            way[part] = self._last.way[part] - self._moments[place].way[part]
        return way

    @property
    def going_on(self) -> dict[Component, int]:
        """Places at which legs begin that are not over yet."""
        begun = {component: legs.begun for component, legs in self._legs.items()}
        return {component: place for component, place in begun.items() if place is not None}

    def _moving_since(self) -> list[int]:
        """Return where the turn and the slide that are not over yet began."""
        begun = self.going_on
        return [begun[part] for part in (Component.TURN, Component.SLIDE) if part in begun]

    def _closed(self, last: Moment, *, is_let_go: bool = False) -> list[Event]:
        events, lifting = [], None
        for component, legs in self._legs.items():
            for leg in legs.finish():
                over = self._over(component, leg)
                if is_let_go and over and over[-1].kind is EventKind.RELEASE:
                    lifting = over.pop()
                events += over
        events += self._stick(last.place)
        if is_let_go:
            events.append(self._let_go(last, lifting))
        is_touch = last.time_s - self._touched.time_s >= TOUCH_S
        events, self._waiting = [*self._waiting, *events], []
        self._touched, self._legs = None, {}
        return events if is_touch else []

    def _let_go(self, last: Moment, lifting: Event | None) -> Event:
        """Return the release that contact ends with, and that lifts it if that was seen."""
        let_go = lifting or self._event(EventKind.RELEASE, last, last, Component.PRESS)
        ends = {"end": last.number, "end_s": last.time_s, "is_let_go": True}
        return replace(let_go, **ends, probability=self._surest)

    def _event(
        self, kind: EventKind, begin: Moment, end: Moment, component: Component | None = None
    ) -> Event:
        way, own = end.way - begin.way, end.doubt - begin.doubt
        amount = Span(0.0, 0.0)
        if component is not None and begin is not end:
            share = doubted_share(*np.subtract(end.turned_deg, begin.turned_deg))
            amount = amount_of(component, way, own, end.radius_px, float(share))
        ends = (begin.number, end.number, begin.time_s, end.time_s)
        sure = max(begin.contact, end.contact)
        if component is not None:
            sure *= chance_of_moving(amount.mean, noise_of(component, own, end.radius_px))
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


def _leaked(before: Moment, moment: Moment) -> Floats:
    """Return the variance of what a step's slide is read as a turn, its turn as a slide, (3,)."""
    radius = max(moment.radius_px, 1.0)
    turn, right, down, _ = moment.way - before.way
    as_turn, as_slide = math.hypot(right, down) / radius, math.radians(turn) * radius
    return np.square(LEAK * np.array([math.degrees(as_turn), as_slide, 0.0]))


def _point(component: Component, moment: Moment, leaked: Floats) -> Point:
    part, place = COLUMNS[component], COMPONENTS.index(component)
    own = moment.doubt[part, part]
    variance = STEPS[place] ** 2 * float(np.trace(own)) / len(own) + leaked[place]
    floor = floor_of(component, moment.radius_px)
    return Point(moment.place, moment.time_s, moment.way[part], float(variance), floor)


def _is_significant(moved: Event, begin: Moment, end: Moment) -> bool:
    """Tell whether a leg is more than noise.

    Of a turn more than what its slide looks like, of a slide than what its press does.
    """
    noise = noise_of(moved.component, end.doubt - begin.doubt, end.radius_px)
    if moved.component is Component.TURN:
        leak = LEAK_PER_NOISE * moved.twist.slide_px / max(end.radius_px, 1.0)
        noise = math.hypot(noise, math.degrees(leak))
    elif moved.component is Component.SLIDE:
        noise = math.hypot(noise, PRESS_LEAK_PX_PER_MM * moved.twist.inward_mm)
    is_jerk = end.time_s - begin.time_s < JERK_S
    return abs(moved.amount.mean) >= SIGNIFICANT * noise * (2 if is_jerk else 1)
