"""The paper's classical reference for turns: hand-made curl of the shear, read by a logistic line.

The paper does not say how its shear is measured; here it is the dense optical flow of the imprint,
as in `rigid_flow`. Nothing in the features is learned.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import GRID_SIDE
from geotlm_lm.probe.rigid_flow import FIT_STRIDE, Field, RigidFlow

CURL_FEATURES = ("upper", "lower", "left", "right", "global")
"""Where the curl is averaged: the paper's halves and the whole."""

LEAST_CONTRAST_GREY = 1e-3
"""Contrast below which a patch shows nothing to weigh."""


def curl_features(clip: Clip) -> NDArray[np.float32]:
    """Return the mean curl of the imprint's travel from the first frame to the last, five numbers.

    They are in the order of `CURL_FEATURES`, weighted by the imprint's contrast; of a rigid turn
    twice its angle in rad, positive for clockwise. Without a background the mean frame stands for
    the idle gel.
    """
    field, weight, (step_x, step_y) = imprint_travel(clip)
    curl = np.gradient(field[..., 1], step_x, axis=1) - np.gradient(field[..., 0], step_y, axis=0)
    middle = GRID_SIDE // 2
    halves = (np.s_[:middle], np.s_[middle:], np.s_[:, :middle], np.s_[:, middle:], np.s_[:])
    means = [
        (curl[half] * weight[half]).sum() / (weight[half].sum() + LEAST_CONTRAST_GREY)
        for half in halves
    ]
    return np.array(means, np.float32)


def imprint_travel(clip: Clip) -> tuple[Field, Field, tuple[float, float]]:
    """Return the imprint's travel and its contrast on the patch grid.

    Returns:
        Travel (x right, y down), summed over neighbouring frames, (14, 14, 2), px of the frames the
        flow reads; contrast (14, 14), grey levels; and the size (x, y) of a patch in the same px.
    """
    fields, contrast, _ = RigidFlow().displacements(clip)
    grid = (GRID_SIDE, GRID_SIDE)
    total = np.zeros((*grid, 2), np.float32)
    for step, weight in zip(fields, contrast[:-1], strict=True):
        moved = cv2.resize(step * weight[..., None], grid, interpolation=cv2.INTER_AREA)
        seen = cv2.resize(weight, grid, interpolation=cv2.INTER_AREA)
        total += moved / (seen[..., None] + LEAST_CONTRAST_GREY)
    mean_contrast = np.mean(contrast, axis=0, dtype=np.float32)
    rows, columns = mean_contrast.shape
    patch_px = (FIT_STRIDE * columns / GRID_SIDE, FIT_STRIDE * rows / GRID_SIDE)
    return total, cv2.resize(mean_contrast, grid, interpolation=cv2.INTER_AREA), patch_px
