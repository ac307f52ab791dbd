"""What is believed of a clip's motion from direct alignment alone: no learned weight is read.

Neighbouring frames are aligned and the motions chained. Each step's covariance is the alignment's,
times the square of what it left over; nothing is held surer than `FLOOR_PX`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from statistics import NormalDist

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.alignment.direct import Picture, Rigid, align
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import camera_size, filled_size
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import (
    COUNTING_MM,
    COUNTING_PX,
    STILL_MM,
    STILL_PX,
    WAYS,
    Component,
    Twist,
)
from geotlm_lm.motion.belief import Belief
from geotlm_lm.probe.rigid_flow import imprint_contrast
from geotlm_lm.recordings.touch import UNTOUCHED_PROBABILITY

Floats = NDArray[np.float64]

PIXELS = 160 * 120
"""Pixels of the pictures that are aligned, square on the gel."""

GREEN = 1

FLOOR_PX = 0.4
"""Least deviation of what is measured, pixels of the 224-pixel image: that of a step which a hand
and a sensor at rest already make."""

MIDDLE_PX = 4.0
"""Deviation of the contact's middle, where travel is told: a turn moves another place otherwise."""

GROWN_MM, GROWN_DEVIATION_MM = 0.4, 0.06
"""Depth of a contact that its contrast grows with from nothing, and the deviation of that."""

GROWN_PATH_PX = 6.0
"""Path beside which half of a growth is not one of depth: what travels meets other gel."""

READABLE_PX = 3.0
"""Deviation up to which a component's path is told, pixels of the 224-pixel image."""

_QUARTER = math.pi / 4
_NORMAL = NormalDist()


def belief_of(bundle: Bundle, encoded: Encoded) -> Belief:
    """Return what is believed of a clip, given its perception.

    Args:
        bundle: Tells how much of the view a contact fills at least.
        encoded: The clip.
    """
    mean, covariance, radius = _measured(encoded.clip)
    covariance = covariance * encoded.doubt**2
    touched = _contact(bundle, encoded)
    turn = math.radians(1) * radius
    ways = _signed(
        WAYS[Component.TURN],
        mean.turn_deg * turn,
        math.sqrt(covariance[0, 0]) * turn,
        (STILL_PX + COUNTING_PX) / 2,
    )
    ways |= _signed(
        WAYS[Component.PRESS],
        mean.inward_mm,
        math.sqrt(covariance[3, 3]),
        (STILL_MM + COUNTING_MM) / 2,
    )
    ways |= _slides(mean, covariance[1:3, 1:3])
    worst = math.sqrt(float(np.linalg.eigvalsh(covariance[1:3, 1:3])[-1]))
    readable = {
        Component.TURN: math.sqrt(covariance[0, 0]) * turn <= READABLE_PX,
        Component.SLIDE: worst <= max(READABLE_PX, mean.slide_px / 2),
        Component.PRESS: True,
    }
    ways = {way: share * touched for way, share in ways.items()}
    return Belief(mean, covariance, ways, touched, radius, readable)


def _contact(bundle: Bundle, encoded: Encoded) -> float:
    """Return how probable it is that something touches."""
    if encoded.is_untouched:
        return 1 - UNTOUCHED_PROBABILITY
    least = bundle.calibration.contact_threshold
    if encoded.is_changed or encoded.contact_share >= least:
        return UNTOUCHED_PROBABILITY
    return 0.5 * encoded.contact_share / least


def _measured(clip: Clip) -> tuple[Twist, Floats, float]:
    """Return the twist, its covariance (4, 4) as of `Belief`, and the contact's radius, pixels."""
    small, (across, along) = _pictures(clip)
    contrast = [imprint_contrast(one) for one in small]
    place, radius = _contact_middle(np.mean(contrast, axis=0), small[0].shape)
    motion, covariance = _chained([Picture.of(one) for one in small], place)
    right, down = motion.travel(*place)
    radius = max(radius * math.sqrt(across * along), 1.0)
    scale = np.diag([math.degrees(1), across, along])
    spread = np.zeros((4, 4))
    spread[:3, :3] = scale @ covariance @ scale
    off_middle = (motion.turn_rad * MIDDLE_PX) ** 2
    spread += np.diag(
        [
            math.degrees(FLOOR_PX / radius) ** 2,
            FLOOR_PX**2 + off_middle,
            FLOOR_PX**2 + off_middle,
            GROWN_DEVIATION_MM**2,
        ]
    )
    first, last = float(contrast[0].mean()), float(contrast[-1].mean())
    grown = (last - first) / max(first, last, 1e-6)
    twist = Twist(math.degrees(motion.turn_rad), right * across, down * along)
    path = max(twist.path(Component.TURN, radius), twist.slide_px)
    inward = GROWN_MM * grown / (1 + path / GROWN_PATH_PX)
    return replace(twist, inward_mm=inward), spread, radius


def _pictures(clip: Clip) -> tuple[list[NDArray[np.float32]], tuple[float, float]]:
    """Return the imprints, small and square on the gel, and how many pixels of ours one has."""
    rows, columns = camera_size(*clip.frames.shape[1:3])
    shrink = (PIXELS / (rows * columns)) ** 0.5
    size = (max(round(columns * shrink), 8), max(round(rows * shrink), 8))
    frames = [frame[..., GREEN].astype(np.float32) for frame in clip.frames]
    idle = np.mean(frames, axis=0)
    if clip.background is not None:
        idle = clip.background[..., GREEN].astype(np.float32)
    small = [cv2.resize(one - idle, size, interpolation=cv2.INTER_AREA) for one in frames]
    filled_rows, filled_columns = filled_size(*clip.frames.shape[1:3])
    return small, (filled_columns / size[0], filled_rows / size[1])


def _contact_middle(
    weight: NDArray[np.floating], shape: tuple[int, ...]
) -> tuple[tuple[float, float], float]:
    """Return the contact's middle, right and down of the picture's, and its radius of gyration."""
    rows, columns = shape
    down, right = np.indices(weight.shape) * (rows / weight.shape[0])
    total = max(float(weight.sum()), 1e-6)
    x, y = float((right * weight).sum()) / total, float((down * weight).sum()) / total
    spread = weight * (np.square(right - x) + np.square(down - y))
    return (x - (columns - 1) / 2, y - (rows - 1) / 2), math.sqrt(float(spread.sum()) / total)


def _chained(pictures: Sequence[Picture], place: tuple[float, float]) -> tuple[Rigid, Floats]:
    """Return the motion in all, and the covariance of turn (rad) and travel at a place (3, 3)."""
    motion, covariance = Rigid(), np.zeros((3, 3))
    lever = max(pictures[0].image.shape) / 2
    x, y = place
    at_place = np.array([[1 / lever, 0, 0], [-y / lever, 1, 0], [x / lever, 0, 1]])
    for before, after in zip(pictures[:-1], pictures[1:], strict=True):
        if np.array_equal(before.image, after.image):
            continue
        step = align(before, after)
        motion = step.motion.after(motion)
        covariance += at_place @ step.covariance @ at_place.T * step.residual**2
    return motion, covariance


def _signed(
    ways: Sequence[Motion], mean: float, deviation: float, least: float
) -> dict[Motion, float]:
    """Return how probable it is that a value is beyond `least`, either way."""
    believed = NormalDist(mean, deviation)
    return {ways[0]: 1 - believed.cdf(least), ways[1]: believed.cdf(-least)}


def _slides(mean: Twist, covariance: Floats) -> dict[Motion, float]:
    """Return how probable it is that it slides each of four ways."""
    length = mean.slide_px
    along = np.array([mean.right_px, mean.down_px]) / length if length > 0 else np.array([1.0, 0.0])
    across = np.array([-along[1], along[0]])
    deviation = math.sqrt(float(along @ covariance @ along))
    far = 1 - NormalDist(length, max(deviation, 1e-3)).cdf((STILL_PX + COUNTING_PX) / 2)
    spread = math.sqrt(float(across @ covariance @ across)) / max(length, 1e-3)
    angle = math.atan2(mean.down_px, mean.right_px)
    ways = (Motion.RIGHT, Motion.DOWN, Motion.LEFT, Motion.UP)
    shares = [_share_within(angle - place * 2 * _QUARTER, spread) for place in range(4)]
    total = sum(shares)
    return {way: far * share / total for way, share in zip(ways, shares, strict=True)}


def _share_within(angle: float, spread: float) -> float:
    """Return the share of a spread angle that lies within 45 degrees of none."""
    angle = math.remainder(angle, 2 * math.pi)
    if spread > 2:
        return 0.25
    return sum(
        _NORMAL.cdf((turn + _QUARTER - angle) / spread)
        - _NORMAL.cdf((turn - _QUARTER - angle) / spread)
        for turn in (-2 * math.pi, 0.0, 2 * math.pi)
    )
