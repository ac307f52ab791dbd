"""The motion of a whole recording as one value, which every question about it starts from.

Axes, signs and units are those of `core.twist`: clockwise, right, down and into the gel positive;
degrees, pixels of the 224-pixel square, mm. Travel is that of the middle of the contact.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.errors import UsageError, require_inside
from geotlm_lm.core.twist import Component, Twist
from geotlm_lm.track.amounts import COLUMNS, ENDS, SYSTEMATIC, Span, amount_of
from geotlm_lm.track.events import Event, EventKind

Floats = NDArray[np.float64]

SPEED_S = 0.2
"""Time over which a speed is measured: less is noise."""


@dataclass(frozen=True, eq=False)
class Track:
    """What touched when and how it moved, frame by frame.

    Args:
        numbers: Where each frame stood in the recording, from 0, int64 (n,).
        times_s: When it was taken, seconds, (n,), rising.
        contact: Probability that something touches, (n,).
        strength_grey: Strength of the imprint, grey levels (rms), (n,).
        twists: Motion from the frame before to each frame: turn, right, down, inward, (n, 4); zeros
            in the first and wherever nothing touches.
        covariances: What each step adds to the doubt of the way, (n, 4, 4).
        radius_px: Radius of the contact, (n,); 0 where nothing touches.
        events: What happened, by when it began.
        frame_size: Rows and columns of the recording's frames.
        notes: What was found amiss, one sentence each.
    """

    numbers: NDArray[np.int64]
    times_s: Floats
    contact: Floats
    strength_grey: Floats
    twists: Floats
    covariances: Floats
    radius_px: Floats
    events: tuple[Event, ...]
    frame_size: tuple[int, int]
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.numbers)

    @property
    def seconds(self) -> float:
        """Time from the first frame to the last."""
        return float(self.times_s[-1] - self.times_s[0]) if len(self) else 0.0

    @property
    def path_from_start(self) -> Floats:
        """Integrated signed motion since the first frame: turn, right, down, inward, (n, 4)."""
        return np.cumsum(self.twists, axis=0)

    @property
    def path_deviations(self) -> Floats:
        """Deviations of the same, (n, 4)."""
        own = np.cumsum(np.diagonal(self.covariances, axis1=1, axis2=2), axis=0)
        return np.sqrt(own + np.square(_SYSTEMATIC_OF * self.path_from_start))

    @property
    def is_touched(self) -> NDArray[np.bool_]:
        """Whether something more probably touches than not, (n,)."""
        return self.contact >= TOUCHED

    def between(self, first: float, last: float, *, unit: str = "frames") -> Track:
        """Return the track of a span, both ends included; its motion starts at rest at `first`.

        Args:
            first: Frame number or second.
            last: Likewise, after `first`.
            unit: "frames" or "s".

        Raises:
            UsageError: If frames are asked for that are not inside the recording, or the span holds
                no two that were followed.
        """
        scale = self.numbers if unit == "frames" else self.times_s
        if unit == "frames":
            require_inside(first, last, int(scale[0]), int(scale[-1]))
        inside = np.flatnonzero((scale >= first) & (scale <= last))
        if len(inside) < 2:
            raise UsageError(
                f"The span {first:g} to {last:g} {unit} holds fewer than two frames, the recording "
                f"goes from {scale[0]:g} to {scale[-1]:g}; give a longer span inside it."
            )
        part = slice(int(inside[0]), int(inside[-1]) + 1)
        arrays = {name: getattr(self, name)[part] for name in _ARRAYS}
        twists, covariances = arrays["twists"].copy(), arrays["covariances"].copy()
        twists[0], covariances[0] = 0, 0
        arrays |= {"twists": twists, "covariances": covariances}
        cut = replace(self, **arrays, events=())
        return replace(cut, events=tuple(cut._inside(event) for event in self._overlapping(cut)))

    def net(self, component: Component) -> Span:
        """Return how far it went from the first frame to the last, there less back.

        A turn is clockwise positive, a press inward; a slide is the length of `net_twist`.
        """
        twist, own = self.twists.sum(axis=0), self.covariances.sum(axis=0)
        return amount_of(component, twist, own)

    @property
    def net_twist(self) -> Twist:
        """The motion from the first frame to the last."""
        return Twist(*map(float, self.twists.sum(axis=0)))

    def path(self, component: Component) -> Span:
        """Return how far it went there and back, all together: the sum of its events' ways.

        What is less than an event does not count: the noise of a gel at rest adds up to any path.
        """
        ways = [event.amount for event in self.of(component)]
        mean = sum(abs(way.mean) for way in ways)
        # What is systematic is so in all of them.
        return Span(mean, sum(way.deviation for way in ways))

    def of(self, component: Component) -> tuple[Event, ...]:
        """Return the events of a component, by when they began."""
        kinds = {
            Component.TURN: (EventKind.TURN,),
            Component.SLIDE: (EventKind.SLIDE,),
            Component.PRESS: (EventKind.PRESS, EventKind.RELEASE),
        }[component]
        return tuple(event for event in self.events if event.kind in kinds)

    def turned_back(self) -> int:
        """Return how often a turn was followed by one the other way."""
        signs = [event.amount.mean > 0 for event in self.of(Component.TURN)]
        return sum(before != after for before, after in zip(signs[:-1], signs[1:], strict=True))

    def speed(self, component: Component) -> Floats:
        """Return how fast it goes around each frame: degrees, pixels or mm a second, (n,).

        Signed, but for a slide.
        """
        rate = self.rates()[0][:, COLUMNS[component]]
        return np.linalg.norm(rate, axis=1) if rate.shape[1] > 1 else rate[:, 0]

    def rates(self) -> tuple[Floats, Floats]:
        """Return how fast it turns, goes right, down and inward around each frame, (n, 4).

        Returns:
            Degrees, pixels and mm a second, and their deviations, which are zero where nothing
            touches: what does not touch does not move.
        """
        if len(self) < 2:
            return np.zeros((len(self), 4)), np.zeros((len(self), 4))
        early = np.searchsorted(self.times_s, self.times_s - SPEED_S / 2)
        late = np.searchsorted(self.times_s, self.times_s + SPEED_S / 2, side="right") - 1
        early, late = np.minimum(early, len(self) - 2), np.maximum(late, early + 1)
        late = np.minimum(late, len(self) - 1)
        seconds = (self.times_s[late] - self.times_s[early])[:, None]
        path, own = self.path_from_start, np.diagonal(self.covariances, axis1=1, axis2=2)
        own = np.cumsum(own, axis=0)
        way, doubt = path[late] - path[early], own[late] - own[early]
        off = np.square(_SYSTEMATIC_OF * way) + np.square(_ENDS_OF)
        touched = np.concatenate([[0], np.cumsum(self.is_touched)])
        is_free = touched[late + 1] == touched[early]
        return way / seconds, np.where(is_free[:, None], 0.0, np.sqrt(doubt + off) / seconds)

    def contacts(self) -> tuple[tuple[float, float], ...]:
        """Return from when to when something touched, seconds, one pair for each touch."""
        edges = np.flatnonzero(np.diff(np.concatenate([[0], self.is_touched, [0]])))
        pairs = zip(edges[::2], edges[1::2] - 1, strict=True)
        return tuple((float(self.times_s[a]), float(self.times_s[b])) for a, b in pairs)

    def to_rows(self) -> Iterator[dict[str, Any]]:
        """Yield plain values for each frame: time, contact, motion since the start, deviations."""
        path, deviations = self.path_from_start, self.path_deviations
        for k in range(len(self)):
            yield {
                "frame": int(self.numbers[k]),
                "time_s": round(float(self.times_s[k]), 4),
                "contact": round(float(self.contact[k]), 4),
                "strength_grey": round(float(self.strength_grey[k]), 3),
                **{name: round(float(x), 4) for name, x in zip(_WAYS, path[k], strict=True)},
                **{
                    f"{name}_deviation": round(float(x), 4)
                    for name, x in zip(_WAYS, deviations[k], strict=True)
                },
            }

    def _overlapping(self, cut: Track) -> list[Event]:
        first, last = cut.numbers[0], cut.numbers[-1]
        held = [one for one in self.events if one.begin < last and one.end > first]
        instants = [one for one in self.events if one.begin == one.end]
        inside = [one for one in instants if first <= one.begin <= last and one not in held]
        return sorted([*held, *inside], key=lambda one: (one.begin, one.end))

    def _inside(self, event: Event) -> Event:
        """Return the part of an event that lies in this track."""
        begin, end = max(event.begin, self.numbers[0]), min(event.end, self.numbers[-1])
        if (begin, end) == (event.begin, event.end):
            return event
        a, b = np.searchsorted(self.numbers, [begin, end])
        steps = slice(int(a) + 1, int(b) + 1)
        twist, own = self.twists[steps].sum(axis=0), self.covariances[steps].sum(axis=0)
        return replace(
            event,
            begin=int(begin),
            end=int(end),
            begin_s=float(self.times_s[a]),
            end_s=float(self.times_s[b]),
            twist=Twist(*map(float, twist)),
            amount=amount_of(event.component, twist, own) if event.component else event.amount,
        )


TOUCHED = 0.5

_SYSTEMATIC_OF, _ENDS_OF = np.array([SYSTEMATIC, ENDS])[:, [0, 1, 1, 2]]
"""Of each number of a twist: a slide has two."""

_ARRAYS = ("numbers", "times_s", "contact", "strength_grey", "twists", "covariances", "radius_px")
_WAYS = ("turn_deg", "right_px", "down_px", "inward_mm")
