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

MIRRORED_CURL = 0.8
"""The lights count as mirrored when that leaves less than this share of the slopes' curl. Measured
on 966 simulated turns and slides, together with the bound below: 1.2 % are taken for mirrored
wrongly, 93 % of their mirror images are found; the others' reliefs have no twist to tell by."""

CURL_OF_RELIEF = 0.7
"""Most squared curl, as a share of the squared divergence, of slopes that a relief explains."""

CURL_BLUR_PX = 1.5
"""Blur, in pixels of the relief, below which camera noise is most of the curl."""

_GAIN, _NEUTRAL = 0.5, 128.0

Floats = NDArray[np.float32]


def reliefs(residuals: Sequence[Floats], aspect: float = 1.0) -> Floats:
    """Integrate the shading of each frame.

    Optics with a mirror in them swap the lights left to right; the clip itself tells, because the
    slopes of a relief have no curl and those of a half inverted one do.

    Args:
        residuals: Frames less the idle gel, float32 (side, side, 3), RGB grey levels; the relief's
            own side saves the shrinking.
        aspect: Width of a pixel over its height: the shade tells the slope on the gel, and a wide
            pixel climbs farther on it.

    Returns:
        Indentation, float32 (frames, 112, 112), in grey levels times pixels.
    """
    small = [cv2.resize(one, (RELIEF_SIDE,) * 2, interpolation=cv2.INTER_AREA) for one in residuals]
    slope_x = np.stack([one[..., 1] for one in small]) / np.float32(SHADE_X / aspect**0.5)
    slope_y = np.stack([one[..., 2] - one[..., 0] for one in small]) / np.float32(
        SHADE_Y * aspect**0.5
    )
    if lights_are_mirrored(slope_x, slope_y):
        slope_x = -slope_x
    slope = torch.complex(torch.from_numpy(slope_x), torch.from_numpy(slope_y))
    return torch.fft.ifft2(torch.fft.fft2(slope) * _integrator()).real.numpy()


def lights_are_mirrored(slope_x: Floats, slope_y: Floats) -> bool:
    """Tell whether the slopes fit together better with the lights swapped left to right.

    Args:
        slope_x: Slope towards the right under the lights as measured, (frames, side, side).
        slope_y: Slope towards the bottom, likewise.
    """
    # All frames at once, as channels of one image: in half of the time.
    to_right, down = (
        cv2.GaussianBlur(cv2.merge(list(one)), (0, 0), CURL_BLUR_PX) for one in (slope_x, slope_y)
    )
    across = cv2.Sobel(to_right, cv2.CV_32F, 0, 1)
    along = cv2.Sobel(down, cv2.CV_32F, 1, 0)
    outward = cv2.Sobel(down, cv2.CV_32F, 0, 1) - cv2.Sobel(to_right, cv2.CV_32F, 1, 0)
    # The squares of sum and difference, without an image for either.
    both, product = np.vdot(across, across) + np.vdot(along, along), np.vdot(across, along)
    kept, swapped = float(both - 2 * product), float(both + 2 * product)
    spread = float(np.vdot(outward, outward))
    return swapped < MIRRORED_CURL * kept and swapped < CURL_OF_RELIEF * spread


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
