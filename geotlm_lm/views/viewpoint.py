"""A small drawing of where the camera stands and which way a positive turn goes."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion

WIDTH, HEIGHT = 360, 150
_PAPER, _INK, _GEL, _OBJECT, _MARK = (
    (250, 250, 250),
    (60, 60, 60),
    (120, 190, 230),
    (190, 160, 110),
    (200, 60, 40),
)
_OBJECT_AT, _FACE_AT, _FACE_RADIUS = (150, 68), (290, 68), 44


def draw_viewpoint(frame: FrameSpec) -> NDArray[np.uint8]:
    """Return a drawing of sensor, gel, object and eye, and of a clockwise turn as the frame tells.

    Left: the sensor from the side, the eye where directions are told from. Right: the face that
    this eye sees, with an arrow for what the camera image shows as clockwise.

    Returns:
        uint8 RGB, shape (150, 360, 3).
    """
    image = np.full((HEIGHT, WIDTH, 3), _PAPER, np.uint8)
    cv2.rectangle(image, (30, 38), (100, 98), _INK, 2)
    cv2.rectangle(image, (100, 43), (114, 93), _GEL, -1)
    cv2.rectangle(image, (114, 53), (180, 83), _OBJECT, -1)
    eye = (55, 68) if frame.viewpoint == "sensor" else (212, 68)
    ahead = 1 if frame.viewpoint == "sensor" else -1
    cv2.ellipse(image, eye, (12, 8), 0, 0, 360, _INK, 2, cv2.LINE_AA)
    cv2.circle(image, (eye[0] + 4 * ahead, eye[1]), 4, _INK, -1, cv2.LINE_AA)
    cv2.arrowedLine(
        image, (eye[0] + 16 * ahead, 68), (eye[0] + 34 * ahead, 68), _INK, 2, cv2.LINE_AA
    )
    cv2.circle(image, _FACE_AT, _FACE_RADIUS, _OBJECT, -1, cv2.LINE_AA)
    _draw_turn(image, is_clockwise=frame.edit.of_way(Motion.CLOCKWISE) == Motion.CLOCKWISE)
    captions = {(36, 118): "sensor", (122, 118): "object", (236, 130): "as told"}
    for place, text in captions.items():
        cv2.putText(image, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.45, _INK, 1, cv2.LINE_AA)
    return image


def _draw_turn(image: NDArray[np.uint8], *, is_clockwise: bool) -> None:
    """Draw an arc with its head where the turn goes, over the face's upper half."""
    radius = _FACE_RADIUS - 12
    cv2.ellipse(image, _FACE_AT, (radius, radius), 0, 200, 340, _MARK, 3, cv2.LINE_AA)
    angle = np.radians(340 if is_clockwise else 200)
    tip = np.array(_FACE_AT) + radius * np.array([np.cos(angle), np.sin(angle)])
    # Rows run down: with the angle growing a point goes clockwise as drawn.
    along = np.array([-np.sin(angle), np.cos(angle)]) * (1 if is_clockwise else -1)
    across = np.array([-along[1], along[0]])
    corners = [tip + 12 * along, tip + 7 * across, tip - 7 * across]
    cv2.fillPoly(image, [np.rint(corners).astype(np.int32)], _MARK, cv2.LINE_AA)
