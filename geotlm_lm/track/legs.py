"""Legs of a path: stretches in which it goes one way, further than noise makes it.

They are found while the points come, some tenths of a second late: whether a motion is over, or
whether there is any, shows only afterwards.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SIGNIFICANT = 2.8
"""Deviations from which on a leg is a motion: of a bell one in a hundred lies beyond."""

REST_S = 0.24
"""Time without progress that ends a leg."""

RESTING, RESTING_SPEED = 0.4, 0.1
"""Progress at rest: share of what is significant, and share of the leg's own mean speed."""

EDGE = 0.15
"""Share of what is significant up to which a path is at its beginning yet."""

NEAR, FAR = 0.1, 0.25
"""Shares of a leg's way through which its beginning and its end are extrapolated."""

MOST_POINTS = 128
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
    """The places at which a leg begins and ends, and those from and to which it creeps besides."""

    begin: int
    end: int
    creeps_from: int
    creeps_to: int


def significant(before: Point, after: Point) -> float:
    """Return how far it is at the least from one point to another if that is no noise."""
    own = max(after.variance - before.variance, 0.0)
    return SIGNIFICANT * math.sqrt(after.floor**2 + own)


def _far(before: Point, after: Point) -> float:
    return math.hypot(*(after.at - before.at))


def _thinned(points: list[Point]) -> list[Point]:
    quarter = MOST_POINTS // 4
    if len(points) <= MOST_POINTS:
        return points
    return [*points[:quarter], *points[quarter:-quarter:2], *points[-quarter:]]


def timed(points: Sequence[Point]) -> Leg:
    """Return a leg with its times by its way in between, not by how it creeps at its ends."""
    first, last = points[0], points[-1]
    way = last.at - first.at
    done = np.array([float((past.at - first.at) @ way) for past in points])
    done = np.maximum.accumulate(done / max(float(way @ way), 1e-12))
    places = np.array([past.place for past in points], float)

    def extrapolated(near: float, far: float) -> int:
        # Places in the order of the way that is done, which only grows; the nearest one kept.
        at_near, at_far = np.interp([near, far], done, places)
        place = float(at_near - (at_far - at_near) * NEAR / (FAR - NEAR))
        return int(np.argmin(np.abs(places - place)))

    begin = min(extrapolated(NEAR, FAR), len(places) - 2)
    end = max(extrapolated(1 - NEAR, 1 - FAR), begin + 1)
    return Leg(int(places[begin]), int(places[end]), first.place, last.place)


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
            closed = self._closed()
            self._begin(point)
            return [closed]
        return [self._closed()] if self._has_stalled(point.time_s) else []

    def finish(self) -> list[Leg]:
        """Return the leg that is not over."""
        return [self._closed()] if self._leg else []

    def _begin(self, point: Point) -> None:
        past = self._recent
        ways = point.at - np.array([other.at for other in past])
        own = point.variance - np.array([other.variance for other in past])
        least = SIGNIFICANT * np.sqrt(point.floor**2 + own.clip(min=0)) + 1e-12
        beyond = np.sqrt(np.square(ways).sum(axis=1)) / least
        start = int(np.argmax(beyond))
        if beyond[start] < 1:
            return
        self._reach = _far(past[start], point)
        heading = (point.at - past[start].at) / max(self._reach, 1e-12)
        edge = min(EDGE * SIGNIFICANT * point.floor, self._reach / 2)
        done = [float((other.at - past[start].at) @ heading) for other in past[start:]]
        self._leg = past[start + max(k for k, far in enumerate(done) if far <= edge) :]

    def _closed(self) -> Leg:
        """End the leg; what follows its farthest point may begin the next one."""
        leg = timed(self._leg)
        self._recent = [past for past in self._recent if past.place >= leg.creeps_to]
        self._leg = []
        return leg

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
