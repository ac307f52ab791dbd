"""Direct alignment of two pictures over turn, shift, gain and offset.

Inverse-compositional Gauss-Newton (Baker and Matthews, IJCV 56, 2004): the earlier picture's
gradients are laid out once, the later one is warped back until the two agree. Nothing is learned
and nothing searched: it reaches turns of some 20 degrees, or shifts of a few pixels of its coarsest
level, beyond which a search has to start it (`alignment.search`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]

GRADIENT_SHARE = 0.4
"""Share of the pixels, those richest in gradient, that are compared."""

LEVELS = 2
"""Sizes at which two pictures are aligned, each half of the next, the coarsest first."""

ITERATIONS = 10
CLOSE_PX = 0.02
"""Most steps a level, and the step that ends it."""

HIGH_PASS_PX = 12.0
"""Deviation of the Gaussian bell whose mean is taken off: light that drifts tells no motion."""


@dataclass(frozen=True)
class Rigid:
    """A turn about a picture's middle, then a shift, pixels being square.

    Args:
        turn_rad: Positive clockwise as drawn.
        right_px: Shift to the right.
        down_px: Shift down.
    """

    turn_rad: float = 0.0
    right_px: float = 0.0
    down_px: float = 0.0

    def after(self, first: Rigid) -> Rigid:
        """Return `first` followed by this motion."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        x = cos * first.right_px - sin * first.down_px + self.right_px
        y = sin * first.right_px + cos * first.down_px + self.down_px
        return Rigid(self.turn_rad + first.turn_rad, x, y)

    def inverse(self) -> Rigid:
        """Return the motion that takes this one back."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        x = -(cos * self.right_px + sin * self.down_px)
        y = sin * self.right_px - cos * self.down_px
        return Rigid(-self.turn_rad, x, y)

    def travel(self, x_px: float, y_px: float) -> tuple[float, float]:
        """Return how far the point that is now at a place has come, right and down.

        Args:
            x_px: Place to the right of the picture's middle.
            y_px: Place below it.
        """
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        x, y = x_px - self.right_px, y_px - self.down_px
        return x_px - (cos * x + sin * y), y_px - (-sin * x + cos * y)


@dataclass(frozen=True, eq=False)
class Aligned:
    """How a picture is laid on an earlier one.

    Args:
        motion: From the earlier to the later.
        covariance: Of turn times half the picture's longer side, right and down, px^2, for a
            residual of deviation 1; (3, 3).
        residual: Deviation of what is left between the two, grey levels.
        contrast: Deviation of the earlier one where they are compared, grey levels.
    """

    motion: Rigid
    covariance: NDArray[np.float64]
    residual: float
    contrast: float

    @property
    def correlation(self) -> float:
        """Share of the contrast that the motion explains, from 0 to 1."""
        explained = 1 - self.residual**2 / max(self.contrast**2, 1e-12)
        return math.sqrt(min(max(explained, 0.0), 1.0))


@dataclass(frozen=True, eq=False)
class _Level:
    """A picture at one size, and what its gradients tell of motion.

    Args:
        image: The picture.
        where: Places of the pixels compared, in the flattened picture.
        jacobian: Change of each with turn (at `lever_px`), right, down, gain, offset; (5, n).
        inverse: Of the normal matrix, (5, 5).
        lever_px: Radius at which a turn counts in pixels.
    """

    image: Floats
    where: NDArray[np.intp]
    jacobian: Floats
    inverse: NDArray[np.float64]
    lever_px: float


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture made ready to be aligned, coarse to fine."""

    levels: tuple[_Level, ...]

    @classmethod
    def of(cls, image: Floats, levels: int = LEVELS) -> Picture:
        """Prepare a grey picture.

        Args:
            image: float32, any size, best some 100 to 160 pixels wide.
            levels: Sizes at which it is aligned.
        """
        image = image - cv2.GaussianBlur(image, (0, 0), HIGH_PASS_PX)
        sizes = [cv2.GaussianBlur(image, (0, 0), 1.0)]
        for _ in range(levels - 1):
            rows, columns = sizes[0].shape
            half = (max(columns // 2, 1), max(rows // 2, 1))
            sizes.insert(0, cv2.resize(sizes[0], half, interpolation=cv2.INTER_AREA))
        return cls(tuple(_level(size) for size in sizes))

    @property
    def image(self) -> Floats:
        """The finest picture, high-passed."""
        return self.levels[-1].image


def align(
    before: Picture,
    after: Picture,
    start: Rigid | None = None,
    *,
    still_grey: float | None = None,
) -> Aligned:
    """Return the motion that lays `before` on `after`.

    Args:
        before: Earlier picture.
        after: Later picture, of the same size.
        start: Where to begin; None at rest.
        still_grey: Difference of the two, in their units, at which a pixel weighs half; None weighs
            all alike. A domed pad holds a flat object's outline where it is while the object turns:
            what does not change must not hold the fit back.
    """
    motion = start or Rigid()
    width = before.image.shape[1]
    for level, other in zip(before.levels, after.levels, strict=True):
        scale = level.image.shape[1] / width
        motion = Rigid(motion.turn_rad, motion.right_px * scale, motion.down_px * scale)
        motion, error = _refined(level, other.image, motion, still_grey)
        motion = Rigid(motion.turn_rad, motion.right_px / scale, motion.down_px / scale)
    finest = before.levels[-1]
    values = finest.image.ravel()[finest.where]
    return Aligned(
        motion,
        finest.inverse[:3, :3],
        float(np.sqrt(np.square(error).mean())),
        float(values.std()),
    )


def _level(image: Floats) -> _Level:
    rows, columns = image.shape
    right = cv2.Sobel(image, cv2.CV_32F, 1, 0, scale=1 / 8)
    down = cv2.Sobel(image, cv2.CV_32F, 0, 1, scale=1 / 8)
    energy = (right * right + down * down).ravel()
    count = max(int(energy.size * GRADIENT_SHARE), 1)
    where = np.argpartition(energy, energy.size - count)[energy.size - count :]
    y, x = np.divmod(where, columns)
    x, y = x - (columns - 1) / 2, y - (rows - 1) / 2
    lever = max(rows, columns) / 2
    right, down, values = (one.ravel()[where] for one in (right, down, image))
    turn = (down * x - right * y) / lever
    jacobian = np.stack([turn, right, down, values, np.ones_like(values)]).astype(np.float32)
    normal = (jacobian @ jacobian.T).astype(np.float64)
    normal += np.diag(1e-4 * np.diag(normal) + 1e-6)
    return _Level(image, where, jacobian, np.linalg.inv(normal), lever)


LEAST_WEIGHT = 0.02
"""Weight of a pixel that has not changed at all: stillness must stay found."""


def _solver(level: _Level, later: Floats, still_grey: float | None) -> Floats:
    """Return the matrix from the pixels' errors to a step, (5, n)."""
    if still_grey is None:
        return level.inverse.astype(np.float32) @ level.jacobian
    change = np.square(cv2.GaussianBlur(later - level.image, (0, 0), 1.0)).ravel()[level.where]
    weighted = level.jacobian * (change / (change + still_grey**2) + LEAST_WEIGHT)
    normal = (weighted @ level.jacobian.T).astype(np.float64)
    normal += np.diag(1e-4 * np.diag(normal) + 1e-6)
    return np.linalg.inv(normal).astype(np.float32) @ weighted


def _refined(
    level: _Level, later: Floats, motion: Rigid, still_grey: float | None
) -> tuple[Rigid, Floats]:
    """Return the motion after Gauss-Newton steps, and what is left of each pixel compared."""
    rows, columns = level.image.shape
    x, y = (columns - 1) / 2, (rows - 1) / 2
    earlier = level.image.ravel()[level.where]
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    solve = _solver(level, later, still_grey)
    for _ in range(ITERATIONS):
        cos, sin = math.cos(motion.turn_rad), math.sin(motion.turn_rad)
        way = np.array(
            [
                [cos, -sin, x + motion.right_px - cos * x + sin * y],
                [sin, cos, y + motion.down_px - sin * x - cos * y],
            ]
        )
        warped = cv2.warpAffine(later, way, (columns, rows), flags=flags)
        error = warped.ravel()[level.where] - earlier
        turn, right, down, gain, offset = (solve @ error).tolist()
        motion = motion.after(Rigid(turn / level.lever_px, right, down).inverse())
        if max(abs(turn), abs(right), abs(down)) < CLOSE_PX:
            break
    error = error - gain * level.jacobian[3] - offset
    return motion, error
