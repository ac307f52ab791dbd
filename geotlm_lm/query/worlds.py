"""What may be so, given what is believed: a few hundred possible worlds, alike in probability.

Each world says of every motion that was seen whether it is one, which way it goes and how far. An
expression is evaluated in all of them side by side; its value is how its results are spread. So a
claim and its contrary add up to one, joint probabilities are joint, and arithmetic is exact.

Every unknown is spread evenly over the worlds in an order of its own (a Latin hypercube; McKay,
Beckman and Conover, Technometrics 21, 1979): each probability is right to one world, each mean
exactly.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import astuple, dataclass, field, replace
from functools import lru_cache
from itertools import pairwise
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.edit import Edit
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, WAYS, Component, Twist
from geotlm_lm.motion.belief import Belief
from geotlm_lm.track.events import COLUMNS, SYSTEMATIC, Event, EventKind, doubted_share, floor_of
from geotlm_lm.track.summed import is_edge
from geotlm_lm.track.track import Track

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

COUNT = 500
"""Worlds: of two chances that differ by 0.004 the larger is seen to be so."""

SIGNIFICANCE = 2.9
"""Deviations of noise from which on a motion is seen: a detection limit is so many."""

SHAPE_DOUBT = 0.03
"""How far ahead of what was measured a motion may be halfway, as a share of its way: of 23 real
turns marked by eye at seven frames each, shares of the way differ by 0.032 (rms), with the marks'
own error."""

KINDS = {
    EventKind.TURN: Component.TURN,
    EventKind.SLIDE: Component.SLIDE,
    EventKind.PRESS: Component.PRESS,
    EventKind.RELEASE: Component.PRESS,
}


class Strata:
    """Draws numbers that lie evenly from 0 to 1 over the worlds, each in an order of its own."""

    def __init__(self, seed: int = 0) -> None:
        self._rng = np.random.default_rng(seed)

    def even(self) -> Floats:
        """Return the middles of `COUNT` equal parts in a random order, (COUNT,)."""
        return (self._rng.permutation(COUNT) + 0.5) / COUNT

    def even_among(self, chosen: Bools) -> Floats:
        """Return the same, even among the chosen worlds as well as among the others, (COUNT,)."""
        numbers = np.empty(COUNT)
        for part in (chosen, ~chosen):
            count = int(part.sum())
            numbers[part] = (self._rng.permutation(count) + 0.5) / max(count, 1)
        return numbers

    def normal(self) -> Floats:
        """Return standard normal numbers, (COUNT,)."""
        return _quantiles()[self._rng.permutation(COUNT)]


@lru_cache(maxsize=1)
def _quantiles() -> Floats:
    bell = NormalDist()
    return np.array([bell.inv_cdf((place + 0.5) / COUNT) for place in range(COUNT)])


def path_px(component: Component | None, twist: Floats, radius_px: float) -> Floats:
    """Return how far a motion's component moves an imprint, pixels, of a press mm; (n,)."""
    if component is Component.TURN:
        return np.abs(np.radians(twist[:, 0])) * max(radius_px, 1.0)
    if component is Component.SLIDE:
        return np.hypot(twist[:, 1], twist[:, 2])
    return np.abs(twist[:, 3])


@dataclass(frozen=True, eq=False)
class Happening:
    """A motion, a touch, a rest or a release, as it may have been in each world."""

    kind: EventKind
    begin_s: float
    end_s: float
    is_real: Bools  # in which worlds it happens, (COUNT,)
    probability: float
    twist: Floats  # its whole motion, of its own component alone, (COUNT, 4)
    # Share of its way that is behind it at some times, rising from 0 to 1.
    times_s: Floats
    shares: Floats
    radius_px: float = 0.0
    event: Event | None = None
    is_edge: bool = False  # a press or release that is the beginning or the end of a contact
    # How much farther along it is halfway in each world, as a share of its way, (COUNT,).
    ahead: Floats | float = 0.0

    @property
    def component(self) -> Component | None:
        """What of the motion it is of; None of a touch or a rest."""
        return KINDS.get(self.kind)

    @property
    def ends(self) -> tuple[Floats, Floats]:
        """When it begins and ends, the same in every world."""
        return np.asarray(self.begin_s), np.asarray(self.end_s)

    def share_at(self, time_s: Floats) -> Floats:
        """Return which share of its way is behind it at some times, (..., COUNT) or as these."""
        if self.times_s[0] == self.times_s[-1]:
            return (np.asarray(time_s) >= self.times_s[-1]).astype(float)
        share = np.interp(time_s, self.times_s, self.shares)
        return share + 4 * share * (1 - share) * self.ahead

    @property
    def path_px(self) -> Floats:
        """How far it moves the imprint in each world, pixels, (COUNT,)."""
        return path_px(self.component, self.twist, self.radius_px)


@dataclass(frozen=True, eq=False)
class Worlds:
    """Every way in which a clip or a recording may have gone, given what is believed of it."""

    happenings: tuple[Happening, ...]  # by when they begin
    touches: Bools  # in which worlds something touches, (COUNT,)
    contacts: tuple[tuple[float, float], ...]  # from when to when something touches
    begin_s: float
    end_s: float
    # What a component goes of which nothing is seen: turn, right, down, inward, (COUNT, 4).
    unseen: Floats
    belief: Belief
    track: Track | None = None
    views: dict[Edit, Worlds] = field(default_factory=dict, repr=False)  # as they were asked for

    @property
    def is_timed(self) -> bool:
        """Whether it is known what happens when: of a recording that was followed."""
        return self.track is not None

    def motions(self, component: Component | None = None) -> Iterator[Happening]:
        """Yield what moves: of one component, or of all."""
        for happening in self.happenings:
            own = happening.component
            if own is not None and component in (None, own):
                yield happening

    def seen(self, edit: Edit) -> Worlds:
        """Return the worlds from another point of view; backwards they run from their end."""
        if edit == Edit():
            return self
        if edit not in self.views:
            self.views[edit] = self._seen(edit)
        return self.views[edit]

    def _seen(self, edit: Edit) -> Worlds:
        matrix = edit.matrix
        total = self.begin_s + self.end_s

        def viewed(happening: Happening) -> Happening:
            twist = happening.twist @ matrix.T
            if not edit.backwards:
                return replace(happening, twist=twist)
            kind = _BACKWARDS.get(happening.kind, happening.kind)
            return replace(
                happening,
                kind=kind,
                twist=twist,
                begin_s=total - happening.end_s,
                end_s=total - happening.begin_s,
                times_s=(total - happening.times_s)[::-1],
                shares=1 - happening.shares[::-1],
                ahead=-happening.ahead,
            )

        happenings = [viewed(happening) for happening in self.happenings]
        contacts = self.contacts
        if edit.backwards:
            contacts = tuple((total - end, total - begin) for begin, end in reversed(contacts))
            happenings = [each for each in happenings if each.kind is not EventKind.TOUCH]
            happenings += [
                instant(EventKind.TOUCH, begin, self.touches)
                for begin, _ in contacts
                if begin > self.begin_s
            ]
        return replace(
            self,
            happenings=tuple(sorted(happenings, key=_order)),
            contacts=contacts,
            unseen=self.unseen @ np.abs(matrix).T,
            belief=self.belief.seen(edit),
            views={},
        )


_BACKWARDS = {EventKind.PRESS: EventKind.RELEASE, EventKind.RELEASE: EventKind.PRESS}


def _order(happening: Happening) -> tuple[float, bool, bool]:
    kind = happening.kind
    return (happening.begin_s, kind is not EventKind.TOUCH, kind is EventKind.RELEASE)


def instant(kind: EventKind, time_s: float, is_real: Bools, event: Event | None = None):
    """Return what takes no time and moves nothing."""
    times = np.array([time_s, time_s])
    still = np.zeros((COUNT, 4))
    share = float(is_real.mean())
    return Happening(kind, time_s, time_s, is_real, share, still, times, np.array([0.0, 1.0]),
                     event=event)  # fmt: skip


def worlds_of_clip(belief: Belief, seed: int = 0) -> Worlds:
    """Return the worlds of a clip of which one motion is believed, from first to last frame.

    The worlds of two clips that are compared have different seeds: they are independent.
    """
    strata = Strata(seed)
    touching = min(max(belief.contact, *map(belief.moves, COMPONENTS)), 1.0)
    touches = strata.even() < (touching if belief.is_contact_known else 1.0)
    happenings = []
    for component in COMPONENTS:
        twist, is_real = _drawn(belief, component, touches, strata)
        kinds = {way: kind for kind, part in KINDS.items() for way in WAYS[part]}
        kinds |= {Motion.PRESS: EventKind.PRESS, Motion.RELEASE: EventKind.RELEASE}
        kind = kinds[belief.way(component)]
        ends = np.array([0.0, 1.0])
        happenings.append(
            Happening(
                kind, 0.0, 1.0, is_real, float(is_real.mean()), twist, ends, ends, belief.radius_px
            )  # fmt: skip
        )
    unseen = _unseen(belief, strata)
    return Worlds(tuple(happenings), touches, ((0.0, 1.0),), 0.0, 1.0, unseen, belief)


def _drawn(
    belief: Belief, component: Component, touches: Bools, strata: Strata
) -> tuple[Floats, Bools]:
    """Return the motion of a component in each world, and in which it moves at all."""
    chosen = strata.even_among(touches)
    share = max(float(touches.mean()), 1e-9)
    edges = np.cumsum([belief.ways[way] / share for way in WAYS[component]])
    place = np.searchsorted(edges, chosen, side="right")
    is_real = touches & (place < len(edges))
    part = COLUMNS[component]
    mean = np.array(astuple(belief.mean))[part]
    deviations = np.sqrt(np.diagonal(belief.covariance))[part]
    normal = np.stack([strata.normal() for _ in mean], axis=1)
    twist = np.zeros((COUNT, 4))
    if component is Component.SLIDE:
        lower = np.linalg.cholesky(belief.covariance[part, part] + 1e-12 * np.eye(2))
        twist[:, part] = _turned_into(mean + normal @ lower.T, place)
    else:
        sign = np.where(place == 0, 1.0, -1.0)
        along = sign * mean[0]
        # Against the way that is believed it goes as far as noise does.
        far = np.where(along >= 0, along, 0.0) + deviations[0] * normal[:, 0]
        twist[:, part] = (sign * np.abs(far))[:, None]
    return np.where(is_real[:, None], twist, 0.0), is_real


_ANGLES = {Motion.RIGHT: 0, Motion.DOWN: 1, Motion.LEFT: 2, Motion.UP: 3}


def _turned_into(travel: Floats, place: NDArray[np.int64]) -> Floats:
    """Return travels turned by quarters, so that each goes the way that its world says."""
    wanted = np.array([*(_ANGLES[way] for way in WAYS[Component.SLIDE]), 0])[place]
    angle = np.arctan2(travel[:, 1], travel[:, 0])
    is_at = np.round(angle / (math.pi / 2)).astype(int) % 4
    angle = angle + (wanted - is_at) * (math.pi / 2)
    length = np.linalg.norm(travel, axis=1, keepdims=True)
    return length * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _unseen(belief: Belief, strata: Strata) -> Floats:
    """Return what a component goes where it is not seen to move: below its detection limit."""
    limits = [belief.limits.get(component, 0.0) for component in COMPONENTS]
    turn, slide, press = (limit / SIGNIFICANCE for limit in limits)
    turn = math.degrees(turn / max(belief.radius_px, 1.0))
    return np.stack([each * strata.normal() for each in (turn, slide, slide, press)], axis=1)


def worlds_of_track(track: Track, belief: Belief, seed: int = 0) -> Worlds:
    """Return the worlds of a recording that was followed, by its events.

    Args:
        track: Of the recording.
        belief: Of its motion from the first frame to the last, for limits and readability.
        seed: As of `worlds_of_clip`.
    """
    strata, shapes = Strata(seed), Strata(seed + 1_000)
    contact = float(track.contact.max(initial=0.0)) if track.is_contact_known else 1.0
    touches = strata.even() < contact
    common = {component: strata.normal() for component in COMPONENTS}
    happenings = []
    for event in track.events:
        if event.kind is EventKind.SLIP:
            continue  # the turn or slide that it is stands there already
        if event.amount.mean and not event.amount.is_clear:  # a span cut off the rest
            continue
        share = min(event.probability / max(contact, 1e-9), 1.0)
        is_real = touches & (strata.even_among(touches) < share)
        if event.component is None or event.begin_s == event.end_s:
            happenings.append(instant(event.kind, event.begin_s, is_real, event))
            happenings[-1] = replace(happenings[-1], end_s=event.end_s)
            continue
        (systematic, own), noise = _spread(track, event), strata.normal()
        part = COLUMNS[event.component]
        mean = np.array(astuple(event.twist))[part]
        drawn = np.zeros((COUNT, 4))
        drawn[:, part] = _lengthened(mean, systematic * common[event.component], own, noise, strata)
        times, shares = _progress(track, event)
        happenings.append(
            Happening(
                event.kind,
                event.begin_s,
                event.end_s,
                is_real,
                event.probability,
                np.where(is_real[:, None], drawn, 0.0),
                times,
                shares,
                _radius(track, event),
                event,
                event.component is Component.PRESS and is_edge(track, event),
                SHAPE_DOUBT * shapes.normal(),
            )  # fmt: skip
        )
    ends = float(track.times_s[0]), float(track.times_s[-1])
    unseen = _unseen(belief, strata)
    contacts = track.contacts() if track.is_contact_known else (ends,)
    for begin, end in contacts if track.is_contact_known else ():
        if ends[0] < begin and end < ends[1]:
            after = int(np.searchsorted(track.times_s, end, side="right"))
            happenings = _closed(happenings, begin, float(track.times_s[after]))
    happenings.sort(key=_order)
    return Worlds(tuple(happenings), touches, contacts, *ends, unseen, belief, track)


def _closed(happenings: list[Happening], begin_s: float, end_s: float) -> list[Happening]:
    """Return happenings of which a whole contact's lift off as far as they press in.

    In each world what is lacking is shared out by how far each is doubted; what set in suddenly, of
    which no way is known, takes all of it.
    """
    inside = [
        place
        for place, each in enumerate(happenings)
        if each.component is Component.PRESS and begin_s <= each.begin_s and each.end_s <= end_s
    ]
    ways = {place: happenings[place].twist[:, 3] for place in inside}
    means = [float(way.mean()) for way in ways.values()]
    if min(means, default=0.0) > 0 or max(means, default=0.0) <= 0:  # the other is not seen
        return happenings
    doubts = np.array([way.var() if way.any() else np.inf for way in ways.values()])
    weights = np.isinf(doubts) if np.isinf(doubts).any() else doubts
    weights = weights / max(weights.sum(), 1e-12)
    lacking, closed = sum(ways.values()), list(happenings)
    for (place, way), weight in zip(ways.items(), weights, strict=True):
        twist = np.zeros((COUNT, 4))
        low, high = (0.0, np.inf) if happenings[place].kind is EventKind.PRESS else (-np.inf, 0.0)
        twist[:, 3] = (way - weight * lacking).clip(low, high) * happenings[place].is_real
        closed[place] = replace(happenings[place], twist=twist)
    return closed


def with_own_motion(worlds: Worlds, times_s: Floats, steps: Floats) -> Worlds:
    """Return the worlds of what an object does itself, of one seen by a sensor that moves.

    Args:
        worlds: Of the object's motion relative to the sensor.
        times_s: When frames were taken, rising, (n,).
        steps: The sensor's own motion since the frame before, as the camera's picture has it: turn,
            right, down, inward, (n, 4). It carries the object while that is touched.
    """
    touched = np.zeros(len(times_s), bool)
    for begin, end in worlds.contacts:
        touched |= (times_s > begin) & (times_s <= end)
    steps = np.where(touched[:, None], steps, 0.0)
    kinds = {component: kind for kind, component in reversed(KINDS.items())}
    own = []
    for component in COMPONENTS:
        part = COLUMNS[component]
        for first, last in _one_way(steps[:, part]):
            lengths = np.linalg.norm(steps[first : last + 1, part], axis=1)
            if lengths.sum() < 1e-9:
                continue
            twist = np.zeros(4)
            twist[part] = steps[first : last + 1, part].sum(axis=0)
            is_lifted = component is Component.PRESS and twist[3] < 0
            kind = EventKind.RELEASE if is_lifted else kinds[component]
            times = times_s[max(first - 1, 0) : last + 1]
            shares = np.concatenate([[0.0], np.cumsum(lengths)])[-len(times) :] / lengths.sum()
            every = np.ones(COUNT, bool)
            radius = worlds.belief.radius_px
            moved = np.tile(twist, (COUNT, 1))
            own.append(
                Happening(kind, times[0], times[-1], every, 1.0, moved, times, shares, radius)
            )
    return replace(worlds, happenings=tuple(sorted([*worlds.happenings, *own], key=_order)))


def _one_way(steps: Floats) -> Iterator[tuple[int, int]]:
    """Yield the first and last of the steps of each stretch that does not turn back."""
    first, last, total = None, 0, np.zeros(steps.shape[1])
    for place, step in enumerate(steps):
        if not step.any():
            continue
        if first is not None and step @ total < 0:
            yield first, last
            first = None
        if first is None:
            first, total = place, np.zeros(steps.shape[1])
        last, total = place, total + step
    if first is not None:
        yield first, last


def _lengthened(
    mean: Floats, systematic: Floats, own: float, noise: Floats, strata: Strata
) -> Floats:
    """Return the ways of a leg in each world, (COUNT, 1 or 2), none of them turned round."""
    length = float(np.linalg.norm(mean))
    far = np.abs(length * (1 + systematic) + own * noise)
    axis = mean / max(length, 1e-9)
    along = far[:, None] * axis
    if len(mean) == 1:
        return along
    across = own * strata.normal()
    return along + across[:, None] * np.array([-axis[1], axis[0]])


def _spread(track: Track, event: Event) -> tuple[float, float]:
    """Return how far an event's amount is doubted as a share of it, and beside that."""
    far = abs(event.amount.mean)
    share = SYSTEMATIC[COMPONENTS.index(event.component)]
    if event.component is Component.TURN:
        steps = slice(*(np.searchsorted(track.numbers, [event.begin, event.end]) + 1))
        turned = np.abs(track.twists[steps, 0])
        share = float(doubted_share(turned.sum(), (turned * track.turn_shares[steps]).sum()))
    floor = floor_of(event.component, _radius(track, event))
    own = math.sqrt(max(event.amount.deviation**2 - (share * far) ** 2, floor**2))
    return share, own


def _radius(track: Track, event: Event) -> float:
    return float(track.radius_px[int(np.searchsorted(track.numbers, event.end))])


def _progress(track: Track, event: Event) -> tuple[Floats, Floats]:
    """Return at which times which share of an event's way is behind it."""
    first, last = np.searchsorted(track.numbers, [event.begin, event.end])
    times = track.times_s[first : last + 1]
    steps = np.linalg.norm(track.twists[first + 1 : last + 1, COLUMNS[event.component]], axis=1)
    total = steps.sum()
    if total <= 0:
        return times[[0, -1]], np.array([0.0, 1.0])
    return times, np.concatenate([[0.0], np.cumsum(steps) / total])


def gaps(spans: list[tuple[float, float]], whole: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the times of a whole that lie in none of some spans."""
    inside = [(max(begin, whole[0]), min(end, whole[1])) for begin, end in spans]
    merged: list[tuple[float, float]] = []
    for begin, end in sorted(span for span in inside if span[0] <= span[1]):
        if merged and begin <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(merged[-1][1], end))
        else:
            merged.append((begin, end))
    edges = [(whole[0], whole[0]), *merged, (whole[1], whole[1])]
    return [(end, begin) for (_, end), (begin, _) in pairwise(edges) if begin > end]


def way_of(kind: EventKind, twist: Floats) -> Motion:
    """Return which of the ten words a happening is, by its mean motion."""
    if kind is EventKind.TOUCH:
        return Motion.PRESS
    if kind is EventKind.STICK:
        return Motion.STILL
    return Twist(*map(float, twist)).way(KINDS[kind])
