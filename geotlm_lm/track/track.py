"""The motion of a whole recording as one value, which every question about it starts from.

Axes, signs and units are those of `core.twist`: clockwise, right, down and into the gel positive;
degrees, pixels of the 224-pixel square, mm. Travel is that of the middle of the contact.

The events are the decision: what moves is what they say moves. Steps outside a component's events
are noise that is not told from rest; they widen the spread and move nothing. So the sums, curves
and rates of a track are those of its events, and its net way is never longer than its path.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import astuple, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.errors import UsageError, require_inside
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.twist import COMPONENTS, Component, Twist
from geotlm_lm.motion.belief import PX_PER_MM
from geotlm_lm.recordings.scene_checks import SceneReport
from geotlm_lm.track.events import (
    COLUMNS,
    MOST_SHARE,
    MOVING,
    SIGNIFICANT,
    STEPS,
    SYSTEMATIC,
    UNSURE_SHARE,
    Event,
    EventKind,
    Span,
    amount_of,
    chance_of_moving,
    doubted_share,
    floor_of,
    noise_of,
)

Floats = NDArray[np.float64]

SPEED_S = 0.2
"""Time over which a speed is measured: less is noise."""

TOUCHED = 0.5

FORMING = 0.05
"""Change of an imprint's strength from frame to frame, in its logarithm, from which on it forms or
fades: at rest real ones change by 0.02."""

WINDOW_DEG, WINDOW_PX = 30.0, 30.0
"""Most that turns or slides within four frames that are looked at together."""

SYSTEMATIC_OF, STEPS_OF = np.array([SYSTEMATIC, STEPS])[:, [0, 1, 1, 2]]
"""Of each number of a twist: a slide has two."""

_ARRAYS = ("numbers", "times_s", "contact", "strength_grey", "twists", "covariances", "radius_px",
           "turn_shares")  # fmt: skip
_WAYS = ("turn_deg", "right_px", "down_px", "inward_mm")


@dataclass(frozen=True, eq=False)
class Track:
    """What touched when and how it moved, frame by frame."""

    numbers: NDArray[np.int64]  # where each frame stood in the recording, from 0, int64 (n,)
    times_s: Floats  # when it was taken, seconds, (n,), rising
    contact: Floats  # probability that something touches, (n,)
    strength_grey: Floats  # strength of the imprint, grey levels (rms), (n,)
    # motion from the frame before to each frame: turn, right, down, inward, (n, 4); zeros in the
    # first and outside the events of each component
    twists: Floats
    covariances: Floats  # what each step adds to the doubt of the way, (n, 4, 4)
    radius_px: Floats  # radius of the contact, (n,); 0 where nothing touches
    turn_shares: Floats  # share of each step's turn that is doubted beside the steps' noise, (n,)
    events: tuple[Event, ...]  # what happened, by when it began
    frame_size: tuple[int, int]  # rows and columns of the recording's frames
    notes: tuple[str, ...] = ()  # what was amiss, one sentence each
    is_cut: bool = False  # whether it was ended before the recording did; its last note says where
    # whether the gel's untouched look is known, without which nothing tells contact
    is_contact_known: bool = True
    scene: SceneReport = SceneReport()  # whether it is a gel's, and where the camera moved
    stated_limits: Mapping[Component, float] | None = None  # of a clip that is believed as a whole

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
        return self._deviations(np.diagonal(self.covariances, axis1=1, axis2=2))

    @property
    def held_deviations(self) -> Floats:
        """Deviations of the same counted from when it is held, (n, 4).

        Where an imprint that forms goes is hardly known, and no event rests on it.
        """
        own = np.diagonal(self.covariances, axis1=1, axis2=2)
        return self._deviations(np.where(self._is_held[:, None], own, 0.0))

    def _deviations(self, of_steps: Floats) -> Floats:
        own = np.cumsum(of_steps, axis=0)
        steps = np.abs(self.twists[:, 0])
        shares = np.tile(SYSTEMATIC_OF, (len(self), 1))
        shares[:, 0] = doubted_share(np.cumsum(steps), np.cumsum(steps * self.turn_shares))
        systematic = shares * self.path_from_start
        return np.sqrt(np.square(STEPS_OF) * own + np.square(systematic))

    @property
    def middle_radius_px(self) -> float:
        """Radius of the contact, its median over the frames that have one; 0 without any."""
        radii = self.radius_px[self.radius_px > 0]
        return float(np.median(radii)) if len(radii) else 0.0

    @property
    def limits(self) -> Mapping[Component, float]:
        """What is the least path of each component that would be an event: pixels, of a press mm.

        Over all of the track in which it is held, none where nothing touches; what goes faster is
        seen from less on, and while the imprint forms or fades more may go unseen. Where no slide
        is seen, a turn may hide one, of the share of its path that is doubted.
        """
        if self.stated_limits is not None:
            return self.stated_limits
        if not self.is_touched.any():
            return {}
        own, radius = self.covariances[self._is_held].sum(axis=0), max(self.middle_radius_px, 1.0)
        limits = {
            component: SIGNIFICANT * noise_of(component, own, radius) for component in COMPONENTS
        }
        limits[Component.TURN] = math.radians(limits[Component.TURN]) * radius
        if not self.of(Component.SLIDE):
            turned_px = math.radians(np.abs(self.twists[:, 0]).sum()) * radius
            hidden_px = UNSURE_SHARE * turned_px
            limits[Component.SLIDE] = math.hypot(limits[Component.SLIDE], hidden_px)
        return limits

    @property
    def _is_held(self) -> NDArray[np.bool_]:
        """Where no imprint forms after a touch or fades before a release; all where it does so."""
        logs = np.log(self.strength_grey.clip(min=0.1))
        changes = np.abs(np.diff(logs, prepend=logs[:1])) > FORMING
        held = np.ones(len(self), bool)
        for begin, end in self._touches:
            steady = np.flatnonzero(~changes[begin + 1 : end])
            if begin > 0:  # it touches within the track
                held[begin : begin + 1 + steady[0] if len(steady) else end] = False
            if end < len(self):
                held[begin + 2 + steady[-1] if len(steady) else begin : end + 1] = False
        return held if (held & self.is_touched).any() else np.ones(len(self), bool)

    @property
    def is_touched(self) -> NDArray[np.bool_]:
        """Whether something more probably touches than not, (n,)."""
        return self.contact >= TOUCHED

    def between(self, first: float, last: float, *, unit: str = "frames") -> Track:
        """Return the track of a span, both ends included; its motion starts at rest at `first`.

        The ends are frame numbers, or seconds where `unit` is "s".

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
        share = self._turn_share()
        return amount_of(component, twist, own, self.middle_radius_px, share)

    @property
    def net_twist(self) -> Twist:
        """The motion from the first frame to the last."""
        return Twist(*map(float, self.twists.sum(axis=0)))

    def path(self, component: Component) -> Span:
        """Return how far it went there and back, all together: the sum of its events' ways."""
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

    def is_readable(self, component: Component) -> bool:
        """Tell whether the pictures tell how far a component goes."""
        return all(event.is_readable for event in self.of(component))

    def as_readable(self, readable: Mapping[Component, bool]) -> Track:
        """Return the track with events that say whether the pictures tell how far they go."""
        events = (
            replace(event, is_readable=readable.get(event.component, True)) for event in self.events
        )
        return replace(self, events=tuple(events))

    def turned_back(self) -> int:
        """Return how often a turn was followed by one the other way."""
        signs = [event.amount.mean > 0 for event in self.of(Component.TURN)]
        return sum(before != after for before, after in zip(signs[:-1], signs[1:], strict=True))

    def rates(self) -> tuple[Floats, Floats]:
        """Return how fast it turns, goes right, down and inward around each frame, (n, 4).

        Degrees, pixels and mm a second, and their deviations; both are zero where nothing touches.
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
        # Frames that are kept agree on the whole of a turn, less on each tenth of a second.
        shares = np.array([MOST_SHARE, *SYSTEMATIC_OF[1:]])
        off = np.square(shares * way) + np.square(self.floors)
        touched = np.concatenate([[0], np.cumsum(self.is_touched)])
        is_free = touched[late + 1] == touched[early]
        off = np.sqrt(np.square(STEPS_OF) * doubt + off)
        return way / seconds, np.where(is_free[:, None], 0.0, off / seconds)

    @property
    def systematic(self) -> Floats:
        """Shares of the whole way of turn, right, down and inward that are doubted, (4,)."""
        return np.array([self._turn_share(), *SYSTEMATIC_OF[1:]])

    def _turn_share(self, steps: slice = slice(None)) -> float:
        turned = np.abs(self.twists[steps, 0])
        return float(doubted_share(turned.sum(), (turned * self.turn_shares[steps]).sum()))

    @property
    def floors(self) -> Floats:
        """Deviations of a way of no length, (4,)."""
        turn, slide, press = (floor_of(part, self.middle_radius_px) for part in COMPONENTS)
        return np.array([turn, slide, slide, press])

    def contacts(self) -> tuple[tuple[float, float], ...]:
        """Return from when to when something touched, seconds, one pair for each touch.

        None where contact is not known.
        """
        if not self.is_contact_known:
            return ()
        times = self.times_s
        return tuple((float(times[first]), float(times[end - 1])) for first, end in self._touches)

    @property
    def _touches(self) -> NDArray[np.int64]:
        """First row of each touch, and the one behind its last, (k, 2)."""
        edges = np.diff(np.concatenate([[0], self.is_touched, [0]]))
        return np.flatnonzero(edges).reshape(-1, 2)

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
        held = [event for event in self.events if event.begin < last and event.end > first]
        instants = [event for event in self.events if event.begin == event.end]
        inside = [e for e in instants if first <= e.begin <= last and e not in held]
        return sorted([*held, *inside], key=lambda event: (event.begin, event.end))

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
            creeps=None,
            is_let_go=event.is_let_go and end == event.end,
            **self._size(event, twist, own, float(self.radius_px[b]), self._turn_share(steps)),
        )

    @staticmethod
    def _size(
        event: Event, twist: Floats, own: Floats, radius_px: float, share: float
    ) -> dict[str, Any]:
        if event.component is None:
            return {}
        amount = amount_of(event.component, twist, own, radius_px, share)
        noise = noise_of(event.component, own, radius_px)
        sure = min(event.probability, chance_of_moving(amount.mean, noise))
        return {"amount": amount, "probability": sure}


def decided(track: Track, events: Iterable[Event], going_on: Mapping[Component, int]) -> Track:
    """Return a track of raw steps as its events have it; see the module.

    Args:
        track: With the steps as measured.
        events: What happened.
        going_on: At which place a leg begins that is not over yet, of each component that has one.
    """
    held = (event for event in events if track.is_contact_known or not event.is_of_contact)
    cut = replace(track, events=tuple(sorted(held, key=lambda event: (event.begin, event.end))))
    twists, covariances = np.zeros_like(track.twists), track.covariances.copy()
    for component in COMPONENTS:
        part, inside = COLUMNS[component], np.zeros(len(track), bool)
        for event in cut.of(component):
            ends = (event.begin, event.end, *(event.creeps or (event.begin, event.end)))
            begin, end, first, last = np.searchsorted(track.numbers, ends)
            inside[first + 1 : last + 1] = True
            own = track.twists[begin + 1 : end + 1, part]
            creep = np.array(astuple(event.twist))[part] - own.sum(axis=0)
            lengths = np.linalg.norm(own, axis=1, keepdims=True) + 1e-12
            twists[begin + 1 : end + 1, part] = own + creep * lengths / lengths.sum()
        if component in going_on:
            inside[going_on[component] + 1 :] = True
            twists[going_on[component] + 1 :, part] = track.twists[going_on[component] + 1 :, part]
        for rest in _runs(~inside):
            creep = track.twists[rest, part].sum(axis=0)
            covariances[rest, part, part] += np.outer(creep, creep) / len(covariances[rest])
    contact = _contact_of(cut) if track.is_contact_known else track.contact
    return replace(cut, twists=twists, covariances=covariances, contact=contact)


def _runs(held: NDArray[np.bool_]) -> list[slice]:
    """Return the stretches in which something holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], held, [0]])))
    return [slice(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _contact_of(track: Track) -> Floats:
    """Return how sure contact is in each frame, likelier than not between touch and release."""
    touched = np.zeros(len(track), bool)
    begin = None
    for event in track.events:
        if event.kind is EventKind.TOUCH:
            begin = event.begin
            touched[track.numbers >= begin] = True
        elif event.kind is EventKind.RELEASE and event.is_let_go:
            touched[track.numbers > event.end] = False
    return np.where(touched, np.maximum(track.contact, TOUCHED), np.minimum(track.contact, 0.49))


def window_of(track: Track) -> tuple[int, ...]:
    """Return the places in a track of four frames that show its motion best.

    They lie evenly in its largest turn or slide, no farther apart than can be looked at together;
    where there is none in a press, else in what is touched.
    """
    places = np.flatnonzero(track.is_touched)
    main = main_event(track)
    if main is not None:
        first, last = np.searchsorted(track.numbers, [main.begin, main.end])
        first, last = _shortened(track, int(first), int(last))
    elif len(places):
        first, last = int(places[0]), int(places[-1])
    else:
        first, last = 0, len(track) - 1
    if last - first < 1:
        first, last = max(first - 1, 0), min(last + 1, len(track) - 1)
    return tuple(int(round(place)) for place in np.linspace(first, last, FRAME_COUNT))


def main_event(track: Track) -> Event | None:
    """Return the turn or slide that moves the imprint farthest; without one the longest press."""
    presses = (EventKind.PRESS, EventKind.RELEASE)
    return max(
        (event for event in track.events if event.kind in (*MOVING, *presses)),
        key=lambda event: (event.kind in MOVING, path_of_event(track, event)),
        default=None,
    )


def path_of_event(track: Track, event: Event) -> float:
    """Return how far a turn, slide or press moves the imprint, pixels."""
    far = abs(event.amount.mean)
    if event.component is Component.TURN:
        place = int(np.searchsorted(track.numbers, event.end))
        return math.radians(far) * float(track.radius_px[place])
    return far * PX_PER_MM if event.component is Component.PRESS else far


def _shortened(track: Track, first: int, last: int) -> tuple[int, int]:
    """Return the middle part of a span in which no more moves than is looked at together."""
    way = np.cumsum(track.twists[first : last + 1], axis=0)
    turned = np.abs(way[:, 0] - way[0, 0]) / WINDOW_DEG
    slid = np.linalg.norm(way[:, 1:3] - way[0, 1:3], axis=1) / WINDOW_PX
    share = 1 / max(float(turned.max()), float(slid.max()), 1.0)
    middle, half = (first + last) / 2, share * (last - first) / 2
    return max(math.floor(middle - half), first), min(math.ceil(middle + half), last)
