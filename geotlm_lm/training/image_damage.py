"""Damage training clips: strong compression, a dim or drifting camera, a faint touch."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.seeding import log_uniform
from geotlm_lm.recordings.damage import drifted, faded, gained, jpeg
from geotlm_lm.simulation.truth import READABLE_GREY

if TYPE_CHECKING:
    from geotlm_lm.core.clip import Clip

JPEG_QUALITY = (5.0, 60.0)
"""Below the qualities that the simulator's cameras store; drawn evenly on a log scale."""

DIM_GAIN = (0.15, 0.7)
"""Exposure relative to a well-lit gel, drawn evenly on a log scale; one clip in forty of these is
so dark that a reader would refuse it."""

DRIFT_SHARE = 0.06
DRIFT_GREY = 6.0
"""Most by which the last frame is brighter or darker than the first, about what a camera may drift
before a reader refuses it: one clip in a hundred of these would be."""

KINDS = ("jpeg", "dim", "drift", "faint")
"""Damage, each as likely."""

FAINT_CONTRAST = (0.08, 0.7)
"""Contrast of a touch relative to the simulated one, drawn evenly on a log scale. From 0.04 on, no
more touches of a twentieth of the contrast were told (34 of 60)."""


def damage_clip(
    clip: Clip, label: MotionLabel, change_grey: float, rng: np.random.Generator
) -> tuple[Clip, MotionLabel]:
    """Return a clip with one kind of damage, and what it still tells.

    Only fading is counted against what can be read, not what rounding in a dim picture or
    compression may take of a change that was near the limit before.

    Args:
        clip: Frames and the idle frame.
        label: The truth about it.
        change_grey: How much the motion changes the picture, grey levels, as `Trace` has it.
        rng: Source of the damage.
    """
    frames, background = clip.frames, clip.background
    kind = KINDS[rng.integers(len(KINDS))]
    if kind == "jpeg":
        change = partial(jpeg, log_uniform(rng, JPEG_QUALITY))
        frames, background = np.stack([change(frame) for frame in frames]), change(background)
    elif kind == "dim":
        gain = log_uniform(rng, DIM_GAIN)
        frames, background = gained(gain, frames), gained(gain, background)
    elif kind == "drift":
        share, grey = rng.uniform(-1, 1, 2) * (DRIFT_SHARE, DRIFT_GREY)
        frames = drifted(grey, share, frames)
    else:
        contrast = log_uniform(rng, FAINT_CONTRAST)
        frames = faded(contrast, frames, background)
        is_seen = label.motion in (Motion.STILL, Motion.NONE)
        is_seen |= change_grey * contrast >= READABLE_GREY
        visible = tuple(grey * contrast for grey in label.visible_grey)
        is_readable = label.is_readable and bool(is_seen)
        label = replace(label, is_readable=is_readable, visible_grey=visible)
    return replace(clip, frames=frames, background=background), label
