"""Random paths for each of the ten motions; knows no shape and no image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.simulation.scene import Path

ROTATION_DEG = (3.0, 40.0)
SLIDE_MM = (0.3, 3.0)
DEPTH_CHANGE_MM = (0.15, 0.9)
"""Total change over a clip, from one barely visible to one a hand makes in a second."""

PIVOT_MM = 2.0
"""Farthest the axis of a rotation lies from the middle of the contact."""

IMPURITY = 0.15
"""Largest travel of the lesser motion, relative to the named one's at `CONTACT_RADIUS_MM`."""

CONTACT_RADIUS_MM = 2.0
"""Typical radius of a contact on GelSight Mini, where turning and sliding are compared."""

DEPTH_UNEVENNESS_MM = 0.08
"""Spread of the change of depth under a large turn or slide."""

SLIDE_FAN_DEG = 25.0
"""Farthest a slide's direction lies from its axis; 45 would be ambiguous."""

_SLIDE_ANGLE_DEG = {Motion.RIGHT: 0.0, Motion.DOWN: 90.0, Motion.LEFT: 180.0, Motion.UP: 270.0}

PathArray = NDArray[np.float64]


def random_path(
    rng: np.random.Generator,
    motion: Motion,
    *,
    depth_range_mm: tuple[float, float],
    centre_mm: tuple[float, float],
) -> Path:
    """Return a path that shows `motion`.

    Args:
        rng: Source of everything random.
        motion: One of the ten.
        depth_range_mm: Approach that gives enough contact, least and most.
        centre_mm: Where the middle of the path lies in the gel frame.
    """
    time = _times(rng)
    depth = np.full(FRAME_COUNT, rng.uniform(*depth_range_mm))
    turn, x, y = (np.zeros(FRAME_COUNT) for _ in range(3))
    if motion in ROTATIONS:
        turn, x, y = _rotate(rng, time, motion)
        arc_mm = abs(turn[-1]) * CONTACT_RADIUS_MM
        depth = depth + _small_depth_change(rng, time, arc_mm)
    elif motion in SLIDES:
        turn, x, y = _slide(rng, time, motion)
        travel_mm = float(np.hypot(x[-1], y[-1]))
        depth = depth + _small_depth_change(rng, time, travel_mm)
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
    x = x - (x[0] + x[-1]) / 2 + centre_mm[0]
    y = y - (y[0] + y[-1]) / 2 + centre_mm[1]
    turn = turn + rng.uniform(-np.pi, np.pi)
    return Path(*(tuple(float(value) for value in row) for row in (depth, x, y, turn)))


def _times(rng: np.random.Generator) -> PathArray:
    """Return 0 .. 1 in unequal steps: recordings are not sampled evenly along a motion."""
    steps = rng.uniform(0.6, 1.4, FRAME_COUNT - 1)
    return np.concatenate([[0.0], np.cumsum(steps) / steps.sum()])


def _rotate(
    rng: np.random.Generator, time: PathArray, motion: Motion
) -> tuple[PathArray, PathArray, PathArray]:
    total = np.radians(_log_uniform(rng, *ROTATION_DEG))
    turn = total * time * (1 if motion == Motion.CLOCKWISE else -1)
    arm = rng.uniform(0, PIVOT_MM)
    if rng.random() < 0.5:
        arm *= 0.3
    start = rng.uniform(-np.pi, np.pi)
    drift = rng.uniform(0, IMPURITY) * total * CONTACT_RADIUS_MM
    angle = rng.uniform(-np.pi, np.pi)
    x = arm * np.cos(start + turn) + drift * np.cos(angle) * time
    y = arm * np.sin(start + turn) + drift * np.sin(angle) * time
    return turn, x, y


def _slide(
    rng: np.random.Generator, time: PathArray, motion: Motion
) -> tuple[PathArray, PathArray, PathArray]:
    total = _log_uniform(rng, *SLIDE_MM)
    fan = rng.uniform(-SLIDE_FAN_DEG, SLIDE_FAN_DEG)
    angle = np.radians(_SLIDE_ANGLE_DEG[motion] + fan)
    turn = rng.uniform(-1, 1) * IMPURITY * total / CONTACT_RADIUS_MM * time
    return turn, total * np.cos(angle) * time, total * np.sin(angle) * time


def _press(
    rng: np.random.Generator, time: PathArray, depth_range_mm: tuple[float, float], motion: Motion
) -> PathArray:
    """Return the depths of a press; a release is the same backwards, perhaps out of contact."""
    change = _log_uniform(rng, *DEPTH_CHANGE_MM)
    deepest = rng.uniform(max(depth_range_mm[0], min(change * 0.8, 1.2)), depth_range_mm[1])
    depth = deepest - change * (1 - time)
    return depth if motion == Motion.PRESS else depth[::-1]


def _tremble(
    rng: np.random.Generator, *, turn_deg: float, travel_mm: float
) -> tuple[PathArray, PathArray, PathArray]:
    turn = np.radians(rng.uniform(-turn_deg, turn_deg, FRAME_COUNT))
    x, y = rng.uniform(-travel_mm, travel_mm, (2, FRAME_COUNT))
    return turn, x, y


def _small_depth_change(rng: np.random.Generator, time: PathArray, travel_mm: float) -> PathArray:
    """Return a hand's unevenness, small beside the motion: it widens or narrows the imprint."""
    total = rng.normal(0, min(IMPURITY * travel_mm, DEPTH_UNEVENNESS_MM))
    return total * (time - 0.5) + rng.normal(0, 0.1 * DEPTH_UNEVENNESS_MM, FRAME_COUNT)


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
