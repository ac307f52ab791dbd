"""What is measured of tactile images, and the statistics of the untouched gel.

Every number comes from the images alone, so that real and simulated ones are measured alike.
Images are float32 (224, 224, 3), RGB grey levels.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE

Floats = NDArray[np.float32]

COLOURS = ("R", "G", "B")


@dataclass(frozen=True)
class Statistic:
    """What a number is.

    Args:
        group: "camera", "idle gel", "contact", or "ball" where the shape has to be known.
        title: What it measures.
        unit: Its unit.
    """

    group: str
    title: str
    unit: str


def _each(group: str, key: str, title: str, unit: str) -> dict[str, Statistic]:
    return {f"{key} {c}": Statistic(group, f"{title}, {c}", unit) for c in COLOURS}


STATISTICS: dict[str, Statistic] = {
    **_each("camera", "noise", "noise between idle frames", "grey"),
    "noise neighbour": Statistic("camera", "noise, correlation with the next pixel", "1"),
    "noise R-B": Statistic("camera", "noise, correlation of R and B", "1"),
    "drift": Statistic("camera", "brightness drift between idle frames", "grey"),
    **_each("camera", "beside", "fine residual beside the contact", "grey"),
    "spill": Statistic("camera", "coarse residual beside the contact", "grey"),
    **_each("idle gel", "pattern", "fixed pattern", "grey"),
    **_each("idle gel", "level", "mean level", "grey"),
    **_each("idle gel", "corners", "corners over middle", "%"),
    **_each("idle gel", "right", "right less left half, over the mean", "%"),
    **_each("idle gel", "lower", "lower less upper half, over the mean", "%"),
    **_each("idle gel", "remainder", "remainder of a degree-4 field", "grey"),
    "area": Statistic("contact", "share of the image", "%"),
    **_each("contact", "residual", "residual, RMS", "grey"),
    **_each("contact", "shading", "residual over idle level, RMS", "%"),
    **_each("contact", "brightening", "residual over idle level, mean", "%"),
    "contact B-R": Statistic("contact", "correlation of B and R", "1"),
    "contact G-R": Statistic("contact", "correlation of G and R", "1"),
    "contact G-B": Statistic("contact", "correlation of G and B", "1"),
    **_each("contact", "gradient", "gradient, 95th percentile", "grey/px"),
    **_each("contact", "sharpness", "gradients at 1 px over those at 3 px, RMS", "1"),
    **_each("contact", "light", "direction brightened, clockwise from right", "degree"),
    **_each("ball", "depth", "mean brightening per mm of cap", "%/mm"),
}
"""Key -> what it is, in the order of the tables."""

FINE_SIGMA_PX = 3.0
"""Finer than this Gaussian is noise, pattern and edges; coarser is shading and drift."""

RIM_PX = 12
"""Border left out where contact or fine structure is measured: 1 mm, the rim of real gels, and as
far as a Gaussian of `FINE_SIGMA_PX` bends a slope there."""

SPECK_GREY = 5.0
"""Farther off its surroundings is a speck, no pattern: 5 standard deviations of the pattern."""

CORNER_PX = IMAGE_SIDE // 8
"""Side of the squares whose means stand for a corner, and for the middle."""


def camera_statistics(frames: Floats) -> dict[str, float]:
    """Return the noise of successive idle frames.

    Args:
        frames: (t, 224, 224, 3); fewer than two give nothing.
    """
    if len(frames) < 2:
        return {}
    change = np.diff(frames, axis=0) / np.float32(np.sqrt(2))
    # Sums in double precision: of 50,000 values, single precision keeps four digits.
    drift = np.sqrt(np.square(change.mean(axis=(1, 2), dtype=np.float64)).mean())
    fine = cropped(np.stack([fine_part(one) for one in change])).astype(np.float64)
    power = np.square(fine).mean(axis=(0, 1, 2))
    beside = (fine[:, :, 1:] * fine[:, :, :-1]).mean(axis=(0, 1, 2))
    together = (fine[..., 0] * fine[..., 2]).mean()
    return by_colour("noise", np.sqrt(power)) | {
        "noise neighbour": float((beside / np.maximum(power, 1e-9)).mean()),
        "noise R-B": float(together / max(np.sqrt(power[0] * power[2]), 1e-9)),
        "drift": float(drift),
    }


def pattern_statistics(early: Floats, late: Floats) -> dict[str, float]:
    """Return the fixed pattern: the fine structure that two idle images share.

    Args:
        early: Mean of some idle frames, (224, 224, 3).
        late: Mean of others whose noise is independent of theirs.
    """
    first, second = (cropped(fine_part(one)) for one in (early, late))
    is_plain = np.maximum(np.abs(first), np.abs(second)) < SPECK_GREY
    shared = np.mean(first * second, axis=(0, 1), where=is_plain, dtype=np.float64)
    return by_colour("pattern", np.sqrt(np.maximum(shared, 0)))


def idle_statistics(idle: Floats) -> dict[str, float]:
    """Return the level and the smooth field of an idle image (224, 224, 3)."""
    idle = idle.astype(np.float64)
    level, half, side = idle.mean(axis=(0, 1)), IMAGE_SIDE // 2, CORNER_PX
    ends = (slice(None, side), slice(-side, None))
    corners = np.mean([idle[rows, columns].mean(axis=(0, 1)) for rows in ends for columns in ends],
                      axis=0)  # fmt: skip
    inner = slice(half - side // 2, half + side // 2)
    middle = idle[inner, inner].mean(axis=(0, 1))
    right = idle[:, half:].mean(axis=(0, 1)) - idle[:, :half].mean(axis=(0, 1))
    lower = idle[half:].mean(axis=(0, 1)) - idle[:half].mean(axis=(0, 1))
    return (
        by_colour("level", level)
        | by_colour("corners", 100 * corners / middle)
        | by_colour("right", 100 * right / level)
        | by_colour("lower", 100 * lower / level)
        | by_colour("remainder", _remainder(idle))
    )


def _remainder(idle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the RMS of what a polynomial of total degree 4 leaves of an image, by channel."""
    small = cv2.resize(idle, (IMAGE_SIDE // 4,) * 2, interpolation=cv2.INTER_AREA)
    axis = np.linspace(-1, 1, IMAGE_SIDE // 4)
    powers = np.polynomial.legendre.legvander2d(*np.meshgrid(axis, axis), [4, 4])
    i, j = np.divmod(np.arange(25), 5)
    basis = powers.reshape(-1, 25)[:, i + j <= 4]
    values = small.reshape(-1, 3).astype(np.float64)
    return rms(values - basis @ np.linalg.lstsq(basis, values, rcond=None)[0])


def fine_part(image: Floats) -> Floats:
    """Return an image less its Gaussian average of `FINE_SIGMA_PX`."""
    return image - cv2.GaussianBlur(image, (0, 0), FINE_SIGMA_PX)


def cropped(images: NDArray) -> NDArray:
    """Return images (..., rows, columns, channels) less a border of `RIM_PX`."""
    inner = slice(RIM_PX, -RIM_PX)
    return images[..., inner, inner, :]


def rms(values: NDArray) -> NDArray:
    """Return the root of the mean square over the first axis."""
    return np.sqrt(np.square(values).mean(axis=0, dtype=np.float64))


def by_colour(key: str, values: NDArray) -> dict[str, float]:
    """Return the three channels' values under "`key` R", "`key` G" and "`key` B"."""
    return {f"{key} {c}": float(value) for c, value in zip(COLOURS, values, strict=True)}
