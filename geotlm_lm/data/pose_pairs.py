"""Poses of a tracked sensor -> how the touched object moves in the image, and pairs of frames.

Knows poses and contacts, no files and no images. A pose T_i is start_T_curr: it takes coordinates
in the sensor's frame at frame i to its frame at the start, in metres; the sensor's frame has its
origin at the image's middle on the gel, x right, y down, z into the object. The labels of a pair
name the motion of the OBJECT in the image, which is the sensor's own motion the other way round.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, signed_amount

Poses = NDArray[np.float64]


@dataclass(frozen=True)
class PairRule:
    """Which pairs of frames get a label; the thresholds are ours, the paper names none.

    Args:
        gap_frames: Frames from the first of a pair to the second.
        least_turn_deg: Turn from which a pair is a rotation.
        most_aside_px: Travel of the contact that a rotation may have beside it.
        least_slide_px: Travel of the contact from which a pair is a slide.
        most_aside_deg: Turn that a slide may have beside it.
        least_purity: Share of a slide's travel that must go along its axis; 0.92 is 23 degrees off.
        most_tilt_deg: Turn out of the image plane above which a pair is left out.
        most_lift_mm: Travel along the gel's normal above which it is.
        least_contact_px: Contact below which it is; NormalFlow's own least.
    """

    gap_frames: int = 10
    least_turn_deg: float = 5.0
    most_aside_px: float = 10.0
    least_slide_px: float = 10.0
    most_aside_deg: float = 5.0
    least_purity: float = 0.92
    most_tilt_deg: float = 5.0
    most_lift_mm: float = 0.5
    least_contact_px: int = 500


GAPS_FRAMES = (5, 10, 15, 20, 25)
LEAST_TURNS_DEG = (2.0, 3.0, 5.0, 8.0, 12.0)
LEAST_SLIDES_PX = (4.0, 6.0, 10.0, 15.0, 20.0)
"""Thresholds swept: up to a second at 25 frames a second, from what a dense flow just resolves to a
third of a large contact."""

PAPER_TRIALS = 84
PAPER_PAIRS = {"rotation": 4088, "sliding": 6400}
"""Pairs the paper drew from the whole data set, all that it says of how it chose them."""


class Tracked(Protocol):
    """What labelling needs of a trial, one entry per frame."""

    poses: Poses
    contact_px: NDArray[np.int64]
    centres_px: NDArray[np.float64]
    mm_per_px: float
    size_px: tuple[int, int]


@dataclass(frozen=True)
class ImageMotion:
    """How the object moves in the image from one frame of each pair to the other, (pairs,) each.

    Args:
        turn_deg: Turn in the image plane, positive clockwise as drawn.
        slide_px: Travel of the contact's centre, (pairs, 2), right and down.
        tilt_deg: Turn out of the image plane.
        lift_mm: Travel of the contact's centre along z.
    """

    turn_deg: NDArray[np.float64]
    slide_px: NDArray[np.float64]
    tilt_deg: NDArray[np.float64]
    lift_mm: NDArray[np.float64]


@dataclass(frozen=True)
class LabelledPair:
    """Two frames of a trial and what the object does between them.

    Args:
        first: Number of the first frame.
        last: Number of the second.
        motion: The label.
        turn_deg: The turn it rests on, positive clockwise.
        slide_px: The travel it rests on, right and down.
    """

    first: int
    last: int
    motion: Motion
    turn_deg: float
    slide_px: tuple[float, float]


def image_motion(
    trial: Tracked, first: NDArray[np.integer], last: NDArray[np.integer]
) -> ImageMotion:
    """Return how the object moves in the image from frames `first` to frames `last`.

    The travel is that of the contact's centre: it is free of the lever arm by which a turn about
    another axis carries the image's middle.
    """
    before, after = trial.poses[first], trial.poses[last]
    seen = np.linalg.inv(after) @ before  # b_T_a: where a point of the object goes in the image
    middle = (np.array(trial.size_px[::-1]) - 1) / 2
    metres = trial.mm_per_px / 1e3
    point = np.zeros((len(first), 4))
    point[:, :2] = (trial.centres_px[first] - middle) * metres
    point[:, 3] = 1
    travel = np.einsum("nij,nj->ni", seen, point)[:, :3] - point[:, :3]
    turn, tilt = in_plane_turn(seen[:, :3, :3])
    return ImageMotion(turn, travel[:, :2] / metres, tilt, 1e3 * travel[:, 2])


def in_plane_turn(
    rotations: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the first of the extrinsic zxy angles, and the larger of the other two, in degrees.

    R = R_y(c) R_x(b) R_z(a), as NormalFlow reads a pose: its second row is
    (cos b sin a, cos b cos a, -sin b), and its last column's ends are sin c cos b and cos c cos b.

    Args:
        rotations: Shape (pairs, 3, 3).

    Returns:
        a and max(|b|, |c|), shape (pairs,) each; a > 0 takes x towards y, clockwise as drawn.
    """
    a = np.arctan2(rotations[:, 1, 0], rotations[:, 1, 1])
    b = np.arcsin(np.clip(-rotations[:, 1, 2], -1, 1))
    c = np.arctan2(rotations[:, 0, 2], rotations[:, 2, 2])
    return np.degrees(a), np.degrees(np.maximum(np.abs(b), np.abs(c)))


def labelled_pairs(trial: Tracked, rule: PairRule, task: str) -> list[LabelledPair]:
    """Return every pair of a trial that `rule` takes for one of `task`, in the order of time.

    Args:
        trial: Poses and contacts.
        rule: The thresholds.
        task: "rotation" or "sliding".
    """
    first = np.arange(len(trial.poses) - rule.gap_frames)
    if len(first) == 0:
        return []
    last = first + rule.gap_frames
    moved = image_motion(trial, first, last)
    is_sound = (
        (np.minimum(trial.contact_px[first], trial.contact_px[last]) >= rule.least_contact_px)
        & (moved.tilt_deg <= rule.most_tilt_deg)
        & (np.abs(moved.lift_mm) <= rule.most_lift_mm)
    )
    turn, travel = np.abs(moved.turn_deg), np.hypot(*moved.slide_px.T)
    if task == "rotation":
        is_one = (turn >= rule.least_turn_deg) & (travel <= rule.most_aside_px)
    else:
        is_pure = np.abs(moved.slide_px).max(axis=1) >= rule.least_purity * travel
        is_one = (travel >= rule.least_slide_px) & (turn <= rule.most_aside_deg) & is_pure
    return [
        _pair(int(first[k]), int(last[k]), task, moved.turn_deg[k], moved.slide_px[k])
        for k in np.flatnonzero(is_sound & is_one)
    ]


def sweep_pair_counts(trials: Sequence[Tracked], rule: PairRule, task: str) -> list[dict[str, Any]]:
    """Count the pairs of every gap and threshold, the other thresholds as `rule` has them.

    Returns:
        One row per combination: gap_frames, the least turn or travel, pairs, and pairs per label.
    """
    rows = []
    for one, threshold in _swept(rule, task):
        found = [pair.motion for trial in trials for pair in labelled_pairs(trial, one, task)]
        labels = {str(m): found.count(m) for m in Motion if m in found}
        rows.append(
            {"gap_frames": one.gap_frames, "least": threshold, "pairs": len(found), "of": labels}
        )
    return rows


def nearest_rule(
    rows: Sequence[dict[str, Any]], rule: PairRule, task: str, target: float
) -> PairRule:
    """Return the swept rule whose number of pairs comes nearest to `target`; the first of equals.

    Numbers of pairs alone decide; no method has seen a pair yet. A rule without any pair is taken
    only where no other has one.
    """
    rules = [one for one, _ in _swept(rule, task)]
    counts = [row["pairs"] for row in rows]
    best = min(range(len(rules)), key=lambda k: (counts[k] == 0, abs(counts[k] - target)))
    return rules[best]


def evenly_spaced(pairs: Sequence[LabelledPair], most: int) -> list[LabelledPair]:
    """Return at most `most` of `pairs`, evenly through the recording."""
    if len(pairs) <= most:
        return list(pairs)
    chosen = np.linspace(0, len(pairs) - 1, most).round().astype(int)
    return [pairs[int(index)] for index in chosen]


def _swept(rule: PairRule, task: str) -> Iterable[tuple[PairRule, float]]:
    for gap in GAPS_FRAMES:
        if task == "rotation":
            for least in LEAST_TURNS_DEG:
                yield replace(rule, gap_frames=gap, least_turn_deg=least), least
        else:
            for least in LEAST_SLIDES_PX:
                yield replace(rule, gap_frames=gap, least_slide_px=least), least


def _pair(
    first: int, last: int, task: str, turn_deg: float, slide_px: NDArray[np.float64]
) -> LabelledPair:
    right, down = (float(value) for value in slide_px)
    among = ROTATIONS if task == "rotation" else SLIDES
    motion = max(among, key=lambda one: signed_amount(one, turn=turn_deg, right=right, down=down))
    return LabelledPair(first, last, motion, float(turn_deg), (right, down))
