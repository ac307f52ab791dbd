"""Where a sensor's lights stand, told by the clip itself, and pictures as under the usual lights.

A relief is read from its shading, and the shading tells slopes only to who knows where the lights
are. The slopes of a relief have no curl; those read with the lights in a wrong place do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

SHADE_X, SHADE_Y = 0.49, 1.64
"""Change of G, and of B - R, per unit slope towards right and down: GelSight Mini's lights, which
stand about the pad at nearly right angles (`simulation.optics.LIGHTS`, measured on one unit)."""

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

TURNED_CURL = 0.6
"""The lights count as turned by a quarter when that leaves less than this share of the curl, and
slopes of a relief. Measured on 1,250 simulated clips: 3 are taken for turned wrongly, of 1,000
turns and slides recorded a quarter turned 97 % are found; of 542 real ones 1 and 99 %."""

CURL_BLUR_PX = 0.75
"""Blur, in pixels of the relief, below which camera noise is most of the curl."""

Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Lights:
    """How the lights stand against a GelSight Mini's, as far as the curl of slopes tells.

    Args:
        are_turned: By a quarter; which way the curl does not tell, but a relief that comes out
            inside out (`relief.is_inside_out`).
        are_mirrored: Left for right, once they are turned back.
        are_one: Whether the picture tells them not apart: it is grey, or of one colour.
    """

    are_turned: bool = False
    are_mirrored: bool = False
    are_one: bool = False


def slopes(residuals: Sequence[Floats], aspect: float = 1.0) -> tuple[Floats, Floats]:
    """Return the slopes towards right and down that the shading tells under the usual lights.

    Args:
        residuals: Frames less the idle gel, float32 (side, side, 3), RGB grey levels.
        aspect: Width of a pixel over its height.

    Returns:
        Each (frames, side, side), per pixel in the measure of `SHADE_X` and `SHADE_Y`.
    """
    to_right = np.stack([one[..., 1] for one in residuals]) / np.float32(SHADE_X / aspect**0.5)
    down = np.stack([one[..., 2] - one[..., 0] for one in residuals])
    return to_right, down / np.float32(SHADE_Y * aspect**0.5)


def lights_of(residuals: Sequence[Floats], aspect: float = 1.0) -> Lights:
    """Tell how the lights stand by what leaves the slopes the least curl.

    Args:
        residuals: Frames less the idle gel, float32 (56, 56, 3), RGB grey levels.
        aspect: Width of a pixel over its height.
    """
    shaded = slopes(residuals, aspect)
    green, blue_less_red = (float(np.vdot(one, one)) for one in shaded)
    if (SHADE_Y * aspect) ** 2 * blue_less_red < GREY_SHARE * SHADE_X**2 * green:
        return Lights(are_one=True)
    # All frames at once, as channels of one image: in half of the time.
    to_right, down = (
        cv2.GaussianBlur(cv2.merge(list(one)), (0, 0), CURL_BLUR_PX) for one in shaded
    )
    x_by_x, x_by_y = _gradient(to_right)
    y_by_x, y_by_y = _gradient(down)
    usual = _Curl.of(x_by_x, x_by_y, y_by_x, y_by_y)
    # Turned back, the slope to the right is what passed for the one down, over wider pixels, and
    # the slope down what passed for the one to the left.
    wider, narrower = np.float32(aspect), np.float32(-1 / aspect)
    turned = _Curl.of(wider * y_by_x, wider * y_by_y, narrower * x_by_x, narrower * x_by_y)
    if turned.least < TURNED_CURL * usual.least and turned.is_of_relief:
        return Lights(are_turned=True, are_mirrored=turned.is_less_mirrored)
    return Lights(are_mirrored=usual.is_less_mirrored)


def as_of_one_light(residual: Floats) -> Floats:
    """Return what a grey picture is in colours, its shades those of slopes towards one light.

    That light is taken to stand in the upper right; of slopes across it a grey picture tells
    nothing. Without colours there is no relief at all, and how far it went is told wrong, at 0.9 or
    more, of 0.24 of 134 semi-real slides in grey; with these colours of none.

    Args:
        residual: Frame less the idle gel, float32 (rows, columns, 3), RGB grey levels.
    """
    slope = cv2.extractChannel(residual, 1) * np.float32(0.5**0.5 / SHADE_GREY)
    half = np.float32(SHADE_Y / 2) * slope
    return cv2.merge([half, np.float32(SHADE_X) * slope, -half])


def turned_by_a_quarter(residual: Floats) -> Floats:
    """Return what a picture is with all lights moved about the pad by a quarter turn.

    Args:
        residual: Frame less the idle gel, float32 (rows, columns, 3), RGB grey levels.
    """
    red, green, blue = cv2.split(residual)
    common, half = (red + blue) / 2, np.float32(SHADE_Y / SHADE_X / 2) * green
    return cv2.merge([common + half, np.float32(SHADE_X / SHADE_Y) * (blue - red), common - half])


def turned_by_a_half(residual: Floats) -> Floats:
    """Return what a picture is with all lights moved to the other side of the pad.

    Args:
        residual: Frame less the idle gel, float32 (rows, columns, 3), RGB grey levels.
    """
    red, green, blue = cv2.split(residual)
    return cv2.merge([blue, -green, red])


@dataclass(frozen=True)
class _Curl:
    """What slopes leave unexplained: squared curl and divergence, as they are and mirrored."""

    kept: float
    mirrored: float
    spread_kept: float
    spread_mirrored: float

    @classmethod
    def of(cls, x_by_x: Floats, x_by_y: Floats, y_by_x: Floats, y_by_y: Floats) -> _Curl:
        # The squares of sum and difference, without an image for either.
        both = float(np.vdot(x_by_y, x_by_y) + np.vdot(y_by_x, y_by_x))
        twice = 2 * float(np.vdot(x_by_y, y_by_x))
        spread = float(np.vdot(x_by_x, x_by_x) + np.vdot(y_by_y, y_by_y))
        product = 2 * float(np.vdot(x_by_x, y_by_y))
        return cls(both - twice, both + twice, spread + product, spread - product)

    @property
    def least(self) -> float:
        return min(self.kept, self.mirrored)

    @property
    def is_less_mirrored(self) -> bool:
        is_less = self.mirrored < MIRRORED_CURL * self.kept
        return is_less and self.mirrored < CURL_OF_RELIEF * self.spread_mirrored

    @property
    def is_of_relief(self) -> bool:
        """Whether there is a relief whose slopes these are, mirrored or not."""
        kept = self.kept < CURL_OF_RELIEF * self.spread_kept
        return kept or self.mirrored < CURL_OF_RELIEF * self.spread_mirrored


def _gradient(values: Floats) -> tuple[Floats, Floats]:
    return cv2.Sobel(values, cv2.CV_32F, 1, 0), cv2.Sobel(values, cv2.CV_32F, 0, 1)
