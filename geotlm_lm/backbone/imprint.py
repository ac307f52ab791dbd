"""Four frames and the idle gel -> the imprint: its view under the usual lights, and its relief.

What every measurement of a clip's motion starts from. No weight is learned. A picture is shrunk
once, to about 160 x 120; nothing after that looks at more pixels.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.alignment.dots import without_dots
from geotlm_lm.backbone.relief import (
    MOST_CURL,
    RELIEF_SIDE,
    Lights,
    as_of_one_light,
    gradients,
    is_inside_out,
    lights_of,
    reliefs,
    turned_by_a_half,
    turned_by_a_quarter,
)
from geotlm_lm.backbone.view import VIEW_CELL_PX, View, contact_view
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import FRAME_COUNT, IMAGE_SIDE, filled_size, pixel_aspect

Floats = NDArray[np.float32]

RESIDUAL_SCALE_GREY = 24.0
"""Grey levels mapped to 1: about one standard deviation of a real contact's residual (21-43)."""

SMALL_COLUMNS, SMALL_ROWS = 168, 112
"""Pixels across and down that stand for our square of 224: a camera's width is the larger side, and
both are whole pixels per cell of the view's search."""

VIEW_SIDE = 112
"""Side of the view's pictures."""


@dataclass(frozen=True, eq=False)
class Imprint:
    """What differs from the idle gel in the view of a clip, frame by frame.

    Frames that repeat the one before are left out.
    """

    # Green residual of the view, with the gel's dots if it has any, grey levels, pixels square on
    # the gel, (`VIEW_SIDE` / aspect, `VIEW_SIDE`) each.
    green: list[Floats]
    # Residual of the view as under the usual lights, RGB grey levels, (56, 56, 3) each.
    cells: list[Floats]
    relief: Floats  # indentation, (frames, 56, 56), in grey levels times pixels
    is_shaded: bool  # whether the shading is that of a relief: not of markers or a print
    view: View  # the square of the picture they show
    places: list[int]  # which of the frames stands at each place of the clip
    aspect: float  # width of a pixel of the view over its height


def imprint_of(clip: Clip) -> Imprint:
    """Find the imprint in a clip and show it as under a GelSight Mini's lights.

    The clip has exactly four frames with a known or estimated background, of any size.
    """
    if len(clip) != FRAME_COUNT or clip.background is None:
        raise ValueError(f"the stem reads {FRAME_COUNT} frames and a background, found {len(clip)}")
    frames, places = _distinct(clip.frames)
    rows, columns = clip.frames.shape[1:3]
    filled, aspect = filled_size(rows, columns), pixel_aspect(rows, columns)
    whole = [_residual(frame, clip.background, filled) for frame in frames]
    view = contact_view([_energy(image) for image in whole])
    seen = [_cut(image, view) for image in whole]
    height = max(round(VIEW_SIDE / aspect), 8)
    bare = without_dots(clip.background)
    is_dotted = bare is not clip.background
    moving = [cv2.extractChannel(part, 1) for part in seen]
    if is_dotted:
        shading = cv2.extractChannel(bare, 1)
        greens = (cv2.extractChannel(frame, 1) for frame in frames)
        moving = [_cut(_residual(image, shading, filled), view) for image in greens]
    size = (VIEW_SIDE, height)
    green = [cv2.resize(part, size, interpolation=cv2.INTER_AREA) for part in moving]
    cells = [area_means(part, RELIEF_SIDE) for part in seen]
    lights = lights_of(cells, aspect)
    cells, relief = _under_usual_lights(cells, lights, aspect)
    view = replace(view, picture_height_px=filled[0], picture_width_px=filled[1])
    is_shaded = lights.curl < MOST_CURL and not is_dotted
    return Imprint(green, cells, relief, is_shaded, view, places, aspect)


def area_means(values: NDArray[Any], side: int) -> NDArray[Any]:
    """Average a square image to `side` pixels, each a whole number of its own; keeps the type."""
    # Measured 15 times faster than a numpy mean over two axes of the reshaped image.
    return cv2.resize(values, (side, side), interpolation=cv2.INTER_AREA)


def _residual(frame: NDArray[np.uint8], idle: NDArray[np.uint8], filled: tuple[int, int]) -> Floats:
    """Return a frame less the idle gel, grey levels, (SMALL_ROWS, SMALL_COLUMNS, 3).

    A picture of one colour is (SMALL_ROWS, SMALL_COLUMNS). Idle gel surrounds a picture of another
    shape than a camera's.
    """
    across, down = SMALL_COLUMNS / IMAGE_SIDE, SMALL_ROWS / IMAGE_SIDE
    columns, rows = max(round(filled[1] * across), 2), max(round(filled[0] * down), 2)
    size = (columns, rows)
    how = (
        cv2.INTER_AREA
        if min(frame.shape[0] - rows, frame.shape[1] - columns) > 0
        else (cv2.INTER_LINEAR)
    )
    # Subtracted first, so that nothing is rounded.
    small = cv2.resize(cv2.subtract(frame, idle, dtype=cv2.CV_32F), size, interpolation=how)
    top, left = (SMALL_ROWS - rows) // 2, (SMALL_COLUMNS - columns) // 2
    if top == left == 0 and size == (SMALL_COLUMNS, SMALL_ROWS):
        return small
    bottom, right = SMALL_ROWS - rows - top, SMALL_COLUMNS - columns - left
    return cv2.copyMakeBorder(small, top, bottom, left, right, cv2.BORDER_CONSTANT, value=0)


def _cut(image: Floats, view: View) -> Floats:
    """Return the view's part of a small picture, `VIEW_SIDE` square; zero outside."""
    across, down = SMALL_COLUMNS / IMAGE_SIDE, SMALL_ROWS / IMAGE_SIDE
    wide, high = view.side_px / VIEW_SIDE * across, view.side_px / VIEW_SIDE * down
    left = (view.centre_x_px - view.side_px / 2) * across
    top = (view.centre_y_px - view.side_px / 2) * down
    back = np.array([[wide, 0, left + wide / 2 - 0.5], [0, high, top + high / 2 - 0.5]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(image, back, (VIEW_SIDE, VIEW_SIDE), flags=flags)


def _energy(residual: Floats) -> Floats:
    """Return the mean squared gradient in cells of `VIEW_CELL_PX`, (28, 28).

    In grey^2 per px^2 of the 224-pixel square, of the green picture doubled: video codecs keep most
    detail in green, and the floors of contrast were measured on it.
    """
    green = cv2.GaussianBlur(cv2.extractChannel(residual, 1), (3, 3), 0)
    right, down = gradients(green)
    right, down = right * (2 * SMALL_COLUMNS / IMAGE_SIDE), down * (2 * SMALL_ROWS / IMAGE_SIDE)
    return area_means(right * right + down * down, IMAGE_SIDE // VIEW_CELL_PX)


def _distinct(frames: NDArray[np.uint8]) -> tuple[list[NDArray[np.uint8]], list[int]]:
    """Return the frames that differ from the one before, and which of them stands at each place.

    A pair is fed as a, a, b, b, and an untouched gel as its idle frame alone: none is looked at
    twice.
    """
    distinct, places = [frames[0]], [0]
    for before, after in pairwise(frames):
        if not np.array_equal(before, after):
            distinct.append(after)
        places.append(len(distinct) - 1)
    return distinct, places


def _under_usual_lights(
    cells: list[Floats], lights: Lights, aspect: float
) -> tuple[list[Floats], Floats]:
    """Return pictures as under a GelSight Mini's lights, and their reliefs.

    Without it a recording turned by a quarter, whose lights come from where no training clip had
    them, is told worse: of 271 real turns 242 for 261.
    """
    if lights.are_one:
        cells = list(map(as_of_one_light, cells))
    elif lights.are_turned:
        cells = list(map(turned_by_a_quarter, cells))
    relief = reliefs(cells, aspect, are_lights_mirrored=lights.are_mirrored)
    if is_inside_out(relief):
        cells, relief = list(map(turned_by_a_half, cells)), -relief
    return cells, relief
