"""The untouched gel as the camera sees it: smooth coloured light, specks, fixed pattern."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.simulation.noise import unit_noise

MEASURED_IDLE = np.array(
    [
        [[29, 41, 44, 32, 24], [48, 77, 86, 69, 39], [71, 123, 147, 111, 62]]
        + [[67, 111, 135, 101, 59], [49, 77, 89, 72, 44]],
        [[85, 97, 103, 95, 75], [92, 105, 112, 104, 83], [92, 101, 112, 104, 85]]
        + [[86, 96, 103, 98, 80], [76, 85, 90, 84, 69]],
        [[90, 113, 120, 106, 83], [104, 133, 141, 124, 95], [110, 143, 149, 131, 101]]
        + [[77, 97, 109, 96, 75], [62, 80, 94, 79, 61]],
    ],
    dtype=np.float32,
)
"""Grey levels of one GelSight Mini's idle frame on 5x5 even points, by channel (R, G, B)."""

FIXED_PATTERN_GREY = (0.85, 0.7, 1.0)
"""Standard deviation of the pixel-fine pattern that two sessions share, measured (R, G, B)."""

_NODES = np.linspace(-1, 1, 5)
_FROM_NODES = np.linalg.inv(np.vander(_NODES))
_X, _Y = np.meshgrid(_NODES, _NODES)
_QUADRATICS = np.stack([_X, _Y, _X * _Y, _X**2 - 0.5, _Y**2 - 0.5])

_SPECK_REACH_PX = 16
"""Farthest a speck changes the image from its middle: its radius and the reach of its blur."""


def idle_frame(seed: int, view: float = 1.0) -> NDArray[np.float32]:
    """Return an idle frame, float32 planar (3, 224, 224) RGB grey levels, without temporal noise.

    A degree-4 polynomial per axis through randomly changed measured levels; never mirrored, since
    which colour lights which side tells directions apart.

    Args:
        seed: Chooses everything random about the frame.
        view: Size of the view relative to the nominal one; a smaller view sees the middle.
    """
    rng = np.random.default_rng(seed)
    gain = rng.uniform(0.85, 1.15, (3, 1, 1))
    offset = rng.uniform(-8, 8, (3, 1, 1))
    table = MEASURED_IDLE * gain + offset
    table = table * np.exp(_smooth_change(rng, 0.10)) * np.exp(_smooth_change(rng, 0.06))
    reach = min(view, 1.0) * rng.uniform(0.85, 1.0)
    centre = rng.uniform(-1, 1, 2) * (1 - reach)
    rows = _lagrange(centre[0] + reach * _pixel_axis())
    columns = _lagrange(centre[1] + reach * _pixel_axis())
    frame = (rows @ torch.from_numpy(table.astype(np.float32)) @ columns.T).numpy()
    frame *= 1 - rng.uniform(0, 0.25) * _vignette()
    frame *= _specks(rng)[None]
    for channel, sigma in enumerate(FIXED_PATTERN_GREY):
        strength = sigma * rng.uniform(0.3, 1.2)
        cv2.scaleAdd(unit_noise(rng), strength, frame[channel], dst=frame[channel])
    return np.clip(frame, 2, 250, out=frame)


def _pixel_axis() -> NDArray[np.float64]:
    return (np.arange(IMAGE_SIDE) + 0.5) / (IMAGE_SIDE / 2) - 1


def _lagrange(points: NDArray[np.float64]) -> torch.Tensor:
    """Return the weights (points, 5) of polynomial interpolation through the table's nodes."""
    weights = np.vander(points, len(_NODES)) @ _FROM_NODES
    return torch.from_numpy(weights.astype(np.float32))


def _smooth_change(rng: np.random.Generator, size: float) -> NDArray[np.float64]:
    """Return a random quadratic per channel on the table's points, coefficients of scale `size`."""
    return np.tensordot(rng.normal(0, size, (3, 5)), _QUADRATICS, axes=1)


@cache
def _vignette() -> NDArray[np.float32]:
    axis = _pixel_axis().astype(np.float32) ** 2
    return (axis[:, None] + axis[None, :]) ** 2 / 4


def _specks(rng: np.random.Generator) -> NDArray[np.float32]:
    """Return the factor of 0 to 6 dark or bright specks: dust, bubbles, scratches in the paint."""
    factor = np.ones((IMAGE_SIDE, IMAGE_SIDE), np.float32)
    for _ in range(int(rng.integers(0, 7))):
        column, row = (int(v) for v in rng.integers(4, IMAGE_SIDE - 4, 2))
        strength = float(rng.choice([-1, 1], p=[0.75, 0.25]) * rng.uniform(0.1, 0.6))
        # Blurred alone: the whole image costs twenty times as much.
        left, top = max(column - _SPECK_REACH_PX, 0), max(row - _SPECK_REACH_PX, 0)
        around = factor[top : row + _SPECK_REACH_PX + 1, left : column + _SPECK_REACH_PX + 1]
        spot = np.zeros(around.shape, np.float32)
        radii = tuple(int(v) for v in rng.integers(0, 4, 2))
        angle = float(rng.uniform(0, 180))
        cv2.ellipse(spot, (column - left, row - top), radii, angle, 0, 360, strength, -1)
        around += cv2.GaussianBlur(spot, (0, 0), float(rng.uniform(0.5, 1.2)))
    return np.maximum(factor, 0.2)
