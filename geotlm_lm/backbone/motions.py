"""How the imprint moved, frame by frame: rigid motions of residual and relief, and what is left.

A touched object is rigid, so that three numbers explain every patch together. They are found in the
pictures directly; a search starts them anew where that fails. What one patch did beyond them (a
press spreads its imprint, markers lag) is one step of the same equations in the patch alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.alignment.direct import Aligned, Picture, Rigid, align
from geotlm_lm.alignment.search import align_or_search
from geotlm_lm.backbone.imprint import VIEW_SIDE, Imprint
from geotlm_lm.backbone.relief import RELIEF_SCALE, gradients
from geotlm_lm.backbone.view import CONTRAST_FLOOR_GREY2
from geotlm_lm.core.geometry import FLOW_SCALE_PX, GRID_SIDE, IMAGE_SIDE

Floats = NDArray[np.float32]

GREEN_LEVELS, RELIEF_LEVELS = 3, 2

STILL_EVEN, STILL_RELIEF = 0.25, 0.15 * RELIEF_SCALE
"""Difference at which a pixel weighs half where a frame is laid on the first directly: of pictures
of even contrast, and of the relief."""

ERROR_FLOOR_GREY2 = 1.0
"""Squared error that noise alone leaves behind in a shrunken picture."""

LOCAL_CHANNELS = 7
"""Displacement x and y beyond the rigid motion, log of how many times larger the squared error is
at rest than after it, log contrast, and the gradients' orientation (3)."""

MOTION_NUMBERS = 8
"""Of each picture's motion: correlation, and logs of the deviations of turn, right and down."""

LONGEST_LOCAL_PX = 8.0
"""Most that a patch is taken to have moved beyond the rigid motion, pixels of the view."""

MEASURED = ("green_chained", "green_direct", "relief_chained", "relief_direct")
"""The rigid motions that are measured: picture, and how frames are laid on each other."""

MOTIONS_SHAPE = (len(MEASURED), 7)
"""Of `Motions.numbers`."""


@dataclass(frozen=True, eq=False)
class Motions:
    """The rigid motions to the last frame, about the middle of the view."""

    # float32 (4, 3), one row for each of `MEASURED`: turn in rad, clockwise positive, way to the
    # right and down in pixels of the 224-pixel image.
    twists: Floats
    # Their standard deviations by the normal equations and the residual, of a chain those of its
    # least certain step, (4, 3): white noise; what codecs and lamps add is not in it.
    deviations: Floats
    correlations: Floats  # how much of the picture each explains, (4,); 0 of no relief's

    @classmethod
    def none(cls) -> Motions:
        """Return what is measured where no frame differs from the first."""
        return cls(np.zeros((4, 3), np.float32), np.zeros((4, 3), np.float32), np.ones(4, "f4"))

    def numbers(self) -> Floats:
        """Return all of it in one array, (4, 7), for what is stored and learned from."""
        return np.concatenate([self.twists, self.deviations, self.correlations[:, None]], axis=1)


@dataclass(frozen=True, eq=False)
class FoundMotions:
    """What `motions_of` measures of each distinct frame, and the motions to the last one."""

    displacement: Floats  # (frames, 14, 14, 8), pixels of the view, of each of MEASURED, x before y
    local: Floats  # (frames, 14, 14, LOCAL_CHANNELS)
    sureness: Floats  # (frames, MOTION_NUMBERS)
    motions: Motions


def motions_of(imprint: Imprint) -> FoundMotions:
    """Find how each distinct frame of a clip's imprint lies on the first.

    Where the shading carries no relief, the residual's motions stand in the relief's place.
    """
    count = len(imprint.green)
    pictures = [Picture.of(frame, GREEN_LEVELS) for frame in imprint.green]
    green = _Sequence(pictures, [picture.even() for picture in pictures], STILL_EVEN)
    relief = _relief_of(imprint) if imprint.is_shaded else None
    beyond = [_beyond(pictures[0].image, pictures[0].image, Rigid())]
    sureness = np.zeros((count, MOTION_NUMBERS), np.float32)
    sureness[:, [0, 4]] = 1
    pairs: list[tuple[_Found, _Found]] = []
    for k in range(1, count):
        in_green = in_relief = green.next()
        if relief is not None:
            # It begins where the residual ended: its own detail is coarser.
            in_relief = relief.next(in_green.step.motion, relief.size[1] / VIEW_SIDE)
        pairs.append((in_green, in_relief))
        beyond.append(_beyond(pictures[0].image, pictures[k].image, in_green.direct.motion))
        sureness[k] = np.concatenate([_sureness(in_green.direct), _sureness(in_relief.direct)])
    kinds = green, green if relief is None else relief
    displacement = _displacement(pairs, tuple(kind.size for kind in kinds))
    motions = _last(pairs, kinds, imprint) if pairs else Motions.none()
    if relief is None:
        motions.correlations[2:] = 0
    local = _local(np.stack(beyond, axis=1), *imprint.green[0].shape)
    return FoundMotions(displacement, local, sureness, motions)


def _relief_of(imprint: Imprint) -> _Sequence:
    height = max(round(imprint.relief.shape[2] / imprint.aspect), 8)
    size = (imprint.relief.shape[2], height)
    flat = [cv2.resize(frame, size, interpolation=cv2.INTER_AREA) for frame in imprint.relief]
    reliefs = [Picture.of(frame, RELIEF_LEVELS) for frame in flat]
    return _Sequence(reliefs, reliefs, STILL_RELIEF)


@dataclass(frozen=True, eq=False)
class _Found:
    """How one frame lies on the frame before, on the first, and on the first by way of all."""

    step: Aligned
    direct: Aligned
    chained: Rigid
    # Of the chain's least certain step: turn at half the longer side, right, down, px^2.
    variances: NDArray[np.float64]


class _Sequence:
    """Pictures of one kind, laid on each other in the order of time.

    Each is laid on the one before; `direct` are the same as they are laid on the first, where a
    pixel of difference `still` weighs half.
    """

    def __init__(
        self, pictures: Sequence[Picture], direct: Sequence[Picture], still: float
    ) -> None:
        self.pictures = pictures
        self._direct, self._still = direct, still
        self._place, self._chained, self._variances = 0, Rigid(), np.zeros(3)

    @property
    def size(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.pictures[0].image.shape

    def next(self, start: Rigid | None = None, scale: float = 1.0) -> _Found:
        """Lay the next picture on those before it.

        The step begins at `start` times `scale` pixels, or at rest.
        """
        self._place += 1
        before, after = self.pictures[self._place - 1], self.pictures[self._place]
        if start is None:
            step = align_or_search(before, after)
        else:
            begun = Rigid(start.turn_rad, start.right_px * scale, start.down_px * scale)
            step = align(before, after, begun)
        self._chained = step.motion.after(self._chained)
        # Noise of the frames between cancels: each is earlier in one step and later in the next.
        self._variances = np.maximum(self._variances, _variances(step))
        first, last = self._direct[0], self._direct[self._place]
        direct = align(first, last, self._chained, still_grey=self._still, levels=1)
        return _Found(step, direct, self._chained, self._variances)


def _displacement(pairs: Sequence[tuple[_Found, _Found]], sizes: Sequence) -> Floats:
    """Return how far what is now under each patch centre has come, (1 + n, 14, 14, 8).

    Of each of `MEASURED` to the right and down, in pixels of the view; 0 for the first frame.
    """
    motions = np.array(
        [
            [(m.turn_rad, m.right_px / columns, m.down_px / rows, rows / columns)
             for pictures, (rows, columns) in zip(pair, sizes, strict=True)
             for m in (pictures.chained, pictures.direct.motion)]
            for pair in pairs
        ]
    ).reshape(-1, len(MEASURED), 4)  # fmt: skip
    turn, right, down, height = (motions[..., k, None, None] for k in range(4))
    centres = (np.arange(GRID_SIDE) + 0.5) / GRID_SIDE - 0.5
    # In shares of the view, which is `height` as high as wide.
    x, y = centres[None, :] - right, (centres[:, None] - down) * height
    cos, sin = np.cos(turn), np.sin(turn)
    moved = [centres[None, :] - cos * x - sin * y, centres[:, None] + (sin * x - cos * y) / height]
    field = np.stack(np.broadcast_arrays(*moved), axis=-1) * IMAGE_SIDE
    displacement = np.zeros((1 + len(pairs), GRID_SIDE, GRID_SIDE, 2 * len(MEASURED)), np.float32)
    displacement[1:] = field.transpose(0, 2, 3, 1, 4).reshape(displacement[1:].shape)
    return displacement


def _beyond(first: Floats, now: Floats, motion: Rigid) -> Floats:
    """Return what each patch shows beyond a rigid motion from the first picture to this one.

    Means over each patch, (7, 14, 14): the gradients' products xx, xy and yy, those with the error
    x and y, the squared error, and that at rest.
    """
    rows, columns = now.shape
    moved = first
    if motion != Rigid():
        ahead = motion.matrix(rows, columns)
        moved = cv2.warpAffine(first, ahead, (columns, rows), flags=cv2.INTER_LINEAR)
    right, down = gradients(moved)
    error, at_rest = cv2.subtract(now, moved), cv2.subtract(now, first)
    factors = ((right, right), (right, down), (down, down), (right, error), (down, error),
               (error, error), (at_rest, at_rest))  # fmt: skip
    means, product = np.empty((len(factors), GRID_SIDE, GRID_SIDE), np.float32), None
    for mean, (one, other) in zip(means, factors, strict=True):
        product = cv2.multiply(one, other, dst=product)
        cv2.resize(product, mean.shape, dst=mean, interpolation=cv2.INTER_AREA)
    return means


def _local(beyond: Floats, rows: int, columns: int) -> Floats:
    """Return the channels (frames, 14, 14, LOCAL_CHANNELS) of means (7, frames, 14, 14).

    Rows and columns are those of the pictures.
    """
    xx, xy, yy, xe, ye, left, rest = beyond
    damped_xx, damped_yy = xx + CONTRAST_FLOOR_GREY2 / 4, yy + CONTRAST_FLOOR_GREY2 / 4
    scale = damped_xx * damped_yy - xy * xy
    # now(x) = moved(x - u): the error is -grad moved . u.
    along = -(damped_yy * xe - xy * ye) / scale * np.float32(IMAGE_SIDE / columns)
    across = -(damped_xx * ye - xy * xe) / scale * np.float32(IMAGE_SIDE / rows)
    energy = xx + yy
    floor = np.float32(CONTRAST_FLOOR_GREY2)
    channels = (
        along.clip(-LONGEST_LOCAL_PX, LONGEST_LOCAL_PX) / np.float32(FLOW_SCALE_PX),
        across.clip(-LONGEST_LOCAL_PX, LONGEST_LOCAL_PX) / np.float32(FLOW_SCALE_PX),
        np.log((rest + ERROR_FLOOR_GREY2) / (left + ERROR_FLOOR_GREY2)),
        np.log1p(energy / floor),
        xx / (energy + floor),
        xy / (energy + floor),
        yy / (energy + floor),
    )
    return np.stack(channels, axis=-1)


def _sureness(aligned: Aligned) -> Floats:
    """Return correlation, and logs of the deviations of turn, right and down, picture's pixels."""
    deviations = np.sqrt(_variances(aligned))
    return np.array([aligned.correlation, *np.log(deviations + 1e-3)], np.float32)


def _variances(aligned: Aligned) -> NDArray[np.float64]:
    """Return the variances of turn at half the longer side, right and down, picture's pixels."""
    return np.diag(aligned.covariance) * aligned.residual**2


def _last(
    pairs: Sequence[tuple[_Found, _Found]], kinds: tuple[_Sequence, ...], imprint: Imprint
) -> Motions:
    """Return the motions to the last frame, in pixels of the 224-pixel image."""
    twists, deviations, correlations = [], [], []
    for pair, pictures in zip(pairs[-1], kinds, strict=True):
        rows, columns = pictures.size
        wide, high = imprint.view.side_px / columns, imprint.view.side_px / rows
        scale = np.array([2 / max(rows, columns), wide, high])
        ways = (pair.chained, pair.variances), (pair.direct.motion, _variances(pair.direct))
        for motion, variances in ways:
            twists.append((motion.turn_rad, motion.right_px * wide, motion.down_px * high))
            deviations.append(np.sqrt(variances) * scale)
            correlations.append(pair.direct.correlation)
    return Motions(
        np.array(twists, np.float32),
        np.array(deviations, np.float32),
        np.array(correlations, np.float32),
    )
