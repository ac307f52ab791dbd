"""Where a sensor's lights stand, told by the clip itself, and the relief that its shading shows.

A relief is read from its shading (photometric stereo and a Poisson equation), and the shading tells
slopes only to who knows where the lights are. The slopes of a relief have no curl; those read with
the lights in a wrong place do.

The lights stand still while the object turns, so that a turning edge changes its shade; its relief
only turns. Measured on 391 simulated turns and slides: an aperture-aware rigid fit to the flow of
the relief finds 0.86 of a turn (median; lower quartile 0.72), to that of the green residual 0.70
(0.51).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

SHADE_X, SHADE_Y = 0.49, 1.64
"""Change of G, and of B - R, per unit slope towards right and down: GelSight Mini's lights, which
stand about the pad at nearly right angles (`simulation.scene.Lamps`, measured on one unit)."""

SHADE_GREY = 0.33
"""Change of a grey picture of the same sensor per unit slope towards right and up, where the three
lights' changes add up."""

GREY_SHARE = 0.01
"""Most energy of B - R, as a share of G's, in pictures without colour."""

MIRRORED_CURL = 0.8
"""The lights count as mirrored when that leaves less than this share of the slopes' curl. Measured
on 966 simulated turns and slides, together with the bound below: 1.2 % are taken for mirrored
wrongly, 93 % of their mirror images are found; the others' reliefs have no twist to tell by."""

CURL_OF_RELIEF = 0.7
"""Most squared curl, as a share of the squared divergence, of slopes that a relief explains."""

MOST_CURL = 0.4
"""Curl, as a share of the divergence, up to which the shading carries the relief. Measured on every
second real window: 98 % of 136 on a gel without markers lie below 0.32, 98 % of 63 on one with
markers above 0.44, whose relief goes 30 to 80 pixels where the markers go 3."""

TURNED_CURL = 0.6
"""The lights count as turned by a quarter when that leaves less than this share of the curl, and
slopes of a relief. Measured on 1,250 simulated clips: 3 are taken for turned wrongly, of 1,000
turns and slides recorded a quarter turned 97 % are found; of 542 real ones 1 and 99 %."""

CURL_BLUR_PX = 0.75
"""Blur, in pixels of the relief, below which camera noise is most of the curl."""

RELIEF_SIDE = 56
"""Side of the relief."""

LONGEST_WAVE_PX = 25.0
"""Wavelength, in pixels of the relief, beyond which it is damped: a slow error of shading would
integrate to a tilt larger than any imprint."""

RELIEF_SCALE = 15.0
"""Grey level pixels mapped to 1: about the relief's deviation over simulated contacts."""

INSIDE_OUT_SKEW = -0.75
"""Skewness of a relief below which it counts as inside out. Measured on 956 simulated clips that
touch: 0.2 % are below, 2 % where the idle gel is a guess; 93 % lie above its opposite, of 271 real
turns 94 %."""

Floats = NDArray[np.float32]

Curl = tuple[float, float]
"""Squared curl and squared divergence of slopes, as they are or mirrored."""


@dataclass(frozen=True)
class Lights:
    """How the lights stand against a GelSight Mini's, as far as the curl of slopes tells."""

    # By a quarter; which way the curl does not tell, but a relief that comes out inside out
    # (`relief.is_inside_out`).
    are_turned: bool = False
    are_mirrored: bool = False  # left for right, once they are turned back
    are_one: bool = False  # whether the picture tells them not apart: it is grey, or of one colour
    # Squared curl of the slopes as a share of their squared divergence; 0 of a relief without noise
    curl: float = field(default=math.inf, compare=False)


def slopes(residuals: Sequence[Floats], aspect: float = 1.0) -> tuple[Floats, Floats]:
    """Return the slopes towards right and down that the shading tells under the usual lights.

    Residuals are frames less the idle gel, (side, side, 3), RGB grey levels; `aspect` is the width
    of a pixel over its height. Slopes are (frames, side, side) each, per pixel in the measure of
    `SHADE_X` and `SHADE_Y`.
    """
    to_right = np.stack([frame[..., 1] for frame in residuals]) / np.float32(SHADE_X / aspect**0.5)
    down = np.stack([frame[..., 2] - frame[..., 0] for frame in residuals])
    return to_right, down / np.float32(SHADE_Y * aspect**0.5)


def lights_of(residuals: Sequence[Floats], aspect: float = 1.0) -> Lights:
    """Tell how the lights stand by what leaves the `slopes` of residuals the least curl."""
    shaded = slopes(residuals, aspect)
    green, blue_less_red = (float(np.vdot(slope, slope)) for slope in shaded)
    if (SHADE_Y * aspect) ** 2 * blue_less_red < GREY_SHARE * SHADE_X**2 * green:
        return Lights(are_one=True)
    # All frames at once, as channels of one image: in half of the time.
    to_right, down = (
        cv2.GaussianBlur(cv2.merge(list(slope)), (0, 0), CURL_BLUR_PX) for slope in shaded
    )
    x_by_x, x_by_y = gradients(to_right)
    y_by_x, y_by_y = gradients(down)
    usual = _curls(x_by_x, x_by_y, y_by_x, y_by_y)
    # Turned back, the slope to the right is what passed for the one down, over wider pixels, and
    # the slope down what passed for the one to the left.
    wider, narrower = np.float32(aspect), np.float32(-1 / aspect)
    turned = _curls(wider * y_by_x, wider * y_by_y, narrower * x_by_x, narrower * x_by_y)
    is_of_relief = any(curl < CURL_OF_RELIEF * spread for curl, spread in turned)
    are_turned = min(turned)[0] < TURNED_CURL * min(usual)[0] and is_of_relief
    kept, mirrored = turned if are_turned else usual
    are_mirrored = mirrored[0] < min(MIRRORED_CURL * kept[0], CURL_OF_RELIEF * mirrored[1])
    curl, spread = mirrored if are_mirrored else kept
    return Lights(are_turned, are_mirrored, curl=curl / max(spread, 1e-9))


def as_of_one_light(residual: Floats) -> Floats:
    """Return what a grey picture is in colours, its shades those of slopes towards one light.

    That light is taken to stand in the upper right; of slopes across it a grey picture tells
    nothing. Without colours there is no relief at all, and how far it went is told wrong, at 0.9 or
    more, of 0.24 of 134 semi-real slides in grey; with these colours of none.
    """
    slope = cv2.extractChannel(residual, 1) * np.float32(0.5**0.5 / SHADE_GREY)
    half = np.float32(SHADE_Y / 2) * slope
    return cv2.merge([half, np.float32(SHADE_X) * slope, -half])


def turned_by_a_quarter(residual: Floats) -> Floats:
    """Return what a picture is with all lights moved about the pad by a quarter turn."""
    red, green, blue = cv2.split(residual)
    common, half = (red + blue) / 2, np.float32(SHADE_Y / SHADE_X / 2) * green
    return cv2.merge([common + half, np.float32(SHADE_X / SHADE_Y) * (blue - red), common - half])


def turned_by_a_half(residual: Floats) -> Floats:
    """Return what a picture is with all lights moved to the other side of the pad."""
    red, green, blue = cv2.split(residual)
    return cv2.merge([blue, -green, red])


def _curls(x_by_x: Floats, x_by_y: Floats, y_by_x: Floats, y_by_y: Floats) -> tuple[Curl, Curl]:
    # The squares of sum and difference, without an image for either.
    both = float(np.vdot(x_by_y, x_by_y) + np.vdot(y_by_x, y_by_x))
    twice = 2 * float(np.vdot(x_by_y, y_by_x))
    spread = float(np.vdot(x_by_x, x_by_x) + np.vdot(y_by_y, y_by_y))
    product = 2 * float(np.vdot(x_by_x, y_by_y))
    return (both - twice, spread + product), (both + twice, spread - product)


def gradients(image: Floats) -> tuple[Floats, Floats]:
    """Return the slopes of a smooth image towards right and down, per pixel."""
    right = cv2.Sobel(image, cv2.CV_32F, 1, 0, scale=1 / 8)
    return right, cv2.Sobel(image, cv2.CV_32F, 0, 1, scale=1 / 8)


def reliefs(
    residuals: Sequence[Floats], aspect: float = 1.0, *, are_lights_mirrored: bool = False
) -> Floats:
    """Integrate the shading of each frame under the usual lights, or in their mirror image.

    Residuals are as in `slopes`, 56 pixels square: the shade tells the slope on the gel, and a wide
    pixel climbs farther on it. Indentations are (frames, 56, 56), in grey levels times pixels.
    """
    slope_x, slope_y = slopes(residuals, aspect)
    slope_x = -slope_x if are_lights_mirrored else slope_x
    slope = torch.complex(torch.from_numpy(slope_x), torch.from_numpy(slope_y))
    return torch.fft.ifft2(torch.fft.fft2(slope) * _integrator()).real.numpy()


def is_inside_out(relief: Floats) -> bool:
    """Tell whether dents came out as bumps, as under lights on the other side of the pad.

    Dents are deep and few in a gel that lies flat elsewhere.
    """
    about_mean = relief - relief.mean(axis=(1, 2), keepdims=True)
    squares = np.square(about_mean)
    variance = float(squares.mean())
    return float(np.vdot(squares, about_mean)) < INSIDE_OUT_SKEW * variance**1.5 * relief.size


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
