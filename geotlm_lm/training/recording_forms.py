"""Draw the form of a training clip: a pair or four frames, mirrored, no idle gel, damaged.

Damage is strong compression, a dim or drifting camera, or a faint touch.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.edit import MIRRORED
from geotlm_lm.core.geometry import FRAME_COUNT, IMAGE_SIDE, TIME_BIN_COUNT
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.numbers import log_uniform
from geotlm_lm.recordings.idle import estimate_background
from geotlm_lm.recordings.pixels import drifted, faded, gained, jpeg
from geotlm_lm.simulation.truth import READABLE_GREY

if TYPE_CHECKING:
    from geotlm_lm.backbone.view import View
    from geotlm_lm.core.clip import Clip
    from geotlm_lm.simulation.simulate import SimulatedClip

PAIR_SHARE = 0.25
"""Share of clips fed as two frames a, a, b, b, the way a frame pair is fed to four frames."""

UNKNOWN_BACKGROUND_SHARE = 0.3
"""Share of clips whose idle gel is estimated from the clip, as for a recording without one."""

UNKNOWN_MARKED_SHARE = 0.4
"""The same of gels that are printed on: what moves leaves its traces in such an estimate."""

MIRRORED_SHARE = 0.15
"""Share of clips flipped left to right, label and all: optics with a mirror in them."""

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


@dataclass(frozen=True, eq=False)
class RecordedForm:
    """A simulated clip the way a recording may come."""

    clip: Clip  # its four frames, the background known or estimated
    label: MotionLabel  # what happens until the last of them
    order: list[int]  # which of the simulated frames they are
    truth: SimulatedClip  # what was simulated, in the same image
    is_idle_known: bool  # whether the background is the idle gel itself


def as_recorded(
    simulated: SimulatedClip, rng: np.random.Generator, *, damaged_share: float = 0.0
) -> RecordedForm:
    """Draw a clip's form: all frames or a pair, through a mirror or not, an idle frame or none.

    `damaged_share` is the probability of damage by light or storage.
    """
    order = _frame_order(rng)
    is_mirrored = rng.random() < MIRRORED_SHARE
    label = simulated.label_until(max(order))
    simulated = mirrored(simulated) if is_mirrored else simulated
    is_marked = simulated.scene.optics.markers is not None
    unknown_share = UNKNOWN_MARKED_SHARE if is_marked else UNKNOWN_BACKGROUND_SHARE
    clip, is_idle_known = simulated.clip.select(order), rng.random() >= unknown_share
    # Drawn last: forms of clips without damage stay what they were.
    if damaged_share > 0 and rng.random() < damaged_share:
        clip, label = damage_clip(clip, label, simulated.trace_until(max(order)).change_grey, rng)
    if not is_idle_known:
        clip = replace(clip, background=estimate_background(clip.frames))
    label = MIRRORED.of_label(label) if is_mirrored else label
    return RecordedForm(clip, label, order, simulated, is_idle_known)


def mirrored(simulated: SimulatedClip) -> SimulatedClip:
    """Return what a camera behind a mirror records, and the dense truth in its image.

    The scene and its label stay those of the object; `MotionLabel.mirrored` flips the words.
    """
    clip = simulated.clip
    flipped = np.ascontiguousarray(clip.frames[:, :, ::-1])
    background = np.ascontiguousarray(clip.background[:, ::-1])
    displacement = simulated.displacement_px[:, :, ::-1] * np.array([-1, 1], np.float32)
    drift = simulated.drift_px
    return replace(
        simulated,
        clip=replace(clip, frames=flipped, background=background),
        displacement_px=displacement,
        contact=simulated.contact[:, :, ::-1],
        depth_mm=simulated.depth_mm[:, :, ::-1],
        drift_px=None if drift is None else drift[:, :, ::-1] * np.array([-1, 1], np.float32),
    )


def truth_in_view(view: View, simulated: SimulatedClip) -> tuple[NDArray, NDArray, NDArray]:
    """Return displacement, contact and depth of every frame on the view's grid."""
    contact = np.stack([view.cut(frame) for frame in simulated.contact])
    depth = np.stack([view.cut(frame) for frame in simulated.depth_mm])
    # Patches without contact hold no displacement: they must not blend into their neighbours.
    touched = (simulated.contact > 0).astype(np.float32)
    weight = np.stack([view.cut(frame) for frame in touched])
    moved = np.stack([view.cut(frame) for frame in simulated.displacement_px])
    moved = moved / np.maximum(weight, 1e-3)[..., None] * (IMAGE_SIDE / view.side_px)
    return moved * (weight > 0.25)[..., None], contact, depth


def _frame_order(rng: np.random.Generator) -> list[int]:
    """Choose the four frames: all of them, or a pair one or two frames apart.

    A pair starts at the first frame because the truth's displacement counts from there. Farther
    apart, a turn of 40 degrees in one step is beyond any flow, and not a frame pair of a recording.
    """
    if rng.random() >= PAIR_SHARE:
        return list(range(FRAME_COUNT))
    last = int(rng.integers(1, FRAME_COUNT - 1))
    return [0, 0, last, last]


def bin_means(values: NDArray) -> NDArray:
    """Return the mean of each time-bin's frames: (4, ...) to (2, ...)."""
    return values.reshape(TIME_BIN_COUNT, -1, *values.shape[1:]).mean(axis=1)


def damage_clip(
    clip: Clip, label: MotionLabel, change_grey: float, rng: np.random.Generator
) -> tuple[Clip, MotionLabel]:
    """Return a clip with one kind of damage, and what it still tells.

    Only fading is counted against what can be read, not what rounding in a dim picture or
    compression may take of a change that was near the limit before.

    `change_grey` is how much the motion changes the picture, grey levels, as `Trace` has it.
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
