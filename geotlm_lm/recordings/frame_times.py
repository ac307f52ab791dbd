"""When a video's frames were taken, by their time stamps: their rate, and whether all are there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

EVEN_STEP = 0.25
"""Share of the usual time between two frames by which nine in ten may differ from it: stamps are
rounded to milliseconds, and single frames are dropped by any camera."""

SAME_RATE = 0.05
"""Share by which a header's frame rate may be off the time stamps'."""

WHOLE_SHARE = 0.95
"""Share of the declared length that a whole video has at least."""


def rate_by(times_ms: Sequence[float], told: float) -> tuple[float | None, tuple[str, ...]]:
    """Return the frame rate, None where there is no single one; a note where the header errs.

    Args:
        times_ms: When each frame was taken, in order.
        told: Frames per second by the header; 0 where it does not say.
    """
    steps = np.diff(np.asarray(times_ms, np.float64))
    if len(steps) < 2 or steps.min() <= 0:  # no stamps, or none to rely on
        return told or None, ()
    usual = float(np.median(steps))
    is_even = np.abs(steps - usual) <= max(EVEN_STEP * usual, 2.0)
    if is_even.mean() < 0.9:
        return None, (
            f"The frames are {steps.min():.0f} to {steps.max():.0f} ms apart, so that no frame "
            f"rate holds for all of them; give that of the frames used by fps.",
        )
    found = 1000 / float(steps[is_even].mean())
    if told <= 0:
        return found, ()
    if abs(found - told) <= SAME_RATE * found:
        return told, ()
    return found, (
        f"The frame rate {found:.4g} was taken from the frames' times; the header says {told:.4g}.",
    )


def uneven_times_s(times_ms: Sequence[float], fps: float | None) -> tuple[float, ...]:
    """Return when frames were taken, seconds from the first; () where `fps` tells as much.

    Args:
        times_ms: When each frame was taken, in order; where they do not rise, they tell nothing.
        fps: Their rate, as `rate_by` returns it.
    """
    times = np.asarray(times_ms, np.float64)
    if len(times) < 2 or np.diff(times).min() <= 0:
        return ()
    times_s = (times - times[0]) / 1000
    if fps and np.abs(times_s - np.arange(len(times)) / fps).max() <= ROUNDED_S:
        return ()
    return tuple(times_s.tolist())


ROUNDED_S = 0.002
"""Difference that the rounding of stamps to milliseconds makes."""


def cut_off_note(times_ms: Sequence[float], declared: float, told: float) -> tuple[str, ...]:
    """Return a note where frames that the header declares are missing.

    Args:
        times_ms: When each decoded frame was taken, in order.
        declared: How many frames the header declares.
        told: Frames per second by the header; 0 where it does not say.
    """
    if len(times_ms) < 2 or told <= 0 or len(times_ms) >= WHOLE_SHARE * declared:
        return ()
    length_s = (times_ms[-1] + float(np.median(np.diff(times_ms)))) / 1000
    if length_s >= WHOLE_SHARE * declared / told:  # a rate too high declares too many frames
        return ()
    return (
        f"Only the first {length_s:.1f} s of {declared / told:.1f} s can be decoded: the file is "
        f"cut off or damaged; copy or record it again.",
    )
