"""How well a picture holds each component of a motion: the Gauss-Newton matrix of its change.

The body alone is moved by a little each way, under a gel and lights that stay; what the shading of
the overlap changes by is one column of the Jacobian. What no other component could have changed is
what shows of a component: nothing of an edge's travel along itself, nothing of a smooth ball's
turn, whatever outline the domed pad gives the contact.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.core.twist import Twist
from geotlm_lm.simulation.contact import dome_mm
from geotlm_lm.simulation.idle import MEASURED_IDLE
from geotlm_lm.simulation.optics import turned_lights
from geotlm_lm.simulation.profile import Profile
from geotlm_lm.simulation.scene import Scene

Floats = NDArray[np.float32]

SIDE = 112
"""Side of the images that are shaded: detail of two pixels of the camera's is blurred anyway."""

STEP_PX, STEP_MM = 1.0, 0.05
"""How far the body is moved, of the 224-pixel image along the gel and into it."""

LEAST_OVERLAP_PX = 12
"""Touched pixels below which nothing is seen."""


def visible_change(
    scene: Scene,
    profile: Profile,
    frame: int,
    centre_mm: tuple[float, float],
    radius_px: float,
    twist: Twist,
) -> tuple[float, float, float]:
    """Return how much of the picture's change only turn, slide and press can have made.

    Args:
        scene: Gel, path and optics.
        profile: The body.
        frame: At which frame's pose it is looked at.
        centre_mm: Middle of the contact there, (x, y).
        radius_px: Radius of gyration of the contact.
        twist: The motion whose components are judged.

    Returns:
        RMS over the contact of each component's change, less what the other components could
        explain, in grey levels; of a slide along the axis that is seen least.
    """
    shaded = _Shaded(scene, profile, frame)
    base = shaded.at(0.0, 0.0, 0.0, 0.0, centre_mm)
    where = shaded.overlap > 0
    if np.count_nonzero(where) < LEAST_OVERLAP_PX:
        return 0.0, 0.0, 0.0
    wide, high = scene.optics.mm_per_px_x, scene.optics.mm_per_px_y
    turn = STEP_PX / max(radius_px, 1.0)
    moves = (
        (turn, 0, 0, 0),
        (0, STEP_PX * wide, 0, 0),
        (0, 0, STEP_PX * high, 0),
        (0, 0, 0, STEP_MM),
    )
    columns = []
    for move in moves:
        changed = shaded.at(*move, centre_mm) - base
        where = where | (shaded.overlap > 0)
        columns.append(changed)
    jacobian = np.stack([column[:, where].ravel() for column in columns]).astype(np.float64)
    normal = jacobian @ jacobian.T / jacobian.shape[1]
    covariance = np.linalg.inv(normal + 1e-6 * np.eye(4))
    steps = [
        np.radians(abs(twist.turn_deg)) * radius_px / STEP_PX,
        twist.slide_px / STEP_PX,
        abs(twist.inward_mm) / STEP_MM,
    ]
    worst = float(np.linalg.eigvalsh(covariance[1:3, 1:3])[-1])
    variances = (covariance[0, 0], worst, covariance[3, 3])
    return tuple(
        float(step / np.sqrt(variance)) for step, variance in zip(steps, variances, strict=True)
    )


class _Shaded:
    """A body's shading at one frame's pose, moved a little."""

    def __init__(self, scene: Scene, profile: Profile, frame: int) -> None:
        optics, path = scene.optics, scene.path
        self._scale = IMAGE_SIDE / SIDE
        self._pixel = (optics.mm_per_px_x * self._scale, optics.mm_per_px_y * self._scale)
        self._profile, self._optics = profile, optics
        self._pose = (path.x_mm[frame], path.y_mm[frame], path.rotation_rad[frame])
        self._level = np.float32(path.depth_mm[frame]) - dome_mm(
            scene.gel, self._pixel, SIDE, optics.mounting
        )
        self._lights = turned_lights(optics)
        self._grey = MEASURED_IDLE[:, 1:-1, 1:-1].mean(axis=(1, 2))
        self.overlap = np.zeros((SIDE, SIDE), np.float32)

    def at(
        self, turn_rad: float, x_mm: float, y_mm: float, inward_mm: float, centre: tuple
    ) -> Floats:
        """Return the change of the picture from the idle gel, (3, SIDE, SIDE), grey levels."""
        x, y, turn = self._pose
        cos, sin = np.cos(turn_rad), np.sin(turn_rad)
        from_x, from_y = x - centre[0], y - centre[1]
        pose = (
            centre[0] + cos * from_x - sin * from_y + x_mm,
            centre[1] + sin * from_x + cos * from_y + y_mm,
            turn + turn_rad,
        )
        overlap = (
            self._level + np.float32(inward_mm) - self._profile.sample(pose, self._pixel, SIDE)
        )
        self.overlap = cv2.GaussianBlur(cv2.max(overlap, 0), (0, 0), 0.8)
        slopes = [
            cv2.Sobel(self.overlap, cv2.CV_32F, *axis, ksize=3, scale=-0.125 / size)
            for axis, size in (((1, 0), self._pixel[0]), ((0, 1), self._pixel[1]))
        ]
        soft = np.sqrt(1 + self._optics.saturation**2 * (slopes[0] ** 2 + slopes[1] ** 2))
        return np.stack(
            [
                grey * ((right * slopes[0] + down * slopes[1]) / soft + gain * self.overlap)
                for grey, (right, down), gain in zip(
                    self._grey, self._lights, self._optics.depth_gain, strict=True
                )
            ]
        ).astype(np.float32)
