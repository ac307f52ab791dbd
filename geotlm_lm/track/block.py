"""A few tenths of a second of one contact: measured frame by frame, pressed as the model believes.

How far it turns and slides, frames laid on each other tell; how deep it goes only the model, of
four frames spread over the same time; when, the imprint's strength. Fusing the believed turn and
slide as well is not taken: real turns are then over-told.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.motion.belief import Belief
from geotlm_lm.track.believing import Believe
from geotlm_lm.track.exposure import Exposure
from geotlm_lm.track.keyframes import Step

Floats = NDArray[np.float64]

LONGEST_S = 0.5
"""Time after which a block ends."""

FARTHEST_DEG, FARTHEST_PX = 25.0, 25.0
"""Way after which it ends: the model was trained on little more."""

QUIET_DEG, QUIET_PX, QUIET_STRENGTH = 1.0, 1.0, 0.05
"""Way, and change of strength as a share, below which a block is at rest: nothing is asked."""

KEPT_FRAMES = 16
"""Frames kept of a block; of more every second one is dropped."""

GROWING = 3.0
"""Deviation, degrees and pixels, of a turn and a slide while the imprint's strength changes by a
factor of e: a contact that grows unevenly moves its edge, as if it turned."""

UNTOLD_MM = 0.1
"""Deviation of the depth in a block about which the model was not asked."""


@dataclass(frozen=True)
class Row:
    """A frame as it is kept.

    Args:
        number: Of the frame in the recording.
        time_s: When it was taken.
        strength_grey: Strength of its imprint.
        contact: Probability of contact by that strength.
        is_touched: Whether it counts as touched.
        step: From the frame before; None where none was measured.
        radius_px: Of the contact; 0 without one.
    """

    number: int
    time_s: float
    strength_grey: float
    contact: float
    is_touched: bool
    step: Step | None = None
    radius_px: float = 0.0


@dataclass
class Block:
    """Rows that are settled together.

    Args:
        rows: The frames, the first of them measured against the end of the block before.
        frames: Some of their pictures with their places, from the last frame of that block on.
    """

    rows: list[Row] = field(default_factory=list)
    frames: list[tuple[float, Frames]] = field(default_factory=list)

    def add(self, row: Row, frame: Frames) -> None:
        """Add a frame."""
        self.rows.append(row)
        self.frames.append((row.time_s, frame))
        if len(self.frames) > KEPT_FRAMES:
            self.frames = [*self.frames[:-1:2], self.frames[-1]]

    def expose(self, exposure: Exposure) -> None:
        """Change its pictures as if they had been exposed as later ones are."""
        self.frames = [
            (time_s, np.rint(exposure.applied(frame)).astype(np.uint8))
            for time_s, frame in self.frames
        ]

    @property
    def is_long(self) -> bool:
        """Whether it is time to settle it."""
        if not self.frames or not self.rows:
            return False
        turn, right, down = self.way[:3]
        return (
            self.rows[-1].time_s - self.frames[0][0] >= LONGEST_S
            or abs(turn) > FARTHEST_DEG
            or float(np.hypot(right, down)) > FARTHEST_PX
        )

    @property
    def way(self) -> Floats:
        """Sum of its steps, (4,)."""
        return self._twists().sum(axis=0)

    def settled(self, believe: Believe | None, idle: Frames) -> tuple[Floats, Floats, float]:
        """Return twists (n, 4), covariances (n, 4, 4), and how surely there is contact."""
        twists, covariances = self._twists(), self._covariances()
        if believe is None or self._is_quiet():
            return twists, covariances, 1.0
        belief = believe(self._four(idle))
        self._press(twists, covariances, belief)
        return twists, covariances, belief.contact

    def _grown(self) -> Floats:
        """Return by how much the imprint's strength changes in each row, as a logarithm."""
        strengths = np.log(self._strengths().clip(min=0.1))
        return np.abs(np.diff(strengths, prepend=strengths[0]))

    def _press(self, twists: Floats, covariances: Floats, belief: Belief) -> None:
        """Spread the press that is believed over the steps as the imprint's strength changes."""
        pressed = self._shares(np.diff([self._strengths()[0], *self._strengths()])[:, None])
        twists[:, 3] = pressed * belief.mean.inward_mm
        covariances[:, 3, 3] = pressed * belief.covariance[3, 3]

    def _shares(self, steps: Floats) -> Floats:
        """Return how what goes for the whole is spread over the steps, summing up to 1."""
        lengths = np.linalg.norm(steps, axis=1)
        lengths = lengths + 0.1 * lengths.mean() + 1e-9
        return lengths / lengths.sum()

    def _strengths(self) -> Floats:
        return np.array([row.strength_grey for row in self.rows])

    def _is_quiet(self) -> bool:
        turn, right, down = self.way[:3]
        strengths = self._strengths()
        return (
            len(self.frames) < 2
            or abs(turn) < QUIET_DEG
            and float(np.hypot(right, down)) < QUIET_PX
            and strengths.max() < (1 + QUIET_STRENGTH) * strengths.min()
        )

    def _four(self, idle: Frames) -> Clip:
        places = np.linspace(0, len(self.frames) - 1, FRAME_COUNT).round().astype(int)
        return Clip(np.stack([self.frames[k][1] for k in places]), background=idle, name="track")

    def _twists(self) -> Floats:
        twists = np.zeros((len(self.rows), 4))
        for k, row in enumerate(self.rows):
            if row.step is not None:
                twists[k, :3] = row.step.twist
        return twists

    def _covariances(self) -> Floats:
        covariances, grown = np.zeros((len(self.rows), 4, 4)), GROWING**2 * self._grown()
        for k, row in enumerate(self.rows):
            if row.step is not None:
                covariances[k, :3, :3] = row.step.covariance + grown[k] * np.eye(3)
                covariances[k, 3, 3] = UNTOLD_MM**2 / len(self.rows)
        return covariances
