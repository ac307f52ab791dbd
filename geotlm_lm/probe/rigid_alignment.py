"""The second classical reference: direct alignment of neighbouring frames, thirty lines.

No learning and no knowledge of the simulator. The picture is the green channel less the idle gel;
on gels with markers the frames as they are tell as much.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np

from geotlm_lm.alignment.direct import Picture, Rigid, align
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import camera_size
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.probe.rigid_flow import (
    RigidMotion,
    classify_motion,
    imprint_contrast,
    residuals_of,
)

PIXELS = 160 * 120
"""Pixels of the pictures that are aligned, square on the gel."""


@dataclass(frozen=True)
class RigidAlignment:
    """Direct alignment of each frame with the one before, the motions chained."""

    def fit(self, clip: Clip) -> RigidMotion:
        """Measure the rigid motion of the imprint from the first frame to the last."""
        rows, columns = camera_size(*clip.frames.shape[1:3])
        shrink = (PIXELS / (rows * columns)) ** 0.5
        size = (max(round(columns * shrink), 8), max(round(rows * shrink), 8))
        residuals = residuals_of(clip)
        small = [cv2.resize(image, size, interpolation=cv2.INTER_AREA) for image in residuals]
        pictures = [Picture.of(residual) for residual in small]
        motion = Rigid()
        for before, after in zip(pictures[:-1], pictures[1:], strict=True):
            if not np.array_equal(before.image, after.image):
                motion = align(before, after).motion.after(motion)
        contrast = [imprint_contrast(residual) for residual in small]
        weight = np.mean(contrast, axis=0)
        down, right = np.indices(weight.shape) * (size[1] / weight.shape[0])
        total = max(float(weight.sum()), 1e-6)
        x, y = float((right * weight).sum()) / total, float((down * weight).sum()) / total
        travel = motion.travel(x - (size[0] - 1) / 2, y - (size[1] - 1) / 2)
        spread = weight * (np.square(right - x) + np.square(down - y))
        scale = columns / size[0]
        return RigidMotion(
            rotation_deg=float(np.degrees(motion.turn_rad)),
            slide_x_px=float(travel[0] * scale),
            slide_y_px=float(travel[1] * scale),
            radius_px=float(np.sqrt(spread.sum() / total) * scale),
            side_px=max(rows, columns),
            contrast=(float(contrast[0].mean()), float(contrast[-1].mean())),
        )

    def predict(self, clip: Clip, among: Iterable[Motion] = DIRECTED) -> Motion:
        """Return the motion, among those asked about, that the alignment speaks for."""
        return classify_motion(self.fit(clip), among)
