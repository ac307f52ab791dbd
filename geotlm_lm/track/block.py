"""A few tenths of a second of one contact: measured frame by frame, pressed as the model believes.

How far it turns and slides is measured by frames laid on each other; how deep it goes is known to
the model alone, from four frames spread over the same time; when, from the imprint's strength. The
believed turn and slide are not fused in: real turns are then overstated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import torch
from numpy.typing import NDArray

from geotlm_lm.backbone.stem import measure_clip
from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.geometry import FRAME_COUNT, pixel_aspect
from geotlm_lm.core.process import in_one_thread
from geotlm_lm.model import GeoTLM, Perception
from geotlm_lm.motion.belief import Belief
from geotlm_lm.motion.measured import Measured, measured
from geotlm_lm.motion.network import MotionNetwork, belief_of_one
from geotlm_lm.track.angles import Turn
from geotlm_lm.track.events import UNSURE_SHARE
from geotlm_lm.track.exposure import Exposure
from geotlm_lm.track.keyframes import Step

Floats = NDArray[np.float64]

Believe = Callable[[Clip], Belief]
"""Four frames with their idle gel, to the belief of the motion from the first to the last."""

LONGEST_S = 0.5
"""Time after which a block ends."""

FARTHEST_DEG, FARTHEST_PX = 25.0, 25.0
"""Way after which it ends: the model was trained on little more."""

QUIET_DEG, QUIET_PX, QUIET_STRENGTH = 1.0, 1.0, 0.05
"""Way, and change of strength as a share, below which a block is at rest: nothing is asked."""

KEPT_FRAMES = 16
"""Frames kept of a block; of more every second one is dropped."""

GROWING, GROWS_FROM = 8.0, 0.02
"""Formal deviation, degrees and pixels, of a turn and a slide while the imprint's strength changes
by a factor of e, and share of it that a frame's noise may change: a contact that grows unevenly
moves its edge, as if it turned. Of the events of 30 simulated streams seven are of no motion."""

UNKNOWN_MM = 0.1
"""Deviation of the depth in a block about which the model was not asked."""


@dataclass(frozen=True)
class Row:
    """A frame as it is kept."""

    number: int  # of the frame in the recording
    time_s: float  # when it was taken
    strength_grey: float  # strength of its imprint
    contact: float  # probability of contact by that strength
    is_touched: bool  # whether it counts as touched
    step: Step | None = None  # from the frame before; None where none was measured
    radius_px: float = 0.0  # of the contact; 0 without one


@dataclass
class Block:
    """Rows that are settled together."""

    # the frames, the first of them measured against the end of the block before
    rows: list[Row] = field(default_factory=list)
    # some of their pictures with their places, from the last frame of that block on
    frames: list[tuple[float, Frames]] = field(default_factory=list)
    # turns as frames apart tell them: rows from and to which, ends excluded and included
    turns: list[tuple[int, int, Turn]] = field(default_factory=list)

    def add(self, row: Row, frame: Frames) -> None:
        """Add a frame."""
        self.rows.append(row)
        self.frames.append((row.time_s, frame))
        if len(self.frames) > KEPT_FRAMES:
            self.frames = [*self.frames[:-1:2], self.frames[-1]]

    def correct(self, turn: Turn) -> None:
        """Let the steps since the last such turn add up to this one."""
        begin = self.turns[-1][1] if self.turns else 0
        self.turns.append((begin, len(self.rows), turn))

    @property
    def turn_shares(self) -> Floats:
        """Share of each step's turn that is doubted, (n,)."""
        shares = np.full(len(self.rows), UNSURE_SHARE)
        for begin, end, turn in self.turns:
            shares[begin:end] = turn.share
        return shares

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

    def settled(
        self, believe: Believe | None, idle_of: Callable[[], Frames]
    ) -> tuple[Floats, Floats, float]:
        """Return twists (n, 4), covariances (n, 4, 4), and how surely there is contact.

        The untouched gel is asked for where the model is.
        """
        twists, covariances = self._twists(), self._covariances()
        if believe is None or self._is_quiet():
            return twists, covariances, 1.0
        places = np.linspace(0, len(self.frames) - 1, FRAME_COUNT).round().astype(int)
        four = np.stack([self.frames[k][1] for k in places])
        belief = believe(Clip(four, background=idle_of(), name="track"))
        # The believed press is spread over the steps as the imprint's strength changes.
        strengths = self._strengths()
        lengths = np.abs(np.diff(strengths, prepend=strengths[0]))
        lengths = lengths + 0.1 * lengths.mean() + 1e-9
        shares = lengths / lengths.sum()
        twists[:, 3] = shares * belief.mean.inward_mm
        covariances[:, 3, 3] = shares * belief.covariance[3, 3]
        return twists, covariances, belief.contact

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

    def _twists(self) -> Floats:
        twists = np.zeros((len(self.rows), 4))
        for k, row in enumerate(self.rows):
            if row.step is not None:
                twists[k, :3] = row.step.twist
        for begin, end, turn in self.turns:
            steps = twists[begin:end, 0]
            lengths = np.abs(steps) + 1e-12
            steps += turn.beyond_deg * lengths / lengths.sum()
        return twists

    def _covariances(self) -> Floats:
        covariances = np.zeros((len(self.rows), 4, 4))
        logs = np.log(self._strengths().clip(min=0.1))
        change = np.abs(np.diff(logs, prepend=logs[0]))
        grown = GROWING**2 * (change - GROWS_FROM).clip(min=0)
        for k, row in enumerate(self.rows):
            if row.step is not None:
                covariances[k, :3, :3] = row.step.covariance + grown[k] * np.eye(3)
                covariances[k, 3, 3] = UNKNOWN_MM**2 / len(self.rows)
        return covariances


def believer(model: GeoTLM, motion: MotionNetwork) -> Believe:
    """Return what asks a model's perception and its motion network; no word is generated."""

    def believe(clip: Clip) -> Belief:
        return believed(motion, clip, model.perceive([clip]))

    return believe


@in_one_thread()
@torch.inference_mode()
def believed(
    motion: MotionNetwork, clip: Clip, perception: Perception, doubt: float = 1.0
) -> Belief:
    """Return the network's belief of four frames with their idle gel, perceived in a batch of one.

    The doubt is a factor that widens the spread and flattens the probabilities.
    """
    return belief_of_one(motion(measured_of(clip, perception)), doubt=doubt)


@torch.inference_mode()
def measured_of(clip: Clip, perception: Perception) -> Measured:
    """Return what is measured of four frames with their idle gel, perceived in a batch of one."""
    inputs, motions = perception.inputs, perception.motions
    if inputs is None or not motions:  # a released encoder has no stem of its own
        stem = measure_clip(clip)
        inputs, motions = torch.from_numpy(stem.inputs[None]), (stem.motions,)
    numbers = torch.from_numpy(motions[0].numbers())[None]
    aspect = pixel_aspect(*clip.frames.shape[1:3])
    return measured(inputs, numbers, perception.geometry, perception.fused_token, aspect)
