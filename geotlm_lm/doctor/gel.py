"""The gel: whether it is seen idle, what touches it, its colours and its markers."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.doctor.finding import Finding, judged
from geotlm_lm.recordings.idle import FAINT_IMPRINT, find_idle, imprint_strength

RED_OVER_BLUE = (0.95, 1.1)
"""Mean red over mean blue of an idle gel: below it colours are in order, above it they are swapped.
65 real recordings of GelSight Minis that thresholds are chosen by have 0.5 to 0.7, the calibration
pictures of two more 0.75, simulated gels 0.58 to 0.88."""

GREY_LEVELS = 1.0
"""Mean difference of colours below which a recording is grey."""

MARKED_WIDTH = 320
"""Columns of the picture that markers are looked for in."""

MARKER_PX, MARKER_DARKNESS, FEWEST_MARKERS = (4.0, 20.0), 0.2, 20
"""Least and greatest width of a dot there, share of the light that it swallows, dots of a grid."""

MOST_UNEVEN = 0.35
"""Spread of the distances of dots to their neighbours, relative to the usual one: a grid's."""


def idle_gel(clip: Clip) -> tuple[Finding, Frames | None]:
    """Judge whether the untouched gel is known; return it, None where it is not."""
    subject = "idle gel"
    if clip.background is not None:
        return Finding(subject, "fine", "given beside the frames."), clip.background
    idle = find_idle(clip)
    if idle is not None:
        return Finding(subject, "fine", "the recording starts or ends untouched."), idle
    return (
        Finding(
            subject,
            "fault",
            "no untouched part was found at the start or at the end.",
            "The gel is guessed from its shading: contact is not judged where nothing moves, and "
            "fine imprints are told less surely.",
            "Give a picture of it by --background, or start half a second before the touch.",
        ),
        None,
    )


def contrast(clip: Clip, idle: Frames | None) -> Finding:
    """Judge how strongly the gel is imprinted at most."""
    if idle is None:
        return Finding("contrast", "unknown", "cannot be told without the idle gel.")
    strongest = float(imprint_strength(replace(clip, background=idle)).max())
    return judged(
        "contrast",
        f"the strongest imprint changes the picture by {strongest:.2f} grey levels (rms).",
        f"An imprint below {FAINT_IMPRINT} cannot be told from an untouched gel.",
        "Press harder, or look whether the recording shows the touch at all.",
        is_fault=strongest < FAINT_IMPRINT,
    )


def colours(idle: Frames) -> Finding:
    """Judge the order of colours, as far as a gel's tint tells it.

    Args:
        idle: The gel, or the median of the frames.
    """
    red, green, blue = idle.reshape(-1, 3).mean(axis=0)
    subject, measured = "colour order", f"mean red {red:.0f}, green {green:.0f}, blue {blue:.0f}"
    ratio = red / max(blue, 1.0)
    if np.ptp(idle.astype(np.int16), axis=-1).mean() < GREY_LEVELS:
        means = "A grey picture tells less of the gel's slopes than a coloured one."
        return Finding(subject, "unknown", f"{measured}: the recording is grey.", means)
    if ratio > RED_OVER_BLUE[1]:
        return Finding(
            subject,
            "fault",
            f"{measured}: a GelSight Mini's gel has more blue than red.",
            "Blue seems to be first, as OpenCV has it: slopes are read from the wrong lights.",
            "Of an array say --layout BGR; convert anything else by cv2.cvtColor.",
        )
    if ratio < RED_OVER_BLUE[0]:
        return Finding(subject, "fine", f"{measured}, as on a GelSight Mini.")
    means = "Red and blue are too alike to tell their order by the gel's tint."
    return Finding(subject, "unknown", f"{measured}.", means)


def markers(idle: Frames) -> Finding:
    """Tell whether dots are printed on the gel.

    Args:
        idle: As of `colours`.
    """
    dots = marker_dots(idle)
    if not len(dots):
        return Finding("markers", "fine", "none seen.")
    spacing = np.median(_nearest(dots)) * idle.shape[1] / MARKED_WIDTH
    return Finding(
        "markers",
        "limit",
        f"{len(dots)} dots, {spacing:.0f} pixels apart.",
        "Turns are named as on a plain gel, slides less often, and amounts are told up to twice as "
        "far as the markers went.",
        "Nothing to set; look at the spread that is told beside an amount.",
    )


def marker_dots(idle: Frames) -> NDArray[np.float64]:
    """Return where dots lie, (n, 2) as (x, y) in a picture `MARKED_WIDTH` wide; (0, 2) of none."""
    rows = max(round(MARKED_WIDTH * 0.75), 1)  # a camera's picture, also where it was squashed
    grey = cv2.cvtColor(cv2.resize(idle, (MARKED_WIDTH, rows)), cv2.COLOR_RGB2GRAY)
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (25, 25))
    bright = cv2.morphologyEx(grey, cv2.MORPH_CLOSE, around).astype(np.float32)
    dark = ((bright - grey) > MARKER_DARKNESS * np.maximum(bright, 1)).astype(np.uint8)
    _, _, about, centres = cv2.connectedComponentsWithStats(dark)
    width, height = about[:, cv2.CC_STAT_WIDTH], about[:, cv2.CC_STAT_HEIGHT]
    low, high = MARKER_PX
    is_dot = (np.minimum(width, height) >= low) & (np.maximum(width, height) <= high)
    is_dot &= np.maximum(width, height) < 2 * np.minimum(width, height)
    is_dot[0] = False  # what is around them
    dots = centres[is_dot]
    if len(dots) < FEWEST_MARKERS:
        return np.empty((0, 2))
    apart = _nearest(dots)
    return dots if apart.std() <= MOST_UNEVEN * np.median(apart) else np.empty((0, 2))


def _nearest(dots: NDArray[np.float64]) -> NDArray[np.float64]:
    apart = np.hypot(*(dots[:, None] - dots[None]).transpose(2, 0, 1))
    np.fill_diagonal(apart, np.inf)
    return apart.min(axis=1)
