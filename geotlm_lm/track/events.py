"""What happens in a track: touch, press, turn, slide, stick, slip, release; all defined here.

Events are found while the frames come, some tenths of a second late: whether a motion is over, or
whether it counts at all, shows only afterwards.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import STILL_MM, STILL_PX, Component, Twist
from geotlm_lm.track.amounts import COLUMNS, SPAN_DEVIATIONS, Span, amount_of
from geotlm_lm.track.legs import Leg, Legs, Point

Floats = NDArray[np.float64]


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

JERK_S = 0.13
"""Time below which a turn may be a step that was measured wrong: it must go twice as far."""


@dataclass(frozen=True)
class Event:
    """Something that happened.

    Args:
        kind: What.
        begin: Frame number of its beginning.
        end: Frame number of its end.
        begin_s: Its beginning in seconds.
        end_s: Its end.
        twist: The whole motion in this time, all components of it.
        amount: Of its own component, signed: degrees, pixels, mm; zero of a touch or a stick.
        probability: That it happened.
        component: What of the motion it is of; None of a touch or a stick.
    """

    kind: EventKind
    begin: int
    end: int
    begin_s: float
    end_s: float
    twist: Twist
    amount: Span
    probability: float
    component: Component | None = None

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
    """A frame as events are found in it.

    Args:
        place: Of the frame among those tracked, from 0.
        number: Of the frame in the recording.
        time_s: When it was taken.
        contact: Probability that something touches.
        is_touched: Whether something does; hysteresis keeps it from flickering.
        way: Integrated motion since the first frame, (4,).
        doubt: Sum of the steps' covariances, (4, 4).
        radius_px: Of the contact.
    """

    place: int
    number: int
    time_s: float
    contact: float
    is_touched: bool
    way: Floats
    doubt: Floats
    radius_px: float


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
            self._waiting += self._moved(moment)
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

    def _moved(self, moment: Moment) -> list[Event]:
        events = []
        for component, legs in self._legs.items():
            point = Point(moment.place, moment.time_s, moment.way[COLUMNS[component]])
            closed = legs.push(point)
            events += [one for leg in closed for one in self._over(component, leg)]
        return events

    def _stick(self, until: int) -> list[Event]:
        since, end = self._at(self._free_since), self._at(until)
        if since is None or end is None or end.time_s - since.time_s < STICK_S:
            return []
        self._free_since = until
        return [self._event(EventKind.STICK, since, end)]

    def _over(self, component: Component, leg: Leg) -> list[Event]:
        begin, end = self._at(leg.begin), self._at(leg.end)
        way = float((end.way - begin.way)[3])
        kinds = {Component.TURN: EventKind.TURN, Component.SLIDE: EventKind.SLIDE}
        kind = kinds.get(component, EventKind.PRESS if way > 0 else EventKind.RELEASE)
        moved = self._event(kind, begin, end, component)
        if kind is EventKind.TURN and not self._is_sure(moved, end.radius_px):
            return []
        stick = [] if component is Component.PRESS else self._stick(self._resting_until(leg.begin))
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

    def _resting_until(self, begin: int) -> int:
        """Return when a rest ended: at the beginning of a leg, or of one that is not over yet."""
        others = (self._legs[one].begun for one in (Component.TURN, Component.SLIDE))
        return min([begin, *(one for one in others if one is not None)])

    def _closed(self, last: Moment, *, is_let_go: bool = False) -> list[Event]:
        events, lifting = [], None
        moving = any(self._legs[one].begun is not None for one in (Component.TURN, Component.SLIDE))
        for component, legs in self._legs.items():
            for leg in legs.finish():
                told = self._over(component, leg)
                if is_let_go and told and told[0].kind is EventKind.RELEASE:
                    lifting = leg.begin
                    continue
                events += told
        if not moving:
            events += self._stick(last.place)
        if is_let_go:
            begin = last if lifting is None else self._at(lifting)
            events.append(self._event(EventKind.RELEASE, begin, last, Component.PRESS))
        is_touch = last.time_s - self._touched.time_s >= TOUCH_S
        events, self._waiting = [*self._waiting, *events], []
        self._touched, self._legs = None, {}
        return events if is_touch else []

    def _at(self, place: int) -> Moment | None:
        return self._moments.get(place)

    def _event(
        self, kind: EventKind, begin: Moment, end: Moment, component: Component | None = None
    ) -> Event:
        twist, own = end.way - begin.way, end.doubt - begin.doubt
        amount = Span(0.0, 0.0) if component is None else amount_of(component, twist, own)
        return Event(
            kind,
            begin.number,
            end.number,
            begin.time_s,
            end.time_s,
            Twist(*map(float, twist)),
            amount,
            self._probability(kind, amount, begin, end),
            component,
        )

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


KEPT = 512
"""Moments kept at the least: more than a rest is looked back over."""
