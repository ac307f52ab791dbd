"""Shading of the imprint -> its relief, by photometric stereo and a Poisson equation.

The lights stand still while the object turns, so that a turning edge changes its shade; its relief
only turns. Measured on 391 simulated turns and slides: an aperture-aware rigid fit to the flow of
the relief finds 0.86 of a turn (median; lower quartile 0.72), to that of the green residual 0.70
(0.51).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

RELIEF_SIDE = 112
"""Side of the relief; the flow works at half of it again."""

SHADE_X, SHADE_Y = 0.49, 1.64
"""Change of G, and of B - R, per unit slope towards right and down: GelSight Mini's lights, which
stand about the pad at nearly right angles (`simulation.optics.LIGHTS`, measured on one unit)."""

LONGEST_WAVE_PX = 50.0
"""Wavelength, in pixels of the relief, beyond which it is damped: a slow error of shading would
integrate to a tilt larger than any imprint."""

RELIEF_SCALE = 30.0
"""Grey level pixels mapped to 1: about the relief's deviation over simulated contacts."""

_GAIN, _NEUTRAL = 0.5, 128.0

Floats = NDArray[np.float32]


def reliefs(residuals: Sequence[Floats]) -> Floats:
    """Integrate the shading of each frame.

    Args:
        residuals: Frames less the idle gel, float32 (side, side, 3), RGB grey levels.

    Returns:
        Indentation, float32 (frames, 112, 112), in grey levels times pixels.
    """
    small = [cv2.resize(one, (RELIEF_SIDE,) * 2, interpolation=cv2.INTER_AREA) for one in residuals]
    slope = np.stack(
        [one[..., 1] / SHADE_X + 1j * ((one[..., 2] - one[..., 0]) / SHADE_Y) for one in small]
    ).astype(np.complex64)
    return torch.fft.ifft2(torch.fft.fft2(torch.from_numpy(slope)) * _integrator()).real.numpy()


def as_image(relief: Floats) -> NDArray[np.uint8]:
    """Return one relief as an 8-bit image around 128, for the flow."""
    return (_NEUTRAL + _GAIN * relief).clip(0, 255).astype(np.uint8)


@lru_cache(maxsize=1)
def _integrator() -> Tensor:
    """Return the factor from the spectrum of s_x + i s_y to that of the relief d, s = -grad d.

    Both slopes ride in one complex transform: the damped solution of lap d = -div s is its real
    part, and the curl of s, which no relief explains, its imaginary part.
    """
    wave = torch.fft.fftfreq(RELIEF_SIDE, dtype=torch.float64) * 2 * torch.pi
    x, y = wave[None, :], wave[:, None]
    damped = x**2 + y**2 + (2 * torch.pi / LONGEST_WAVE_PX) ** 2
    return (torch.complex(y.expand_as(damped), x.expand_as(damped)) / damped).to(torch.complex64)
