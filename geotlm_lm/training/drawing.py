"""Which clips and questions a step of the language model's training draws."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.data.questions import askable_types

TYPE_WEIGHTS = {"T1": 6.0, "T2": 4.0, "T3": 8.0, "T17": 2.0}
"""How often a type is asked against 1 for the others: the open question is what users ask most;
verifying and choosing compare the clip with words of the question and are learned last; refusals
have the widest vocabulary."""

MOTION_WEIGHTS = {Motion.PRESS: 2.0, Motion.RELEASE: 2.0, Motion.STILL: 2.0}
"""How often a clip is asked about against 1 for the others. Turns and slides make two thirds of the
clips, so that a doubtful press was called one of them. Measured with a linear read-out of the same
tokens: a direction is claimed of 5.6 % of real presses instead of 9.3 %, of held imprints 0 instead
of 1 %, and real turns are told as well as before."""


def drawing_shares(labels: Sequence[MotionLabel]) -> NDArray[np.float64]:
    """Return how probable it is that a draw gives a clip or one before it, (n,)."""
    weights = np.array([MOTION_WEIGHTS.get(label.motion, 1.0) for label in labels])
    return np.cumsum(weights) / weights.sum()


def draw_clips(
    shares: NDArray[np.float64], count: int, *, seed: int, step: int
) -> NDArray[np.int64]:
    """Return the places of the `count` clips asked about in `step`."""
    rng = generator_for(seed, "language", "clips", step)
    return np.searchsorted(shares[:-1], rng.random(count), side="right")


def draw_type(label: MotionLabel, rng: np.random.Generator) -> str:
    """Return the type of one training question, the hard types more often."""
    among = askable_types(label)
    weights = np.array([TYPE_WEIGHTS.get(type_id, 1.0) for type_id in among])
    return among[int(rng.choice(len(among), p=weights / weights.sum()))]
