"""Statistics of an imprint: where it is, how strong, how sharp, which way it is lit.

Images are float32 (224, 224, 3), RGB grey levels. Knows neither the object nor its depth: where it
touches is found from what changed, so that real and simulated imprints are measured alike.
"""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.experiments.optics_statistics import (
    COLOURS,
    FINE_SIGMA_PX,
    RIM_PX,
    Floats,
    by_colour,
    cropped,
    fine_part,
    rms,
)

TOUCHED_SHARE = 0.06
"""Change relative to the idle level that counts as touched: 3 grey levels in the darkest real
recordings, ten times what noise leaves after smoothing."""

DARKEST_GREY = 20.0
"""Levels below are taken for this one where something is divided by the idle level."""

SMALL_PATCH = 0.1
"""Area over the greatest patch's below which a touched patch is taken for noise or a lifted rim."""

LEAST_AREA = 0.02
"""Share of the image that has to be touched before an imprint is measured."""

TAIL_PX = 15
"""Farther than this from the contact the gel is at rest: 1.4 mm, twice the length over which a
ball's imprint falls by 1/e beside its contact (0.7 mm, measured on one press)."""

ASPECT = 15.2 / 20.3
"""Height over width of a pixel after a GelSight Mini's view is made square."""

LEAST_DIPOLE = 0.15
"""Strength of a first moment, relative to a bright and a dark half, that has a direction."""


def contact_statistics(frame: Floats, idle: Floats) -> dict[str, float]:
    """Return the statistics of an imprint; nothing where less than `LEAST_AREA` is touched.

    Args:
        frame: The touched gel, (224, 224, 3).
        idle: The same gel untouched.
    """
    residual = _without_drift(frame - idle)
    shading = residual / np.maximum(idle, DARKEST_GREY)
    touched = touched_region(shading)
    if touched.mean() < LEAST_AREA:
        return {}
    inside = residual[touched]
    alike = np.corrcoef(inside.T.astype(np.float64))
    sharp, blunt = _gradient(residual, 1.0), _gradient(residual, FINE_SIGMA_PX)
    ratio = rms(sharp[touched]) / np.maximum(rms(blunt[touched]), 1e-6)
    found = {
        "area": 100 * float(touched.mean()),
        "contact B-R": float(alike[2, 0]),
        "contact G-R": float(alike[1, 0]),
        "contact G-B": float(alike[1, 2]),
    }
    found |= by_colour("residual", rms(inside))
    found |= by_colour("shading", 100 * rms(shading[touched]))
    found |= by_colour("gradient", np.quantile(sharp[touched], 0.95, axis=0))
    found |= by_colour("sharpness", ratio)
    found |= _beside(residual, touched)
    return found | light_statistics(shading, touched) if _is_whole(touched) else found


def depth_statistics(
    contact: Mapping[str, float], ball_mm: float, mm_per_px: tuple[float, float]
) -> dict[str, float]:
    """Return how much a ball's imprint brightens per mm that the ball is sunk in.

    The cap is the part of the ball below the plane of the touched region: area / (pi diameter).

    Args:
        contact: What `contact_statistics` found; without a brightening nothing comes out.
        ball_mm: Diameter of the ball.
        mm_per_px: Size of a pixel (x, y).
    """
    if "brightening R" not in contact:
        return {}
    view_mm2 = IMAGE_SIDE**2 * mm_per_px[0] * mm_per_px[1]
    cap_mm = contact["area"] / 100 * view_mm2 / (np.pi * ball_mm)
    return {f"depth {colour}": contact[f"brightening {colour}"] / cap_mm for colour in COLOURS}


def touched_region(shading: Floats) -> NDArray[np.bool_]:
    """Return where the gel is touched, (224, 224): change over idle level, smoothed, is large.

    Patches far smaller than the greatest, and what lies at the image's border, do not count: the
    gel's rim lifts and glitters when a hand presses beside it.

    Args:
        shading: Residual over idle level, (224, 224, 3).
    """
    smooth = cv2.GaussianBlur(shading, (0, 0), 2.0)
    changed = np.sqrt(np.square(smooth).mean(axis=-1)) > TOUCHED_SHARE
    inner = np.zeros(changed.shape, np.uint8)
    inner[RIM_PX:-RIM_PX, RIM_PX:-RIM_PX] = changed[RIM_PX:-RIM_PX, RIM_PX:-RIM_PX]
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (9, 9))
    patches = cv2.connectedComponentsWithStats(cv2.morphologyEx(inner, cv2.MORPH_CLOSE, disc))
    areas = patches[2][:, cv2.CC_STAT_AREA].astype(np.float64)
    areas[0] = 0
    return (areas > SMALL_PATCH * areas.max())[patches[1]]


def light_statistics(shading: Floats, touched: NDArray[np.bool_]) -> dict[str, float]:
    """Return how an imprint that is wholly in view brightens each channel, and towards where.

    With I / B - 1 = -A . grad d + a d and an indentation d that ends inside the view, the shading's
    mean is the depth term's alone, and its first moment is A times the imprint's volume, whatever
    the imprint's shape.

    Args:
        shading: Residual over idle level, (224, 224, 3).
        touched: Where the object touches, (224, 224).
    """
    rows, columns = np.nonzero(touched)
    arms = np.stack([columns - columns.mean(), (rows - rows.mean()) * ASPECT])
    values = shading[touched]
    moments = arms @ values
    full = np.hypot(*arms) @ np.abs(values)
    directions = {
        f"light {colour}": float(np.degrees(np.arctan2(moment[1], moment[0])))
        for colour, moment, most in zip(COLOURS, moments.T, full, strict=True)
        if np.hypot(*moment) > LEAST_DIPOLE * most
    }
    return by_colour("brightening", 100 * values.mean(axis=0, dtype=float)) | directions


def _is_whole(touched: NDArray[np.bool_]) -> bool:
    """Tell whether a touched region ends before the border in which none is looked for."""
    inner = slice(RIM_PX + 1, -RIM_PX - 1)
    return bool(touched.sum() == touched[inner, inner].sum())


def _beside(residual: Floats, touched: NDArray[np.bool_]) -> dict[str, float]:
    """Return what an idle frame and a touched one differ by where nothing touches."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * TAIL_PX + 1,) * 2)
    quiet = cv2.dilate(touched.astype(np.uint8), disc) == 0
    quiet = cropped(quiet[..., None])[..., 0]
    if quiet.mean() < LEAST_AREA:
        return {}
    fine = fine_part(residual)
    coarse = cropped(residual - fine)[quiet]
    return by_colour("beside", rms(cropped(fine)[quiet])) | {"spill": float(rms(coarse).mean())}


def _without_drift(residual: Floats) -> Floats:
    """Return the residual less each channel's mean over the half of the image changed least."""
    size = np.abs(cv2.GaussianBlur(residual, (0, 0), 2.0)).max(axis=-1)
    return residual - residual[size <= np.median(size)].mean(axis=0)


def _gradient(image: Floats, sigma_px: float) -> Floats:
    """Return the length of the gradient of the smoothed image, grey levels per pixel."""
    smooth = cv2.GaussianBlur(image, (0, 0), sigma_px)
    down, right = np.gradient(smooth, axis=(0, 1))
    return np.hypot(right, down)
