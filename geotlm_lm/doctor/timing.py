"""When frames were taken: rate and jitter, frames that repeat, are missing, or were cut off."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip
from geotlm_lm.doctor.finding import Finding, judged
from geotlm_lm.recordings.containers import declared_end
from geotlm_lm.recordings.policy import EVEN_STEP, ROUNDED_S
from geotlm_lm.recordings.video import VIDEO_SUFFIXES
from geotlm_lm.track.frame_clock import FrameClock

FEWEST_EVEN = 0.9
"""Share of steps that come evenly, below which no frame rate holds; as `rate_by` judges."""

MISSED_STEP = 1.5
"""Steps in usual ones from which on frames are missing between two."""

MOST_MISSED = 0.01
"""Share of frames that may be missing: single ones are dropped by any camera."""

MOST_REPEATED = 0.01
"""Share of frames that may equal the one before in every pixel. On 65 real recordings that
thresholds are chosen by none does, MPEG-4 ones among them: noise alone tells two frames apart."""


def frame_rate(clip: Clip) -> Finding:
    """Judge how evenly frames come."""
    if not clip.times_s:
        return _untimed_rate(clip)
    steps, usual = _steps(clip)
    even = np.abs(steps - usual) <= EVEN_STEP * usual
    low, high = np.quantile(steps, (0.05, 0.95))
    is_uneven = even.mean() < FEWEST_EVEN
    return judged(
        "frame rate",
        f"{1 / usual:.1f} frames per second; nine in ten steps are {1e3 * low:.1f} to "
        f"{1e3 * high:.1f} ms (jitter {500 * (high - low):.1f} ms).",
        "Times and speeds are told by the frames' own times, and no rate holds for all: what "
        "happens within a long step is not seen.",
        "Lock the camera's exposure, which sets its rate, and record without writing to a slow "
        "disk; do not give --fps, which would take the frames for even.",
        is_fault=bool(is_uneven),
    )


def _untimed_rate(clip: Clip) -> Finding:
    if clip.fps is not None:
        even = f"even to {1e3 * ROUNDED_S:g} ms as far as the file tells"
        return Finding("frame rate", "fine", f"{clip.fps:.4g} frames per second, {even}.")
    return Finding(
        "frame rate",
        "unknown",
        "neither times nor a rate are told.",
        "Events are told by frame numbers, and no speed is.",
        "Give the camera's rate by --fps.",
    )


def missing_frames(clip: Clip) -> Finding:
    """Judge whether frames were dropped, by the gaps between times, or between their numbers."""
    subject, notes = "dropped frames", []
    if clip.times_s:
        steps, usual = _steps(clip)
        clock = FrameClock()
        for number, time_s in enumerate(clip.times_s):
            clock.time_of(time_s, number)
        notes = clock.notes()
    else:
        steps = np.diff(clip.frame_numbers)
        usual = float(steps.min())
        if usual == steps.max():
            return _undropped(subject, clip)
    missed = int((np.rint(steps / usual) - 1)[steps > MISSED_STEP * usual].sum())
    count = len(steps) + 1 + missed
    share = missed / count
    return judged(
        subject,
        " ".join([f"{missed} of {count} ({share:.1%}).", *notes]),
        "An object goes farther between two frames than it seems: a turn of more than 45 degrees "
        "in one step is not followed, and slips in a gap are not seen.",
        "Record at a lower rate or size, to a faster disk, or with a larger queue of the recorder.",
        is_fault=share > MOST_MISSED,
    )


def file_end(clip: Clip) -> list[Finding]:
    """Judge whether a video's file is there to its end; nothing of other recordings."""
    path = Path(clip.name)
    end = declared_end(path) if path.suffix.lower() in VIDEO_SUFFIXES and path.is_file() else None
    if end is None:
        return []
    note = end.note()
    measured = note or f"all {end.present_bytes} bytes that the file declares are there."
    means = "Whatever moves later is not part of any answer, nor of the totals of a track."
    advice = "Wait until it is written, copy it again, or take the totals for a part's."
    return [judged("end of the file", measured, means, advice, is_fault=note is not None)]


def _undropped(subject: str, clip: Clip) -> Finding:
    if clip.fps is None:
        return Finding(subject, "unknown", "cannot be told without the frames' times.")
    return Finding(subject, "fine", "none, by the frames' times.")


def repeated_frames(is_repeat: NDArray[np.bool_], *, is_every: bool) -> Finding:
    """Judge whether frames were written twice.

    Args:
        is_repeat: Whether each frame but the first equals the one before, (n - 1,).
        is_every: Whether these are neighbours in the recording.
    """
    subject = "repeated frames"
    if not is_every or not len(is_repeat):
        measured = "cannot be told: the recording was read at a stride."
        return Finding(subject, "unknown", measured, advice="Give a shorter part of it.")
    share = float(is_repeat.mean())
    return judged(
        subject,
        f"{int(is_repeat.sum())} of {len(is_repeat) + 1} equal the one before ({share:.1%}).",
        "A repeated frame seems held still and the next one twice as fast: rests and slips are "
        "told that were none.",
        "Record at the camera's own rate, which is below the recorder's, or leave repeats out.",
        is_fault=share > MOST_REPEATED,
    )


def _steps(clip: Clip) -> tuple[NDArray[np.float64], float]:
    steps = np.diff(np.asarray(clip.times_s))
    return steps, float(np.median(steps))
