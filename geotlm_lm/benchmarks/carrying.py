"""A picture moved by a known motion over real idle frames, to a hundredth of a pixel."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import FRAME_COUNT, camera_size

Floats = NDArray[np.float32]

MOVING_SHARE = 0.7
"""Share of the way from the contact's middle to the rim in which a gel with dots moves as a whole:
contacts reach over most of it, 60 to 90 of 224 pixels in radius."""

_READ = np.linspace(0, 1, 513)
_SHIFTED = _READ + _READ * (1 - _READ) * (1 - 2 * _READ) / 2
"""Where OpenCV's cubic kernel (a = -0.75) is asked to read between two pixels, and how far it then
shifts what is smooth: by 0.136 of a pixel when asked for 0.1. Asked the other way about, it shifts
as far as it should."""


def carried(
    change: Floats,
    gel: tuple[Floats, Floats],
    *,
    path_px: Sequence[float] = (0.0, 0.0),
    turn_deg: float = 0.0,
    growth: tuple[float, float] = (1.0, 1.0),
    about: Sequence[float] | None = None,
    has_dots: bool = False,
) -> Clip:
    """Return four frames of an imprint over the gel, evenly from its own place to another.

    Args:
        change: A touched frame's change against the idle gel, (rows, columns, 3), grey levels.
        gel: Four frames of it, and what it looks like on the mean.
        path_px: Travel right and down, pixels of the frames.
        turn_deg: Turn, clockwise positive.
        growth: First strength and last, 1 as recorded.
        about: What it turns about, x before y in pixels; None for the middle of the image.
        has_dots: Whether the gel has dots, which go along about the contact and stay at the rim.
    """
    grounds, idle = gel
    rows, columns = idle.shape[:2]
    middle = np.array((columns / 2, rows / 2) if about is None else about)
    camera_rows, camera_columns = camera_size(rows, columns)
    # A turn is rigid on the gel, whose pixels are not square in a squashed picture.
    stretch, frames = np.array([camera_columns / columns, camera_rows / rows]), []
    window = window_about(middle, (rows, columns)) if has_dots else None
    for share, ground in zip(np.linspace(0, 1, FRAME_COUNT), grounds, strict=True):
        angle = np.radians(turn_deg * share)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        turn = turn * stretch / stretch[:, None]
        way = middle - turn @ middle + share * np.asarray(path_px)
        strength = float(growth[0] + share * (growth[1] - growth[0]))
        touched = strength * change + (idle if has_dots else 0)
        rest = ground - idle if has_dots else ground
        frames.append(as_image(rest + warped(touched, np.column_stack([turn, way]), window)))
    return Clip(np.stack(frames), background=as_image(idle))


def window_about(middle: Sequence[float], size: tuple[int, int]) -> Floats:
    """Return the share of a motion that each pixel makes, (rows, columns).

    It is 1 about a contact's middle, x before y in pixels, and falls smoothly to 0 at the rim.
    """
    sides = []
    for place, length in zip(middle, size[::-1], strict=True):
        off = np.arange(length) - place
        out = np.abs(off) / np.maximum(np.where(off < 0, place, length - 1 - place), 1.0)
        down = np.clip((1 - out) / (1 - MOVING_SHARE), 0, 1)
        sides.append(down * down * (3 - 2 * down))
    return np.outer(sides[1], sides[0]).astype(np.float32)


def warped(picture: Floats, forth: NDArray[np.float64], window: Floats | None = None) -> Floats:
    """Return a picture (rows, columns, 3) moved by an affine motion (2, 3), where a window lets it.

    It is read once, by cubic interpolation.
    """
    if np.array_equal(forth, np.eye(2, 3)):
        return picture
    rows, columns = picture.shape[:2]
    back = cv2.invertAffineTransform(forth)
    at = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1)
    source = at @ back[:, :2].T + back[:, 2]
    if window is not None:
        source = at + window[..., None] * (source - at)
    whole = np.floor(source)
    read = (whole + np.interp(source - whole, _SHIFTED, _READ)).astype(np.float32)
    reflect = cv2.BORDER_REFLECT_101
    return cv2.remap(picture, read, None, cv2.INTER_CUBIC, borderMode=reflect)


def as_image(values: NDArray[np.floating]) -> NDArray[np.uint8]:
    """Return grey levels as a picture."""
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
