"""Direct alignment of two pictures over turn, shift, gain and offset.

Inverse-compositional Gauss-Newton (Baker and Matthews, IJCV 56, 2004): the earlier picture's
gradients are laid out once, the later one is warped back until the two agree. Nothing is learned
and nothing searched: it reaches turns of some 20 degrees, or shifts of a few pixels of its coarsest
level, beyond which a search has to start it (`alignment.search`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]

GRADIENT_SHARE = 0.4
"""Share of the pixels, those richest in gradient, that are compared."""

LEVELS = 2
"""Sizes at which two pictures are aligned, each half of the next, the coarsest first."""

ITERATIONS = 10
CLOSE_PX, COARSELY_CLOSE_PX = 0.02, 0.1
"""Most steps a level, and the step that ends them: at the finest, and at those before."""

HIGH_PASS_PX = 12.0
"""Deviation of the Gaussian bell whose mean is taken off: light that drifts tells no motion."""

EVEN_PX, EVEN_FLOOR_GREY = 6.0, 2.0
"""Neighbourhood over which contrast is made even, and contrast of noise, which stays faint."""


class Rigid(NamedTuple):
    """A turn about a picture's middle, then a shift, pixels being square."""

    turn_rad: float = 0.0  # positive clockwise as drawn
    right_px: float = 0.0
    down_px: float = 0.0

    def after(self, first: Rigid) -> Rigid:
        """Return `first` followed by this motion."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        x = cos * first.right_px - sin * first.down_px + self.right_px
        y = sin * first.right_px + cos * first.down_px + self.down_px
        return Rigid(self.turn_rad + first.turn_rad, x, y)

    def matrix(self, rows: int, columns: int) -> NDArray[np.float64]:
        """Return where a picture's pixels go, (2, 3), as OpenCV warps by it."""
        x, y = (columns - 1) / 2, (rows - 1) / 2
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        right, down = x + self.right_px, y + self.down_px
        return np.array(
            [[cos, -sin, right - cos * x + sin * y], [sin, cos, down - sin * x - cos * y]]
        )

    def less(self, first: Rigid) -> Rigid:
        """Return what follows `first` where both together are this motion."""
        turn = self.turn_rad - first.turn_rad
        cos, sin = math.cos(turn), math.sin(turn)
        x = self.right_px - cos * first.right_px + sin * first.down_px
        y = self.down_px - sin * first.right_px - cos * first.down_px
        return Rigid(turn, x, y)

    def travel(self, x_px: float, y_px: float) -> tuple[float, float]:
        """Return how far what is now right of and below the middle has come, right and down."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        x, y = x_px - self.right_px, y_px - self.down_px
        return x_px - (cos * x + sin * y), y_px - (-sin * x + cos * y)


@dataclass(frozen=True, eq=False)
class Aligned:
    """How a picture is laid on an earlier one."""

    motion: Rigid  # from the earlier to the later
    # Of turn times half the picture's longer side, right and down, px^2, for a residual of
    # deviation 1; (3, 3).
    covariance: NDArray[np.float64]
    residual: float  # deviation of what is left between the two, grey levels
    contrast: float  # deviation of the earlier one where they are compared, grey levels

    @property
    def correlation(self) -> float:
        """Share of the contrast that the motion explains, from 0 to 1."""
        explained = 1 - self.residual**2 / max(self.contrast**2, 1e-12)
        return math.sqrt(min(max(explained, 0.0), 1.0))


class _Level:
    """A picture at one size, and what its gradients tell of motion, once somebody asks."""

    def __init__(self, image: Floats) -> None:
        self.image = image

    @property
    def lever_px(self) -> float:
        """Radius at which a turn counts in pixels."""
        return max(self.image.shape) / 2

    @cached_property
    def compared(self) -> NDArray[np.intp]:
        """Places, in the flattened picture, of the n pixels that are compared."""
        steepness = cv2.magnitude(*self._gradients).ravel()
        # A third of the pixels tells the bound as well.
        sample = steepness[::3] if steepness.size > SMALL_SAMPLE else steepness
        place = int(sample.size * (1 - GRADIENT_SHARE))
        places = np.flatnonzero(steepness >= np.partition(sample, place)[place])
        return places[:: 1 + places.size // MOST_COMPARED]

    @cached_property
    def places(self) -> Floats:
        """How far right of and below the middle the pixels compared lie, and ones, (3, n)."""
        return _places(*self.image.shape).take(self.compared, axis=1)

    @cached_property
    def jacobian(self) -> Floats:
        """Change of each pixel compared with turn (at `lever_px`), right, down, gain, offset."""
        right, down = (field.take(self.compared) for field in self._gradients)
        x, y, _ = self.places
        jacobian = np.empty((5, len(right)), np.float32)
        jacobian[0] = (down * x - right * y) * np.float32(1 / self.lever_px)
        jacobian[1], jacobian[2], jacobian[3] = right, down, self.values
        jacobian[4] = 1
        return jacobian

    @cached_property
    def values(self) -> Floats:
        """The pixels compared, (n,)."""
        return self.image.take(self.compared)

    @cached_property
    def inverse(self) -> NDArray[np.float64]:
        """Of the normal matrix, (5, 5)."""
        # A copy: of one and the same array numpy takes a product that is five times slower.
        return _inverse(self.jacobian.copy() @ self.jacobian.T)

    @cached_property
    def solver(self) -> Floats:
        """Matrix from the pixels' errors to a step, (5, n)."""
        return self.inverse.astype(np.float32) @ self.jacobian

    @cached_property
    def contrast(self) -> float:
        """Deviation of the pixels compared."""
        return float(cv2.meanStdDev(self.values)[1].item())

    def solver_of_change(self, later: Floats, still_grey: float, least: float) -> Floats:
        """Return the same, weighing each pixel by how much it changes from this picture on."""
        change = cv2.GaussianBlur(cv2.subtract(later, self.image), (0, 0), 1.0)
        change = np.square(change.take(self.compared))
        weighted = self.jacobian * (change / (change + still_grey**2) + least)
        return _inverse(weighted @ self.jacobian.T).astype(np.float32) @ weighted

    def seen_in(self, later: Floats, motion: Rigid) -> Floats:
        """Return where a motion takes the pixels compared in a later picture, (n,); 0 outside."""
        rows, columns = self.image.shape
        cos, sin = math.cos(motion.turn_rad), math.sin(motion.turn_rad)
        right, down = (columns - 1) / 2 + motion.right_px, (rows - 1) / 2 + motion.down_px
        way = np.array([[cos, -sin, right], [sin, cos, down]], np.float32)
        x, y = way @ self.places
        return cv2.remap(later, x[None], y[None], cv2.INTER_LINEAR)[0]

    @cached_property
    def _gradients(self) -> tuple[Floats, Floats]:
        right = cv2.Sobel(self.image, cv2.CV_32F, 1, 0, scale=1 / 8)
        return right, cv2.Sobel(self.image, cv2.CV_32F, 0, 1, scale=1 / 8)


SMALL_SAMPLE = 2000

MOST_COMPARED = 30_000
"""OpenCV looks up no more than 32,767 pixels in a row."""

WORSE = 1.2
"""Squared error over that at the start from which on steps have lost their way."""
LEAST_WEIGHT = 0.02
"""Weight of a pixel that has not changed at all: stillness must stay found."""


@lru_cache(maxsize=16)
def _places(rows: int, columns: int) -> Floats:
    """Return how far right of and below the middle a picture's pixels lie, and ones, (3, n)."""
    down, right = np.indices((rows, columns), np.float32)
    right, down = right - (columns - 1) / 2, down - (rows - 1) / 2
    return np.stack([right.ravel(), down.ravel(), np.ones(rows * columns, np.float32)])


def _inverse(normal: Floats) -> NDArray[np.float64]:
    damped = normal.astype(np.float64)
    damped.flat[:: len(damped) + 1] *= 1 + 1e-4
    damped.flat[:: len(damped) + 1] += 1e-6
    return cv2.invert(damped)[1]


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture made ready to be aligned, coarse to fine."""

    levels: tuple[_Level, ...]

    @classmethod
    def of(cls, image: Floats, levels: int = LEVELS) -> Picture:
        """Prepare a grey picture of any size, best some 100 to 160 pixels wide."""
        sizes = [cv2.GaussianBlur(image - _slow(image, HIGH_PASS_PX), (0, 0), 1.0)]
        for _ in range(levels - 1):
            rows, columns = sizes[0].shape
            half = (max(columns // 2, 1), max(rows // 2, 1))
            sizes.insert(0, cv2.resize(sizes[0], half, interpolation=cv2.INTER_AREA))
        return cls(tuple(map(_Level, sizes)))

    def even(self) -> Picture:
        """Return its finest level in even contrast: faint detail counts as much as an outline.

        A cap's rim outshines its knurls and looks alike however far it turns.
        """
        energy = _slow(np.square(self.image), EVEN_PX).clip(min=0)
        return Picture((_Level(self.image / (np.sqrt(energy) + EVEN_FLOOR_GREY)),))

    @property
    def image(self) -> Floats:
        """The finest picture, high-passed."""
        return self.levels[-1].image


def _slow(image: Floats, deviation_px: float) -> Floats:
    """Return the mean under a Gaussian bell, found in a picture a quarter as wide."""
    rows, columns = image.shape
    quarter = (max(columns // 4, 1), max(rows // 4, 1))
    small = cv2.resize(image, quarter, interpolation=cv2.INTER_AREA)
    small = cv2.GaussianBlur(small, (0, 0), deviation_px / 4)
    return cv2.resize(small, (columns, rows), interpolation=cv2.INTER_LINEAR)


def align(
    before: Picture,
    after: Picture,
    start: Rigid | None = None,
    *,
    still_grey: float | None = None,
    least_weight: float = LEAST_WEIGHT,
    levels: int | None = None,
) -> Aligned:
    """Return the motion that lays `before` on `after`, which is of the same size.

    Args:
        before: Earlier picture.
        after: Later picture.
        start: Where to begin; None at rest.
        still_grey: Difference of the two, in their units, at which a pixel weighs half; None weighs
            all alike. A domed pad holds a flat object's outline where it is while the object turns:
            what does not change must not hold the fit back.
        least_weight: Then added to every weight, which are 1 at the most; a large one makes them
            alike again.
        levels: How many sizes are used, the finest ones; None uses all.
    """
    motion = start or Rigid()
    width = before.image.shape[1]
    used = slice(None if levels is None else -levels, None)
    for level, other in zip(before.levels[used], after.levels[used], strict=True):
        scale = level.image.shape[1] / width
        motion = Rigid(motion.turn_rad, motion.right_px * scale, motion.down_px * scale)
        close_px = CLOSE_PX if level is before.levels[-1] else COARSELY_CLOSE_PX
        weights = (still_grey, least_weight)
        motion, error = _refined(level, other.image, motion, weights, close_px)
        motion = Rigid(motion.turn_rad, motion.right_px / scale, motion.down_px / scale)
    finest = before.levels[-1]
    residual = math.sqrt(float(error @ error) / error.size)
    return Aligned(motion, finest.inverse[:3, :3], residual, finest.contrast)


def _refined(
    level: _Level,
    later: Floats,
    motion: Rigid,
    weights: tuple[float | None, float],
    close_px: float,
) -> tuple[Rigid, Floats]:
    """Return the motion after Gauss-Newton steps, and what is left of each pixel compared.

    Steps that leave clearly more than there was at the start have lost their way and are undone.
    """
    solve, (still_grey, least) = level.solver, weights
    if still_grey is not None:
        solve = level.solver_of_change(later, still_grey, least)
    start, lever_px = None, level.lever_px
    for _ in range(ITERATIONS):
        error = level.seen_in(later, motion) - level.values
        turn, right, down, gain, offset = (solve @ error).tolist()
        if start is None:
            start = motion, error - offset - gain * level.values
        # A picture of more contrast is steeper by as much: its steps would be too long. Those of a
        # fainter one are too short, which only takes longer; made longer, where little is alike,
        # they would jump to the next marker.
        steeper = max(1 + gain, 1.0)
        turn, right, down = turn / steeper, right / steeper, down / steeper
        motion = motion.less(Rigid(turn / lever_px, right, down))
        if max(abs(turn), abs(right), abs(down)) < close_px:
            break
    left = error - offset - gain * level.values
    return (motion, left) if left @ left <= WORSE * (start[1] @ start[1]) else start
