"""Search all turns and shifts of a small picture at once, where direct alignment has lost its way.

A turn of more than some 20 degrees from one frame to the next, or a shift by more than a coarse
picture's detail, is beyond the reach of gradients. The correlation of the earlier picture, turned
each way, with the later one is a product of their spectra.
"""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.alignment.direct import Aligned, Picture, Rigid, align
from geotlm_lm.core.process import in_one_thread

Floats = NDArray[np.float32]

SEARCHED_WIDTH = 56
"""Columns of the pictures that are searched."""

TURNS_RAD = np.radians(np.arange(-45.0, 45.1, 9.0)).astype(np.float32)
"""Turns that are searched; the alignment reaches farther than half a step."""

PRIOR_PER_PX2 = 2e-4
"""Loss of correlation per squared pixel of travel: of two equal matches, as a knurled cap has many,
the shorter way is meant."""

TURN_RADIUS_PX = 10.0
"""Radius at which a turn's path counts as travel in the prior."""

LOST_CORRELATION = 0.6
"""Correlation of two pictures below which the motion between them is doubted and searched."""

NEAR_PX = 6.0
"""Path, in pixels of the picture, between two motions that are about the same."""

ALIAS_SHARE = 0.6
"""Share of what the smaller motion leaves unexplained that a larger one may leave: between
neighbouring frames the smaller is preferred. Of real gels with markers, half `tune`, a motion one
marker farther leaves 0.67 to 0.97 of it; of 800 simulated turns and slides no true motion that
only a search finds is lost."""

_PADDED = 64  # a fast length with room for shifts beyond the border


def search(before: Floats, after: Floats) -> Rigid:
    """Return the turn and shift of highest correlation, short ways preferred.

    Pictures are high-passed, of one size, pixels square, no higher than wide. The motion is in
    pixels of the pictures given, right to a pixel of those searched.
    """
    shrink = SEARCHED_WIDTH / max(before.shape)
    size = [max(round(side * shrink), 1) for side in before.shape[::-1]]
    before, after = (
        cv2.resize(image, size, interpolation=cv2.INTER_AREA) for image in (before, after)
    )
    score = correlations(before, after, TURNS_RAD, (_PADDED, _PADDED)) - _prior().numpy()
    turn, down, right = np.unravel_index(score.argmax(), score.shape)
    # The transform is periodic: shifts beyond half of it are negative.
    right, down = (
        ((int(place) + _PADDED // 2) % _PADDED - _PADDED // 2) / shrink for place in (right, down)
    )
    return Rigid(float(TURNS_RAD[turn]), right, down)


def correlations(
    before: Floats, after: Floats, turns_rad: Floats, padded: tuple[int, int]
) -> Floats:
    """Return how alike a picture and an earlier one are at every turn and shift.

    Args:
        before: Earlier picture, of mean zero, pixels square, (rows, columns).
        after: Later one of the same size.
        turns_rad: Turns about the middle, clockwise positive, (n,).
        padded: Rows and columns with room for shifts; shifts back are at the far ends.

    Returns:
        Correlations, float32, (n, *padded).
    """
    rows, columns = before.shape
    x, y = (columns - 1) / 2, (rows - 1) / 2
    turned = np.zeros((len(turns_rad), *padded), np.float32)
    for image, turn in zip(turned, turns_rad.tolist(), strict=True):
        cos, sin = math.cos(turn), math.sin(turn)
        back = np.array([[cos, sin, x - cos * x - sin * y], [-sin, cos, y + sin * x - cos * y]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        part = image[:rows, :columns]
        cv2.warpAffine(before, back, (columns, rows), dst=part, flags=flags)
    target = np.zeros(padded, np.float32)
    target[:rows, :columns] = after
    norm = np.sqrt(np.einsum("nij,nij->n", turned, turned) * np.square(target).sum()) + 1e-6
    turned /= norm[:, None, None]
    with in_one_thread():
        spectra = torch.fft.rfft2(torch.from_numpy(turned)).conj_physical_()
        spectra *= torch.fft.rfft2(torch.from_numpy(target))
        return torch.fft.irfft2(spectra, s=padded).numpy()


def align_or_search(before: Picture, after: Picture, start: Rigid | None = None) -> Aligned:
    """Return how a picture lies on the one before it, searched for where alignment is lost.

    Arguments as of `direct.align`.
    """
    near = align(before, after, start)
    if near.correlation >= LOST_CORRELATION:
        return near
    far = align(before, after, search(before.image, after.image))
    radius = max(before.image.shape) / 4
    apart = math.hypot(
        far.motion.right_px - near.motion.right_px,
        far.motion.down_px - near.motion.down_px,
        radius * (far.motion.turn_rad - near.motion.turn_rad),
    )
    share = 1.0 if apart < NEAR_PX else ALIAS_SHARE
    is_clear = 1 - far.correlation**2 < share * (1 - near.correlation**2)
    return far if is_clear else near


@lru_cache(maxsize=1)
def _prior() -> Tensor:
    shift = torch.fft.fftfreq(_PADDED, 1 / _PADDED).square()
    turn = torch.from_numpy(TURNS_RAD * TURN_RADIUS_PX).square()
    return PRIOR_PER_PX2 * (turn[:, None, None] + shift[:, None] + shift[None, :])
