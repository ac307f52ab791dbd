"""Draw the form of a training clip: a pair or four frames, mirrored, no idle gel, damaged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.edit import MIRRORED
from geotlm_lm.core.geometry import FRAME_COUNT, IMAGE_SIDE, TIME_BIN_COUNT
from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.training.image_damage import damage_clip

if TYPE_CHECKING:
    from geotlm_lm.backbone.view import View
    from geotlm_lm.core.clip import Clip
    from geotlm_lm.simulation.simulate import SimulatedClip

PAIR_SHARE = 0.25
"""Share of clips fed as two frames a, a, b, b, the way a frame pair is fed to four frames."""

UNKNOWN_BACKGROUND_SHARE = 0.3
"""Share of clips whose idle gel is estimated from the clip, as for a recording without one."""

MIRRORED_SHARE = 0.15
"""Share of clips flipped left to right, label and all: optics with a mirror in them."""


@dataclass(frozen=True, eq=False)
class RecordedForm:
    """A simulated clip the way a recording may come.

    Args:
        clip: Its four frames, the background known or estimated.
        label: What happens until the last of them.
        order: Which of the simulated frames they are.
        truth: What was simulated, in the same image.
    """

    clip: Clip
    label: MotionLabel
    order: list[int]
    truth: SimulatedClip


def as_recorded(
    simulated: SimulatedClip, rng: np.random.Generator, *, damaged_share: float = 0.0
) -> RecordedForm:
    """Draw a clip's form: all frames or a pair, through a mirror or not, an idle frame or none.

    Args:
        simulated: The clip and the truth about it.
        rng: Source of the form.
        damaged_share: Probability of damage by light or storage, as
            `image_damage.damage_clip` draws it.
    """
    from dataclasses import replace

    from geotlm_lm.recordings.idle import estimate_background

    order = _frame_order(rng)
    is_mirrored = rng.random() < MIRRORED_SHARE
    label = simulated.label_until(max(order))
    simulated = mirrored(simulated) if is_mirrored else simulated
    clip, is_idle_known = simulated.clip.select(order), rng.random() >= UNKNOWN_BACKGROUND_SHARE
    # Drawn last: forms of clips without damage stay what they were.
    if damaged_share > 0 and rng.random() < damaged_share:
        clip, label = damage_clip(clip, label, simulated.trace_until(max(order)).change_grey, rng)
    if not is_idle_known:
        clip = replace(clip, background=estimate_background(clip.frames))
    return RecordedForm(clip, MIRRORED.of_label(label) if is_mirrored else label, order, simulated)


def mirrored(simulated: SimulatedClip) -> SimulatedClip:
    """Return what a camera behind a mirror records, and the dense truth in its image.

    The scene and its label stay those of the object; `MotionLabel.mirrored` flips the words.
    """
    from dataclasses import replace

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
