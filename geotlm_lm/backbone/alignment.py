"""The rigid motion that lays one image of the imprint on the next, found in the whole view at once.

Dense flow sees a patch at a time: along an edge it is blind, and a turn of many degrees is beyond
its reach. A touched object is rigid, so that three numbers explain every patch together. Measured
on 966 simulated turns and slides of objects outside of training: this motion alone tells the sense
of 0.99 of the turns and the way of 0.97 of the slides, without anything learned.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.core.geometry import GRID_SIDE, IMAGE_SIDE
from geotlm_lm.core.ranked import ranked

Floats = NDArray[np.float32]

SIDE = 56
"""Side of the images that are aligned; finer ones gained nothing and took three times as long."""

CHANNELS = 6
"""Displacement x and y, laid on the first frame; the same summed over the steps; gain of the last
step's alignment over rest; its correlation. Where the two displacements differ, neither is sure."""

TURNS_RAD = np.radians(np.arange(-45.0, 45.1, 9.0)).astype(np.float32)
"""Turns that are searched; the refinement reaches half a step. On 770 pairs of simulated frames it
ends within a pixel of where steps of 5 degrees lead it, in all but 0.7 % within a quarter of one;
steps of 10 degrees leave 2.9 % off by more than a pixel."""

PRIOR_PER_PX2 = 2e-4
"""Loss of correlation per squared pixel of travel: of two equal matches, as a knurled cap has many,
the shorter way is meant."""

TURN_RADIUS_PX = 10.0
"""Radius at which a turn's path counts as travel in the prior."""

REFINEMENTS = 8
"""Most Gauss-Newton steps; of 600 pairs of images 0.71 needed four or fewer, 0.10 all."""

CLOSE_PX = 0.04
"""Step that ends the refinement; half of it moves the displacements told by 1 % of their deviation
and takes the stem 3 % longer."""

CHANGE = 0.15
"""Difference of two images, in their units, at which a pixel weighs half. The pad is domed, so that
a flat object's outline stays where it is while the object turns: what does not change must not hold
the fit back. Measured on the turns above: the fit finds 0.86 of a turn (median; lower quartile
0.62), without these weights 0.58 (0.28), as the lights' own unevenness and the idle gel's noise
stand still too."""

CHANGE_BLUR_PX = 1.0
"""Blur of the difference, against camera noise."""

FEWEST_CHANGED = 50
"""Changed pixels from which on a median of their errors means something."""

LEAST_WEIGHT = 0.02
"""Weight of a pixel that has not changed at all: stillness must stay found."""

ERROR_FLOOR = 0.003
"""Squared error, in units of the images, that noise alone leaves behind."""

_PADDED = 64  # a fast length with room for shifts beyond the border
_MIDDLE = (SIDE - 1) / 2


@dataclass(frozen=True)
class Rigid:
    """A turn about the middle of the view, then a shift.

    Args:
        turn_rad: Positive clockwise as drawn.
        x_px: Shift to the right, pixels of the aligned images.
        y_px: Shift down.
        aspect: Width of a pixel over its height; a turn is rigid on the gel, not in an image that
            was squashed to a square.
    """

    turn_rad: float = 0.0
    x_px: float = 0.0
    y_px: float = 0.0
    aspect: float = 1.0

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The turn in pixels, (2, 2)."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        return np.array([[cos, -sin / self.aspect], [sin * self.aspect, cos]])

    def after(self, first: Rigid) -> Rigid:
        """Return `first` followed by this motion."""
        (a, b), (c, d) = self.matrix.tolist()
        x = a * first.x_px + b * first.y_px + self.x_px
        y = c * first.x_px + d * first.y_px + self.y_px
        return Rigid(self.turn_rad + first.turn_rad, x, y, self.aspect)

    def way_back(self) -> NDArray[np.float64]:
        """Return where each pixel after the motion came from, an affine map (2, 3)."""
        (a, b), (c, d) = self._back().tolist()
        x, y = _MIDDLE + self.x_px, _MIDDLE + self.y_px
        return np.array([[a, b, _MIDDLE - a * x - b * y], [c, d, _MIDDLE - c * x - d * y]])

    def moved(self, image: Floats) -> Floats:
        """Return a square image of side `SIDE` after the motion; zero comes in from outside."""
        return _warped(image, self.way_back())

    def displacement(self) -> Floats:
        """Return how far the point now under each patch centre has come, (14, 14, 2), pixels."""
        centres = np.stack(_patch_centres(), axis=-1)
        return centres - (centres - np.float32([self.x_px, self.y_px])) @ self._back().T

    def _back(self) -> NDArray[np.float32]:
        """Return the turn back, (2, 2)."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        return np.array([[cos, sin / self.aspect], [-sin * self.aspect, cos]], np.float32)


def alignment(reliefs: Sequence[Floats], greens: Sequence[Floats], aspect: float = 1.0) -> Floats:
    """Align each frame with the one before, then with the first, by relief and green residual.

    The steps' errors add up, so that a small motion is surer laid on the first frame directly. On
    734 simulated turns and slides of objects outside of training a small network told the ten
    motions at 0.914 and 0.961 from the sums, 0.921 and 0.977 from both.

    Args:
        reliefs: Relief of each frame, any square size, about one unit deep.
        greens: Green residual of each frame, likewise.
        aspect: Width of a pixel over its height.

    Returns:
        float32 (frames, 14, 14, 2 * CHANNELS), the relief's channels first: displacement since the
        first frame in pixels of the 224-pixel view (x right, y down), found directly and as a sum;
        log of how many times larger the patch's squared error is without the last step's motion;
        correlation after that step.
    """
    reliefs, greens = ([_small(image) for image in images] for images in (reliefs, greens))
    at_rest = np.zeros((GRID_SIDE, GRID_SIDE, CHANNELS), np.float32)
    at_rest[..., -1] = 1
    frames = [np.concatenate([at_rest, at_rest], axis=-1)]
    direct = [Rigid(aspect=aspect)] * 2
    summed = [Rigid(aspect=aspect)] * 2
    for k in range(1, len(reliefs)):
        start, parts = None, []
        for place, images in enumerate((reliefs, greens)):
            before, after = images[k - 1], images[k]
            step = start = align(before, after, start, aspect=aspect)
            summed[place] = direct[place] = step.after(summed[place])
            if k > 1:
                direct[place] = align(images[0], after, direct[place], aspect=aspect)
            totals = (direct[place], summed[place])
            parts.append(_channels(before, after, step, totals))
        frames.append(np.concatenate(parts, axis=-1))
    return np.stack(frames)


def align(
    before: Floats, after: Floats, start: Rigid | None = None, *, aspect: float = 1.0
) -> Rigid:
    """Return the motion that lays `before` on `after`, both (SIDE, SIDE).

    Args:
        before: Earlier image.
        after: Later image.
        start: Where to begin; None searches all turns and shifts.
        aspect: Width of a pixel over its height.
    """
    if np.array_equal(before, after):
        return Rigid(aspect=aspect)
    return _refined(before, after, _search(before, after, aspect) if start is None else start)


def _search(before: Floats, after: Floats, aspect: float) -> Rigid:
    """Return the turn and whole-pixel shift of highest correlation, short ways preferred."""
    turned = np.zeros((len(TURNS_RAD), _PADDED, _PADDED), np.float32)
    for image, back in zip(turned, _turns_back(aspect), strict=True):
        image[:SIDE, :SIDE] = _warped(before, back)
    target = np.zeros((_PADDED, _PADDED), np.float32)
    target[:SIDE, :SIDE] = after
    norm = np.sqrt(np.square(turned).sum(axis=(1, 2)) * np.square(target).sum()) + 1e-6
    spectra = torch.fft.rfft2(torch.from_numpy(turned)).conj_physical()
    spectra *= torch.fft.rfft2(torch.from_numpy(target)) / torch.from_numpy(norm)[:, None, None]
    score = (torch.fft.irfft2(spectra) - _prior()).numpy()
    turn, y, x = np.unravel_index(score.argmax(), score.shape)
    # The transform is periodic: shifts beyond half of it are negative.
    x, y = ((int(one) + _PADDED // 2) % _PADDED - _PADDED // 2 for one in (x, y))
    return Rigid(float(TURNS_RAD[turn]), float(x), float(y), aspect)


def _refined(before: Floats, after: Floats, motion: Rigid) -> Rigid:
    """Improve `motion` by robust Gauss-Newton steps; contrast and level may change besides."""
    changed = changed_weight(before, after).ravel()
    counted = _counted(changed)
    rows = np.ones((6, SIDE * SIDE), np.float32)
    for _ in range(REFINEMENTS):
        _fill(rows, motion, before, after)
        error = rows[5]
        spread = 2 * 1.48 * float(ranked(np.abs(error[counted]))) + 1e-4
        weighted = rows[:5] * (changed / (1 + np.square(error / spread)))
        # Row by row: numpy's product of two such flat matrices takes twice as long.
        products = np.array([rows @ row for row in weighted], np.float64)
        normal = products[:, :5].copy()
        diagonal = normal.ravel()[::6]
        diagonal += 1e-3 * diagonal + 1e-6
        # OpenCV solves five equations in a quarter of numpy's time.
        _, solution = cv2.solve(normal, products[:, 5:].copy())
        turn, right, down = solution[:3, 0].tolist()
        step = Rigid(turn, right, down, motion.aspect)
        better = step.after(motion)
        if abs(better.turn_rad) > 1 or max(abs(better.x_px), abs(better.y_px)) > SIDE / 2:
            return motion
        motion = better
        if max(abs(step.turn_rad) * TURN_RADIUS_PX, abs(step.x_px), abs(step.y_px)) < CLOSE_PX:
            break
    return motion


def _fill(rows: Floats, motion: Rigid, before: Floats, after: Floats) -> None:
    """Lay out how a pixel changes with the turn, the shifts, contrast and level, and its error."""
    x, y = _levers(motion.aspect)
    right, down, moved = (row.reshape(SIDE, SIDE) for row in rows[1:4])
    moved[:] = motion.moved(before)
    cv2.Sobel(moved, cv2.CV_32F, 1, 0, dst=right, scale=-1 / 8)
    cv2.Sobel(moved, cv2.CV_32F, 0, 1, dst=down, scale=-1 / 8)
    np.subtract(rows[2] * x, rows[1] * y, out=rows[0])
    # Row 4 stays one: a change of level is the same everywhere.
    np.subtract(after.ravel(), rows[3], out=rows[5])


def changed_weight(before: Floats, after: Floats) -> Floats:
    """Return how much each pixel tells about motion, above 0, about 1 at most."""
    change = np.square(cv2.GaussianBlur(after - before, (0, 0), CHANGE_BLUR_PX))
    return change / (change + CHANGE**2) + LEAST_WEIGHT


def _counted(changed: Floats) -> NDArray[np.intp] | slice:
    """Return which pixels' errors tell how well a motion fits: those that changed, or else all."""
    moving = np.flatnonzero(changed > 0.5)
    return moving if len(moving) > FEWEST_CHANGED else slice(None)


def _channels(before: Floats, after: Floats, step: Rigid, totals: Sequence[Rigid]) -> Floats:
    moved = step.moved(before)
    errors = [np.square(after - image) for image in (before, moved)]
    rest, aligned = (
        cv2.resize(one, (GRID_SIDE,) * 2, interpolation=cv2.INTER_AREA) for one in errors
    )
    gain = np.log((rest + ERROR_FLOOR) / (aligned + ERROR_FLOOR))
    scale = np.sqrt(np.square(moved).sum() * np.square(after).sum()) + 1e-6
    correlation = np.full_like(gain, (moved * after).sum() / scale)
    moves = [total.displacement() * (IMAGE_SIDE / SIDE) for total in totals]
    return np.concatenate([*moves, gain[..., None], correlation[..., None]], axis=-1)


def _warped(image: Floats, back: NDArray[np.float64]) -> Floats:
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(image, back, (SIDE, SIDE), flags=flags)


def _small(image: Floats) -> Floats:
    small = cv2.resize(image, (SIDE, SIDE), interpolation=cv2.INTER_AREA)
    return small - small.mean()


@lru_cache(maxsize=8)
def _levers(aspect: float) -> tuple[Floats, Floats]:
    """Return what a turn's path at each pixel is proportional to, each (SIDE * SIDE,)."""
    axis = np.arange(SIDE, dtype=np.float32) - np.float32(_MIDDLE)
    x, y = np.meshgrid(axis, axis)
    return (x * np.float32(aspect)).ravel(), (y / np.float32(aspect)).ravel()


@lru_cache(maxsize=8)
def _turns_back(aspect: float) -> list[NDArray[np.float64]]:
    return [Rigid(float(turn), aspect=aspect).way_back() for turn in TURNS_RAD]


@lru_cache(maxsize=1)
def _patch_centres() -> tuple[Floats, Floats]:
    axis = ((np.arange(GRID_SIDE) + 0.5) * SIDE / GRID_SIDE - SIDE / 2).astype(np.float32)
    return np.meshgrid(axis, axis)


@lru_cache(maxsize=1)
def _prior() -> Tensor:
    shift = torch.fft.fftfreq(_PADDED, 1 / _PADDED).square()
    turn = torch.from_numpy(TURNS_RAD * TURN_RADIUS_PX).square()
    return PRIOR_PER_PX2 * (turn[:, None, None] + shift[:, None] + shift[None, :])
