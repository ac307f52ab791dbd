"""A frame less the idle gel as it is aligned: small, in green, its pixels square on the gel."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.alignment.direct import Picture, Rigid
from geotlm_lm.backbone.imprint import area_means, gradients
from geotlm_lm.backbone.view import VIEW_CELL_PX, VIEW_RADII, View, contact_view
from geotlm_lm.core.clip import Frames
from geotlm_lm.core.geometry import IMAGE_SIDE, camera_size, filled_size

Floats = NDArray[np.float32]

COLUMNS = 168
"""Width of the whole picture: at 320 x 240 averaging keeps what a video codec has kept in green."""

CUT_COLUMNS = 112
"""Width of the part around the contact that frames are laid on each other in."""

LEVELS = 3

GREEN = 1


def small_green(frame: Frames) -> Floats:
    """Return the green of a frame, float32, `COLUMNS` wide, pixels square on the gel."""
    rows, columns = camera_size(*frame.shape[:2])
    size = (COLUMNS, max(round(COLUMNS * rows / columns), 8))
    shrinks = frame.shape[1] > COLUMNS and frame.shape[0] > size[1]
    how = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    return cv2.resize(cv2.extractChannel(frame, GREEN), size, interpolation=how).astype(np.float32)


@dataclass(frozen=True)
class Place:
    """The part of the picture around a contact: the same for all frames laid on one key frame.

    Args:
        view: In shares of the picture, whatever its shape.
        rows: Of the frame.
        columns: Of the frame.
    """

    view: View
    rows: int
    columns: int

    @classmethod
    def around(cls, residual: Floats, rows: int, columns: int) -> Place:
        """Return the place around what stands out from the idle gel."""
        smooth = cv2.GaussianBlur(residual, (3, 3), 0)
        right, down = gradients(smooth)
        # As the stem measures it: of the green picture doubled, per pixel of the 224-pixel square.
        scale = 2 * COLUMNS / IMAGE_SIDE
        energy = np.square(scale * right) + np.square(scale * down)
        return cls(contact_view([area_means(energy, IMAGE_SIDE // VIEW_CELL_PX)]), rows, columns)

    @property
    def radius_px(self) -> float:
        """Radius of the contact, pixels of the 224-pixel square."""
        return self.view.side_px / VIEW_RADII

    def picture(self, residual: Floats) -> Picture:
        """Return this part of a whole picture, made ready to be aligned."""
        rows, columns = residual.shape
        share = self.view.side_px / IMAGE_SIDE
        zoom = share * columns / CUT_COLUMNS
        size = (CUT_COLUMNS, max(round(CUT_COLUMNS * rows / columns), 8))
        left = (self.view.centre_x_px / IMAGE_SIDE - share / 2) * columns
        top = (self.view.centre_y_px / IMAGE_SIDE - share / 2) * rows
        back = np.array([[zoom, 0, left + (zoom - 1) / 2], [0, zoom, top + (zoom - 1) / 2]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return Picture.of(cv2.warpAffine(residual, back, size, flags=flags), LEVELS)

    @property
    def to_square(self) -> NDArray[np.float64]:
        """Pixels of the 224-pixel square per pixel of the part, right and down."""
        camera_rows, camera_columns = camera_size(self.rows, self.columns)
        filled_rows, filled_columns = filled_size(self.rows, self.columns)
        whole = np.array([filled_columns, filled_rows * camera_columns / camera_rows])
        return whole * (self.view.side_px / IMAGE_SIDE / CUT_COLUMNS)

    def travel(self, motion: Rigid) -> NDArray[np.float64]:
        """Return turn (degrees) and travel of the place's middle (pixels of the square), (3,)."""
        return np.array([np.degrees(motion.turn_rad), *(motion.travel(0, 0) * self.to_square)])
