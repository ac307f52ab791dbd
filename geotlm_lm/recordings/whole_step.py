"""Steps of a whole picture, shading and rim with it, from one frame to the next."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Frames
from geotlm_lm.core.numbers import quantile_by_rank

Floats = NDArray[np.float32]
Shift = NDArray[np.float64]

STEP_SIZE = (40, 30)
"""Columns and rows that steps of the whole picture are measured at."""

STEP_SIGMA = 1.5
"""Blur there, pixels: markers, which gels move, vanish, and shading and rim stay."""

LEAST_STEP, MOST_SHIFT = 0.12, 4.0
"""Smallest step and largest shift that are taken out, pixels of 40: 2 and 64 of 640."""

LEAST_CHANGE = 0.6
"""Median squared change of a pixel, of all colours, below which nothing is fitted: a step of 2 px
of 640 makes 0.65 or more, nineteen in twenty steps of real recordings less than 0.7."""

EXPLAINED, EXPLAINED_QUARTER = 0.65, 0.4
"""Share of the change that one shift explains, of all of the picture as of its rim, and of each
quarter at the least. Of 9,594 sampled steps of real recordings none counts by these bounds, of all
steps of 434 recordings one does; of 540 pictures of two GelSight sets shifted by 2 to 30 px of 640
do 527, of 36 of a GelSlim 30."""

LEAST_LINEAR = 0.2
"""Share of the change that the first of four steps of the fit must explain, to save the others."""


def whole_step(before: Floats, after: Floats) -> Shift | None:
    """Return by how much all of a picture moved, right and down, pixels; None if it did not.

    Both are `STEP_SIZE`, colours, blurred. Least squares, pixels that do not fit down-weighted.
    """
    change = (after - before)[::2, ::2]
    change = np.square(change - change.mean(axis=(0, 1))).sum(axis=-1)
    if min(map(quantile_by_rank, (change, change[:, [0, 1, -2, -1]]))) < LEAST_CHANGE:
        return None
    shift, inner = np.zeros(2), slice(3, -3)
    weight: NDArray = np.ones(1)
    for _ in range(4):
        moved = warped(after, shift)
        across, down = (cv2.Sobel(moved, -1, *way, scale=1 / 8) for way in ((1, 0), (0, 1)))
        slopes = np.stack([across, down], axis=-1)[inner, inner]
        off = _centred((before - moved)[inner, inner])
        weighted = slopes * weight[..., None, None]
        normal = np.einsum("rcki,rckj->ij", weighted, slopes) + 1e-3 * np.eye(2)
        pull = np.einsum("rcki,rck->i", weighted, off)
        step = np.linalg.solve(normal, pull)
        error = np.square(off).sum(axis=-1)
        if not shift.any() and step @ pull < LEAST_LINEAR * error.sum():
            return None
        shift += np.clip(step, -2, 2)
        weight = 1 / np.square(1 + error / max(2 * np.median(error), 0.5))
    far = float(np.hypot(*shift))
    if not LEAST_STEP <= far <= MOST_SHIFT:
        return None
    return shift if _is_explained(before, after, shift) else None


def _is_explained(before: Floats, after: Floats, shift: Shift) -> bool:
    """Tell whether a shift explains the change of the picture, of its rim and of each quarter."""
    edge = 3 + int(np.ceil(np.abs(shift).max()))
    inner = slice(edge, -edge)
    was, left = (
        np.square(_centred((before - picture)[inner, inner])).sum(axis=-1)
        for picture in (after, warped(after, shift))
    )
    rows, columns = (np.arange(side) * 2 // side for side in was.shape)
    quarters = [np.ix_(rows == r, columns == c) for r in (0, 1) for c in (0, 1)]
    rim = np.ones(was.shape, bool)
    rim[3:-3, 3:-3] = False
    if min(1 - left.sum() / was.sum(), _fell(was[rim], left[rim])) < EXPLAINED:
        return False
    return min(_fell(was[part], left[part]) for part in quarters) >= EXPLAINED_QUARTER


def _fell(was: Floats, left: Floats) -> float:
    return 1 - float(np.median(left)) / max(float(np.median(was)), 1e-3)


def _centred(change: Floats) -> Floats:
    """Return a change of colours without that of the exposure."""
    return change - np.median(change.reshape(-1, 3), axis=0)


def small_frame(frame: Frames) -> Frames:
    """Return a frame in `STEP_SIZE`."""
    # Every other row tells as much: four of them make one.
    frame = frame[:: max(frame.shape[0] // (4 * STEP_SIZE[1]), 1)]
    return cv2.resize(frame, STEP_SIZE, interpolation=cv2.INTER_AREA)


def blurred(few: Frames) -> Floats:
    """Return a small frame as steps are measured in it, float32."""
    return cv2.GaussianBlur(few.astype(np.float32), (0, 0), STEP_SIGMA)


def warped(picture: Floats, shift: Shift) -> Floats:
    """Return a picture moved back by a shift, its edge continued."""
    matrix = np.array([[1, 0, shift[0]], [0, 1, shift[1]]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = picture.shape[1::-1]
    return cv2.warpAffine(picture, matrix, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
