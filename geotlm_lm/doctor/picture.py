"""The picture's form: its size, the shape of its pixels, and how the camera is mounted."""

from __future__ import annotations

from geotlm_lm.core.clip import Clip
from geotlm_lm.doctor.finding import Finding, judged
from geotlm_lm.recordings.pixels import SQUASHED
from geotlm_lm.recordings.stated_shape import TURN_NOTES, TURNS
from geotlm_lm.recordings.touch import COLUMNS

WIDEST = 2.0
"""Width over height, or the other way, beyond which no camera's picture has square pixels."""


def size(clip: Clip) -> Finding:
    """Judge how many pixels there are."""
    rows, columns = clip.frames.shape[1:3]
    return judged(
        "size",
        f"{columns} x {rows} pixels.",
        f"Contact is measured at {COLUMNS} columns: fine imprints are lost in fewer.",
        "Export the recording at the camera's own size.",
        is_fault=max(rows, columns) < COLUMNS,
    )


def pixel_shape(clip: Clip) -> Finding:
    """Judge whether pixels are as wide as high, which a picture's size tells in part only."""
    rows, columns = clip.frames.shape[1:3]
    subject, measured = "pixel shape", f"{columns} x {rows}, {columns / rows:.2f} wide for 1 high"
    if SQUASHED in clip.notes:
        return Finding(
            subject,
            "unknown",
            f"{measured}: taken for a 4:3 picture squashed to a square.",
            "Where that is wrong, lengths across are told a third too long, and turns are skewed.",
            "Give --square-pixels if the camera's picture is square, else --no-square-pixels.",
        )
    return judged(
        subject,
        f"{measured}.",
        "The picture seems stretched, as of one field of two or of a squashed export: turns are "
        "skewed, and lengths differ across and down.",
        "Export it at the camera's own shape, mostly 4:3.",
        is_fault=max(rows, columns) > WIDEST * min(rows, columns),
    )


def mount(clip: Clip) -> Finding:
    """Judge how the picture is turned: as its file states, else by its shape, a quarter only."""
    rows, columns = clip.frames.shape[1:3]
    stated = next((turn for turn, note in TURN_NOTES.items() if note in clip.notes), None)
    if stated is not None:
        return Finding(
            "mount",
            "limit",
            f"the file states pictures {TURNS[stated]}, and so they were.",
            "Directions are told as the turned picture shows them.",
            "Slide something to the right and ask; if the answer is another, record without it.",
        )
    if rows > columns:
        return Finding(
            "mount",
            "fault",
            f"the picture is {columns} wide and {rows} high; cameras take them wide.",
            "It was turned by a quarter, which way cannot be told: left and right are told as up "
            "and down of an upright one.",
            'State it in a conversation: "the image is rotated by 90 degrees clockwise", or '
            "counterclockwise.",
        )
    return Finding(
        "mount",
        "unknown",
        "a mirror or a half turn cannot be told from frames.",
        "Directions are told as the image shows them.",
        "Slide something to the right and ask; if the answer is another, state it in a "
        'conversation: "the image is mirrored", or "the camera is mounted upside down".',
    )
