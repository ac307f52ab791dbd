"""Whether a recording's pixels are square on the gel, where its size alone cannot tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import IMAGE_SIDE

SQUASHED = (
    f"Frames of {IMAGE_SIDE}x{IMAGE_SIDE} were taken for a 4:3 picture squashed to a square; pass "
    f"--square-pixels if the camera's is square."
)
UNSQUASHED = (
    f"Frames of {IMAGE_SIDE}x{IMAGE_SIDE} were taken as the camera took them, as asked; their last "
    f"column is left out."
)


def with_pixel_shape(clip: Clip, *, is_square: bool) -> Clip:
    """Return a clip of the size that stands for the shape of its pixels, with a note on it.

    Frames of our square's size are read as a squashed 4:3 picture, those of every other size as
    they are (`core.geometry.camera_size`). Of square pixels a column is left out: frames are then
    of another size, and lengths in pixels stay what they were, as they would not if resized.

    Args:
        clip: As it was read.
        is_square: Whether the user says that its pixels are as wide as high.
    """
    if clip.frames.shape[1:3] != (IMAGE_SIDE, IMAGE_SIDE):
        return clip
    if not is_square:
        return clip.with_note(SQUASHED)
    idle = clip.background
    narrower = replace(
        clip,
        frames=np.ascontiguousarray(clip.frames[:, :, :-1]),
        background=None if idle is None else np.ascontiguousarray(idle[:, :-1]),
    )
    return narrower.with_note(UNSQUASHED)
