"""The sign of the asked component: each measured candidate beside the belief, words and rivals.

A learned fusion is only needed where it is better than the best single thing that it is given.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import torch

from geotlm_lm.backbone.motions import MEASURED
from geotlm_lm.backbone.stem import measure_clip
from geotlm_lm.benchmarks.variants import BELIEF, FITS, on_gel
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import pixel_aspect
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.motion.measured import Measured, measured
from geotlm_lm.probe.rigid_flow import classify_motion

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer, Encoded
    from geotlm_lm.motion.belief import Belief

CANDIDATES = (*MEASURED, "learned shear")
"""Names of the rows of `Measured.paths`."""

TOLD = "told"
"""What is told by the belief's decision, beside what it leans to."""

MOVING = {Component.TURN: ROTATIONS, Component.SLIDE: SLIDES}
"""Components with a direction in the image -> their ways."""

Ways = Mapping[Component, Motion]


@dataclass(frozen=True, eq=False)
class Leanings:
    """What each method makes of a clip, were it forced to choose."""

    belief: Belief
    ways: Mapping[str, Ways]  # of the belief, each candidate and each rival
    paths: Mapping[str, tuple[float, float, float]]  # of each candidate: turn, right, down, px
    weights: Mapping[str, float] = field(default_factory=dict)  # of each, if the network has any

    def told(self, component: Component) -> Motion | None:
        """Return the way that is told of a component; None where it is not told to move."""
        return self.belief.way(component) if self.belief.moves(component) >= 0.5 else None


def leanings(answerer: Answerer, clip: Clip, *, with_rivals: bool = True) -> Leanings:
    """Return what the belief, its candidates and the rivals make of four frames."""
    encoded = answerer.encode(clip)
    seen = measured_of(encoded)
    names = names_of(seen)
    paths = dict(zip(names, map(tuple, seen.paths[0].tolist()), strict=True))
    ways = {BELIEF: {part: encoded.belief.way(part) for part in MOVING}}
    ways |= {name: ways_of(*path) for name, path in paths.items()}
    for name, rival in FITS.items() if with_rivals else ():
        fit = rival.fit(on_gel(clip))
        ways[name] = {part: classify_motion(fit, among) for part, among in MOVING.items()}
    with torch.inference_mode():
        beliefs = answerer.bundle.motion(seen)
    weights = getattr(beliefs, "weights", None)
    shares = {} if weights is None else dict(zip(names, weights[0].tolist(), strict=True))
    return Leanings(encoded.belief, ways, paths, shares)


def names_of(seen: Measured) -> tuple[str, ...]:
    """Return the names of what is measured, in order."""
    count = seen.paths.shape[1]
    return CANDIDATES if count == len(CANDIDATES) else MEASURED[:count]


@torch.inference_mode()
def measured_of(encoded: Encoded) -> Measured:
    """Return what is measured of a perceived clip, as the belief is given it."""
    clip, perception = encoded.clip, encoded.perception
    inputs, motions = perception.inputs, perception.motions
    if inputs is None or not motions:
        stem = measure_clip(clip)
        inputs, motions = torch.from_numpy(stem.inputs[None]), (stem.motions,)
    numbers = torch.from_numpy(motions[0].numbers())[None]
    aspect = pixel_aspect(*clip.frames.shape[1:3])
    return measured(inputs, numbers, perception.geometry, perception.fused_token, aspect)


def ways_of(turn: float, right: float, down: float) -> dict[Component, Motion]:
    """Return the ways that a path speaks for, however short."""
    along = max(
        (right, Motion.RIGHT), (-right, Motion.LEFT), (down, Motion.DOWN), (-down, Motion.UP)
    )
    sense = Motion.CLOCKWISE if turn > 0 else Motion.COUNTERCLOCKWISE
    return {Component.TURN: sense, Component.SLIDE: along[1]}
