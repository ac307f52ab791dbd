"""Dots and prints on a gel, which move with what touches it: seen, filled, and left in a picture.

A frame less the idle gel shows what changed. Of a gel with dots it shows them twice, where they
are and where they were, and what stands still holds an alignment back.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Frames

ACTIVITY_WIDTH = 80
"""Columns of the grey image that contact and change are measured on."""


def activity_grey(frames: Frames) -> NDArray[np.float32]:
    """Return the frames in grey, `ACTIVITY_WIDTH` columns wide, shape (t, rows, columns)."""
    return np.stack(
        [
            cv2.cvtColor(shrunk(frame, ACTIVITY_WIDTH), cv2.COLOR_RGB2GRAY).astype(np.float32)
            for frame in frames
        ]
    )


def is_marked(grey: NDArray[np.float32]) -> bool:
    """Tell whether the gel shows dots or a print all over, from images as of `activity_grey`.

    What a disc of `DOT_PX` fills is looked at in the median of the images, where an object that
    moves drops out, in each of 5 x 5 fields: three quarters of them must have some.
    """
    # Of one image, as of an idle gel, the median is that image.
    middle = grey[0] if len(grey) == 1 else np.median(grey, axis=0)
    image = cv2.GaussianBlur(middle, (0, 0), MARKED_SIGMA)
    fields = (np.array_split(row, 5, axis=1) for row in np.array_split(filled(image) - image, 5))
    strongest = sorted(float(field.max()) for row in fields for field in row)
    return strongest[len(strongest) // 4] > MARKED_GREY


DOT_PX = 7
"""Pixels of the activity image (80 columns) that a dot is smaller than: 28 of a frame of 320."""

MARKED_SIGMA, MARKED_GREY = 0.7, 10.0
"""Pixels of the activity image that noise is finer than; grey levels from which fields have dots.
Of 711 single frames and windows of four of 237 real recordings of unmarked gels, most of them
touched, none has more than 4.6 (of 30 simulated objects 6.5); of 381 of 127 of marked ones, three
kinds, none less than 16.7 (simulated 20.8)."""


def filled(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return an image without its dark dots, wherever a touch has moved them to."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (DOT_PX, DOT_PX))
    return cv2.morphologyEx(image, cv2.MORPH_CLOSE, disc)


def shrunk(frame: Frames, width: int) -> Frames:
    """Return a frame that many columns wide, unless it is narrower already."""
    rows, columns = frame.shape[:2]
    width = min(width, columns)
    height = max(round(rows * width / columns), 4)
    return cv2.resize(frame, (width, height), interpolation=cv2.INTER_AREA)


def without_dots(idle: Frames) -> Frames:
    """Return what to take off frames before motion is measured in them, (rows, columns, 3), uint8.

    That is the idle gel itself; of one with dots its shading alone, so that they stay in the
    frames. Of 62 real slides on such a gel that nothing was chosen by, four frames, 0.97 are then
    told the right way, and 0.57 where the gel is taken off with its dots.
    """
    if not is_marked(activity_grey(idle[None])):
        return idle
    small = filled(shrunk(idle, ACTIVITY_WIDTH))
    smooth = cv2.GaussianBlur(small.astype(np.float32), (0, 0), SHADING_SIGMA)
    size = (idle.shape[1], idle.shape[0])
    return (
        np.rint(cv2.resize(smooth, size, interpolation=cv2.INTER_CUBIC)).clip(0, 255).astype("u1")
    )


SHADING_SIGMA = 3.0
"""Pixels of the activity image that shading is smoother than."""
