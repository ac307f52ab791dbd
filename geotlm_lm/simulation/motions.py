"""Paths: a turn, a slide and a press as they are asked for, and random ones.

Random paths show each of the ten motions, or turn, slide and press freely mixed. Knows no shape
and no image.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, signed_amount
from geotlm_lm.core.numbers import log_uniform
from geotlm_lm.simulation.scene import Path

DEPTH_CHANGE_MM = (0.15, 0.9)
"""Total change over a clip, from one barely visible to one a hand makes in a second."""

PIVOT_MM = 2.0
"""Farthest the axis of a rotation lies from the middle of the contact."""

IMPURITY = 0.15
"""Largest travel of the lesser motion, relative to the named one's at `CONTACT_RADIUS_MM`."""

CONTACT_RADIUS_MM = 2.0
"""Typical radius of a contact on GelSight Mini, where turning and sliding are compared."""

DEPTH_JITTER_MM = 0.008
"""Spread of the depth from frame to frame, whatever else happens."""

SLIDE_FAN_DEG = 25.0
"""Farthest a slide's direction lies from its axis; 45 would be ambiguous."""

_SLIDE_ANGLE_DEG = {Motion.RIGHT: 0.0, Motion.DOWN: 90.0, Motion.LEFT: 180.0, Motion.UP: 270.0}

PathArray = NDArray[np.float64]


@dataclass(frozen=True)
class Hand:
    """How far whatever holds the sensor turns and slides in a clip, and how evenly it presses."""

    rotation_deg: tuple[float, float]  # total, least and most
    slide_mm: tuple[float, float]
    # Spread of the change of depth, relative to the path travelled at `CONTACT_RADIUS_MM`, and the
    # largest: it widens or narrows the imprint.
    unevenness: float
    unevenness_mm: float


STEADY = Hand((3.0, 40.0), (0.3, 3.0), unevenness=IMPURITY, unevenness_mm=0.08)

UNSTEADY = Hand((1.0, 40.0), (0.12, 3.0), unevenness=0.5, unevenness_mm=0.15)
"""A human hand. Of 542 pairs of frames of real turns, two frames apart, 215 turn less than a degree
and in 138 the imprint's contrast changes by more than 8 %; models that had met steady hands only
told 0.65 and 0.50 of these, and 0.94 of the others. A press still differs: relative to the path of
turn and travel, 19 of 20 presses change their depth by more than twice as much as 19 of 20 turns
of such a hand."""


def random_path(
    rng: np.random.Generator,
    depth_range_mm: tuple[float, float],
    centre_mm: tuple[float, float],
    motion: Motion,
    hand: Hand = STEADY,
) -> Path:
    """Return a path that shows `motion`, its middle at `centre_mm` in the gel frame.

    The depth range is the least and the most approach that gives enough contact.
    """
    time = _times(rng)
    depth = np.full(FRAME_COUNT, rng.uniform(*depth_range_mm))
    turn, x, y = (np.zeros(FRAME_COUNT) for _ in range(3))
    if motion in ROTATIONS:
        turn, x, y = _rotate(rng, time, motion, hand)
        arc_mm = abs(turn[-1]) * CONTACT_RADIUS_MM
        depth = depth + _small_depth_change(rng, time, arc_mm, hand)
    elif motion in SLIDES:
        turn, x, y = _slide(rng, time, motion, hand)
        travel_mm = float(np.hypot(x[-1], y[-1]))
        depth = depth + _small_depth_change(rng, time, travel_mm, hand)
    elif motion in (Motion.PRESS, Motion.RELEASE):
        depth = _press(rng, time, depth_range_mm, motion)
        turn, x, y = _tremble(rng, turn_deg=0.5, travel_mm=0.03)
    elif motion == Motion.STILL and rng.random() < 0.5:
        turn, x, y = _tremble(rng, turn_deg=0.1, travel_mm=0.01)
        depth = depth + rng.normal(0, 0.004, FRAME_COUNT)
    elif motion == Motion.NONE:
        depth = np.full(FRAME_COUNT, -1.0)
    if motion not in (Motion.PRESS, Motion.RELEASE, Motion.NONE):
        depth = np.clip(depth, *depth_range_mm)
    return _placed(rng, depth, x, y, turn, centre_mm)


MIXED_SHARES = {"turn": 0.7, "slide": 0.65, "press": 0.4}
"""Probabilities that a mixed path turns, slides, presses, each drawn for itself."""

MIXED_TURN_DEG, MIXED_SLIDE_MM, MIXED_PRESS_MM = (0.7, 45.0), (0.05, 3.5), (0.05, 0.9)
"""Totals over a clip, drawn evenly on a log scale: from what hardly shows between two frames of a
fast recording to what a hand does in a second."""

FAR_PIVOT_MM = 6.0
"""Farthest an axis lies from the middle of the contact in mixed paths: a wrist, a gripper."""

ONE_HAND_SHARE = 0.6
"""Share of mixed paths whose components go on at the same pace; in the others each has its own."""


def mixed_path(
    rng: np.random.Generator, depth_range_mm: tuple[float, float], centre_mm: tuple[float, float]
) -> Path:
    """Return a path as of `random_path` that turns, slides and presses with any ratio of these."""
    own = [_times(rng) for _ in range(3)]
    turning, sliding, pressing = [own[0]] * 3 if rng.random() < ONE_HAND_SHARE else own
    turns, slides, presses = rng.random(3) < tuple(MIXED_SHARES.values())
    turn, x, y = _tremble(rng, turn_deg=0.1, travel_mm=0.01)
    depth = np.full(FRAME_COUNT, rng.uniform(*depth_range_mm))
    depth = depth + rng.normal(0, DEPTH_JITTER_MM, FRAME_COUNT)
    if turns:
        total = np.radians(log_uniform(rng, MIXED_TURN_DEG)) * rng.choice([-1, 1])
        way = total * turning
        arm = rng.uniform(0, FAR_PIVOT_MM) * (rng.random() < 0.5)
        start = rng.uniform(-np.pi, np.pi)
        turn = turn + way
        x, y = x + arm * np.cos(start + way), y + arm * np.sin(start + way)
    if slides:
        total, angle = log_uniform(rng, MIXED_SLIDE_MM), rng.uniform(-np.pi, np.pi)
        x, y = x + total * np.cos(angle) * sliding, y + total * np.sin(angle) * sliding
    if presses:
        change = log_uniform(rng, MIXED_PRESS_MM) * rng.choice([-1, 1])
        depth = depth + change * (pressing - 0.5)
        # Pressed in from the first touch or lifted off, but never farther than the gel allows.
        depth = np.clip(depth, min(depth_range_mm[0], 0.05), depth_range_mm[1] + 0.3)
    else:
        depth = np.clip(depth, *depth_range_mm)
    return _placed(rng, depth, x, y, turn, centre_mm)


def path_of(
    *,
    turn_deg: float = 0.0,
    right_mm: float = 0.0,
    down_mm: float = 0.0,
    inward_mm: float = 0.0,
    depth_mm: float = 0.6,
    pivot_mm: tuple[float, float] = (0.0, 0.0),
    contact_mm: tuple[float, float] = (0.0, 0.0),
) -> Path:
    """Return the path that turns, slides and presses by as much, all at once and evenly.

    The axis of the turn goes along with the slide. Half-way the contact is in the middle of the
    view, provided it is where the object's centre is; the pose of the last frame does not depend
    on `contact_mm`, so that it can be looked up there.

    Turn (clockwise positive), slide and approach are totals, the depth is half-way. `pivot_mm` is
    where the axis of the turn lies from the middle of the contact in the last frame, (right, down):
    beside the contact it carries that middle along, as well as the slide. `contact_mm` is where
    that middle lies from the object's centre in the last frame.
    """
    time = np.linspace(-1.0, 0.0, FRAME_COUNT)
    turn, slide, arm = np.radians(turn_deg), complex(right_mm, down_mm), complex(*pivot_mm)
    # x + iy turns clockwise by exp(i turn), y running down. The middle of the contact is carried
    # by the slide and, about an axis beside it, by the turn.
    last = (slide - arm + np.exp(-1j * turn) * arm) / 2
    axis = last + complex(*contact_mm) + arm
    centre = axis + slide * time + np.exp(1j * turn * time) * (last - axis)
    rows = (depth_mm + inward_mm * (time + 0.5), centre.real, centre.imag, turn * (time + 0.5))
    return Path(*(tuple(row.tolist()) for row in rows))


def dominant_motion(path: Path, radius_mm: float = CONTACT_RADIUS_MM) -> Motion:
    """Return which of the ten names fits a path best.

    Turn and travel, the object's centre's, are compared at the contact's radius.
    """
    inward, x, y, turn = path.change()
    turned_mm, slid_mm = abs(turn) * radius_mm, float(np.hypot(x, y))
    if max(turned_mm, slid_mm) < LEAST_PATH_MM:
        if abs(inward) < LEAST_PRESS_MM:
            return Motion.STILL
        return Motion.PRESS if inward > 0 else Motion.RELEASE
    if turned_mm > slid_mm:
        return Motion.CLOCKWISE if turn > 0 else Motion.COUNTERCLOCKWISE
    return max(SLIDES, key=lambda way: signed_amount(way, turn=0, right=x, down=y))


def longest_mm(path: Path) -> float:
    """Return a bound on how far the imprint of a usual contact goes, by turn and travel together.

    The turn's path is that of the rim of a contact twice as wide as `CONTACT_RADIUS_MM`.
    """
    _, x, y, turn = path.change()
    return float(np.hypot(x, y)) + 2 * CONTACT_RADIUS_MM * abs(turn)


LEAST_PATH_MM, LEAST_PRESS_MM = 0.06, 0.1
"""Path of a turn or slide, and change of depth, below which a path shows none."""


def _placed(rng: np.random.Generator, depth, x, y, turn, centre_mm: tuple[float, float]) -> Path:
    """Return the path about its centre, begun at any angle."""
    x = x - (x[0] + x[-1]) / 2 + centre_mm[0]
    y = y - (y[0] + y[-1]) / 2 + centre_mm[1]
    turn = turn + rng.uniform(-np.pi, np.pi)
    return Path(*(tuple(float(value) for value in row) for row in (depth, x, y, turn)))


def _times(rng: np.random.Generator) -> PathArray:
    """Return 0 .. 1 in unequal steps: recordings are not sampled evenly along a motion."""
    steps = rng.uniform(0.6, 1.4, FRAME_COUNT - 1)
    return np.concatenate([[0.0], np.cumsum(steps) / steps.sum()])


def _rotate(
    rng: np.random.Generator, time: PathArray, motion: Motion, hand: Hand
) -> tuple[PathArray, ...]:
    total = np.radians(log_uniform(rng, hand.rotation_deg))
    turn = total * time * (1 if motion == Motion.CLOCKWISE else -1)
    arm = rng.uniform(0, PIVOT_MM) * (0.3 if rng.random() < 0.5 else 1.0)
    start = rng.uniform(-np.pi, np.pi)
    drift = rng.uniform(0, IMPURITY) * total * CONTACT_RADIUS_MM
    angle = rng.uniform(-np.pi, np.pi)
    x = arm * np.cos(start + turn) + drift * np.cos(angle) * time
    y = arm * np.sin(start + turn) + drift * np.sin(angle) * time
    return turn, x, y


def _slide(
    rng: np.random.Generator, time: PathArray, motion: Motion, hand: Hand
) -> tuple[PathArray, ...]:
    total = log_uniform(rng, hand.slide_mm)
    fan = rng.uniform(-SLIDE_FAN_DEG, SLIDE_FAN_DEG)
    angle = np.radians(_SLIDE_ANGLE_DEG[motion] + fan)
    turn = rng.uniform(-1, 1) * IMPURITY * total / CONTACT_RADIUS_MM * time
    return turn, total * np.cos(angle) * time, total * np.sin(angle) * time


def _press(
    rng: np.random.Generator, time: PathArray, depth_range_mm: tuple[float, float], motion: Motion
) -> PathArray:
    """Return the depths of a press; a release is the same backwards, perhaps out of contact."""
    change = log_uniform(rng, DEPTH_CHANGE_MM)
    deepest = rng.uniform(max(depth_range_mm[0], min(change * 0.8, 1.2)), depth_range_mm[1])
    depth = deepest - change * (1 - time)
    return depth if motion == Motion.PRESS else depth[::-1]


def _tremble(
    rng: np.random.Generator, *, turn_deg: float, travel_mm: float
) -> tuple[PathArray, ...]:
    turn = np.radians(rng.uniform(-turn_deg, turn_deg, FRAME_COUNT))
    x, y = rng.uniform(-travel_mm, travel_mm, (2, FRAME_COUNT))
    return turn, x, y


def _small_depth_change(
    rng: np.random.Generator, time: PathArray, travel_mm: float, hand: Hand
) -> PathArray:
    """Return the hand's unevenness, small beside the motion."""
    total = rng.normal(0, min(hand.unevenness * travel_mm, hand.unevenness_mm))
    return total * (time - 0.5) + rng.normal(0, DEPTH_JITTER_MM, FRAME_COUNT)
