"""How each frame lies on the frame before and on a key frame, both fused: motion without drift.

Steps from frame to frame add up their errors, and tell too little: a small step drowns in noise and
under what the pad holds back. A frame laid on one far back in time tells the whole of the motion
between them at once, as long as the two still look alike. So a key frame is kept; each frame is
laid on the frame before it, which begins the search, and on the key frame; and when little of the
key frame is left to be seen, the frame at hand becomes the next one.

The pose since the key frame is a Gaussian over turn (at half the picture's width), right and down.
A step moves it and widens it by the step's own covariance; what is found against the key frame is
fused in by covariances (information form, as a Kalman filter does with one measurement of the whole
pose). On the key frame it is laid in even contrast, and what stands still weighs little: a domed
pad holds back the outline of what turns in it. Not so where the imprint is faint: there what is
soft deforms. A share of each way is doubted besides, more of a step's than of a long way's: that is
no noise, and does not average out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.alignment.direct import LEAST_WEIGHT, Aligned, Picture, Rigid, align
from geotlm_lm.alignment.search import align_or_search
from geotlm_lm.backbone.imprint import area_means, gradients
from geotlm_lm.backbone.motions import STILL_EVEN
from geotlm_lm.backbone.view import VIEW_CELL_PX, VIEW_RADII, View, contact_view
from geotlm_lm.core.clip import Frames
from geotlm_lm.core.geometry import IMAGE_SIDE, camera_size, filled_size

Floats = NDArray[np.float32]
Matrix = NDArray[np.float64]

COLUMNS = 168
"""Width of the whole picture: at 320 x 240 averaging keeps what a video codec has kept in green."""

CUT_COLUMNS = 112
"""Width of the part around the contact that frames are laid on each other in."""

LEVELS = 3

GREEN = 1

ALIKE = 0.9
"""Correlation with the key frame below which the next one is laid."""

LOST = 0.6
"""Correlation below which a motion that was found is doubted and a search is made."""

FARTHEST_DEG, FARTHEST_SHARE = 30.0, 0.25
"""Turn, and shift as a share of the picture, beyond which the next key frame is laid."""

STRONGER = 1.25
"""Ratio of an imprint's contrast to the key frame's, likewise: a press changes what is seen."""

FAINT_GREY = 8.0
"""Contrast of a key frame below which what stands still weighs as much as what moves. Simulated
imprints, of which too little is told, lie mostly above; real ones mostly below."""

STEP_SHARE, KEY_SHARE = 0.15, 0.04
"""Shares of a step's and of a key frame's way that are doubted beside the noise."""

NOISE_PX = 0.05
"""Least deviation of either."""

ALL_ALIKE = 1e4
"""Weight beside which all others are none."""

LEVER_PX = CUT_COLUMNS / 2
"""Radius at which a turn's path is measured."""

CORRELATED = 4.0
"""Neighbouring pixels' errors are alike: so much larger is a deviation than theirs alone tell."""

UNKNOWN = (20.0, 20.0, 20.0)
"""Deviation of a step that was not found: the pictures share nothing."""


def small_green(frame: Frames) -> Floats:
    """Return the green of a frame, float32, `COLUMNS` wide, pixels square on the gel."""
    rows, columns = camera_size(*frame.shape[:2])
    size = (COLUMNS, max(round(COLUMNS * rows / columns), 8))
    shrinks = frame.shape[1] > COLUMNS and frame.shape[0] > size[1]
    how = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    return cv2.resize(cv2.extractChannel(frame, GREEN), size, interpolation=how).astype(np.float32)


@dataclass(frozen=True)
class Place:
    """The part of a frame around a contact: the same for all frames laid on one key frame."""

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


class Residuals(NamedTuple):
    """A frame less the untouched gel, both as of `small_green`."""

    seen: Floats  # less the idle gel: where it is touched
    moving: Floats  # the same, with the dots left in of a gel that has them: how that moves


@dataclass(frozen=True, eq=False)
class Step:
    """How the contact moved from the frame before to this one."""

    twist: Matrix  # turn (degrees), right and down (pixels of the 224-pixel square), (3,)
    covariance: Matrix  # of the same, (3, 3): what this step adds to the doubt of the whole way
    correlation: float  # how alike the frame and the one it was laid on are
    is_lost: bool = False  # whether nothing was found: the motion is unknown


class KeyFrames:
    """Follows one contact from its first frame to its last.

    Rows and columns are those of the frames themselves.
    """

    def __init__(self, residuals: Residuals, rows: int, columns: int) -> None:
        self._size = (rows, columns)
        self._before = Rigid()
        self._lay(residuals)

    @property
    def place(self) -> Place:
        """Where in the picture the contact is."""
        return self._place

    def next(self, residuals: Residuals) -> Step:
        """Lay the next frame on those before it."""
        picture = self._place.picture(residuals.moving)
        step = align_or_search(self._last, picture, self._before)
        is_lost = step.correlation < LOST / 2
        motion = Rigid() if is_lost else step.motion
        widened = np.diag(np.square(UNKNOWN)) if is_lost else _doubt(step, STEP_SHARE)
        pose, covariance = motion.after(self._pose), self._covariance + widened
        on_key = align(self._key, picture, pose, levels=2)
        is_seen = on_key.correlation > LOST
        if is_seen:
            faint = (FAINT_GREY / max(self._key.levels[-1].contrast, 1e-6)) ** 4
            weight = LEAST_WEIGHT + min(faint, ALL_ALIKE)
            how = {"still_grey": STILL_EVEN, "least_weight": weight, "levels": 1}
            on_even = align(self._even, picture.even(), on_key.motion, **how)
            pose, covariance = _fused(pose, covariance, on_even)
        taken = pose.less(self._pose)
        result = Step(
            self._place.travel(taken),
            self._in_square(covariance - self._covariance),
            step.correlation,
            is_lost and not is_seen,
        )
        self._pose, self._covariance, self._last = pose, covariance, picture
        self._before = step.motion if step.correlation > ALIKE else Rigid()
        if self._is_far(on_key, picture):
            self._lay(residuals)
        return result

    def _lay(self, residuals: Residuals) -> None:
        self._place = Place.around(residuals.seen, *self._size)
        self._key = self._last = self._place.picture(residuals.moving)
        self._even = self._key.even()
        self._pose, self._covariance = Rigid(), np.zeros((3, 3))
        # The picture's pixels may be others now: the last step is no start any more.
        self._before = Rigid(self._before.turn_rad)

    def _is_far(self, on_key: Aligned, picture: Picture) -> bool:
        pose, side = self._pose, max(picture.image.shape)
        ratio = picture.levels[-1].contrast / max(self._key.levels[-1].contrast, 1e-6)
        return (
            on_key.correlation < ALIKE
            or abs(math.degrees(pose.turn_rad)) > FARTHEST_DEG
            or math.hypot(pose.right_px, pose.down_px) > FARTHEST_SHARE * side
            or not 1 / STRONGER < ratio < STRONGER
        )

    def _in_square(self, covariance: Matrix) -> Matrix:
        """Return a covariance of the part's pixels in degrees and pixels of the square."""
        scale = np.diag([math.degrees(1 / LEVER_PX), *self._place.to_square])
        # Fusing takes doubt away; what a step adds is none at the least.
        values, vectors = np.linalg.eigh(covariance)
        return scale @ (vectors * values.clip(min=NOISE_PX**2 / 100)) @ vectors.T @ scale


def _doubt(aligned: Aligned, share: float) -> Matrix:
    noise = aligned.covariance * (CORRELATED * aligned.residual) ** 2
    return noise + np.diag(np.square(share * _paths(aligned.motion)) + NOISE_PX**2)


def _fused(pose: Rigid, covariance: Matrix, on_key: Aligned) -> tuple[Rigid, Matrix]:
    path = _paths(pose)
    gain = covariance @ np.linalg.inv(covariance + _doubt(on_key, KEY_SHARE))
    turn, right, down = path + gain @ (_paths(on_key.motion) - path)
    return Rigid(turn / LEVER_PX, right, down), (np.eye(3) - gain) @ covariance


def _paths(motion: Rigid) -> Matrix:
    """Return turn (at half the picture's width), right and down, pixels."""
    return np.array([motion.turn_rad * LEVER_PX, motion.right_px, motion.down_px])
