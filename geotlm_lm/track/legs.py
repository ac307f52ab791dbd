"""Where a noisy path goes one way: its legs, between rests and ways back, found as it comes."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LOOK_BACK_S = 1.0
"""Time in which a path must leave its place by the least way: what creeps more slowly rests."""

REST_S = 0.24
"""Time without progress that ends a leg."""

EDGE = 0.15
"""Share of the least way up to which a path is at its beginning, and from its end on at its end."""


NEAR, FAR = 0.1, 0.25
"""Shares of a leg's way through which its beginning and its end are extrapolated."""


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

    Args:
        least: The least way.
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
            self._thin()
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
        apart = [float(np.linalg.norm(point.at - one.at)) for one in self._recent]
        start = int(np.argmax(apart)) if apart else 0
        if not apart or apart[start] < self._least:
            return
        recent = list(self._recent)
        heading = (point.at - recent[start].at) / apart[start]
        progress = [float((one.at - recent[start].at) @ heading) for one in recent[start:]]
        near = [k for k, far in enumerate(progress) if far <= EDGE * self._least]
        self._leg = recent[start + near[-1] :]

    def _closed(self, after: int | None = None) -> Leg:
        """End the leg; what follows its farthest point may begin the next one."""
        leg = self._trimmed()
        keep_from = leg.end if after is None else after
        self._recent = deque(one for one in self._recent if one.place >= keep_from)
        self._leg = []
        return leg

    def _trimmed(self) -> Leg:
        """Return the leg without the creeping before and after it.

        Where it is a tenth and a quarter under way, in a line, tells where it began and ended.
        """
        first, last = self._leg[0], self._leg[-1]
        way = last.at - first.at
        done = np.array([float((one.at - first.at) @ way) for one in self._leg])
        done = np.maximum.accumulate(done / max(float(way @ way), 1e-12))
        places = np.array([one.place for one in self._leg], float)

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
        for one in reversed(self._leg[:-1]):
            way = far - one.at
            length = float(np.linalg.norm(way))
            if length >= self._least:
                return way / length
        way = far - self._leg[0].at
        return way / max(float(np.linalg.norm(way)), 1e-12)

    def _has_stalled(self, now_s: float) -> bool:
        earlier = [one for one in self._leg if one.time_s <= now_s - REST_S]
        if not earlier:
            return False
        gained = float((self._leg[-1].at - earlier[-1].at) @ self._heading())
        return gained < EDGE * self._least

    def _thin(self) -> None:
        """Forget the middle of a long leg: only its beginning and its recent part are looked at."""
        if len(self._leg) > MOST_POINTS:
            self._leg = [self._leg[0], *self._leg[-MOST_POINTS // 2 :]]


MOST_POINTS = 256
