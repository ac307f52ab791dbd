"""Whether a recording's pixels are square on the gel, where its size alone cannot tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.geometry import IMAGE_SIDE

SQUASHED = (
    f"Frames of {IMAGE_SIDE}x{IMAGE_SIDE} were taken for a 4:3 picture squashed to a square; pass "
    f"--square-pixels if the camera's is square."
)
UNSQUASHED = (
    f"Frames of {IMAGE_SIDE}x{IMAGE_SIDE} were taken as the camera took them, as asked or as the "
    f"file states; their last column is left out."
)


def with_pixel_shape(clip: Clip, *, is_square: bool | None) -> Clip:
    """Return a clip of the size that stands for the shape of its pixels, with a note on it.

    Frames of our square's size are read as a squashed 4:3 picture, those of every other size as
    they are (`core.geometry.camera_size`). Of square pixels a column is left out: frames are then
    of another size, and lengths in pixels stay what they were, as they would not if resized.

    Args:
        clip: As it was read.
        is_square: Whether the user or the file says that its pixels are as wide as high; None
            where neither says, which a note tells.
    """
    if clip.frames.shape[1:3] != (IMAGE_SIDE, IMAGE_SIDE):
        return clip
    if is_square is None:
        return clip.with_note(SQUASHED)
    if not is_square:
        return clip
    idle = clip.background
    narrower = replace(
        clip,
        frames=with_square_pixels(clip.frames),
        background=None if idle is None else with_square_pixels(idle),
    )
    return narrower.with_note(UNSQUASHED)


def with_square_pixels(pictures: Frames) -> Frames:
    """Return pictures of a camera with square pixels in a size that stands for them.

    Args:
        pictures: One or several, shape (..., rows, columns, 3).
    """
    if pictures.shape[-3:-1] != (IMAGE_SIDE, IMAGE_SIDE):
        return pictures
    return np.ascontiguousarray(pictures[..., :-1, :])
