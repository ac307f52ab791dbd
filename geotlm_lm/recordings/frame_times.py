"""When a video's frames were taken, by their time stamps: their rate, and how long they last."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

EVEN_STEP = 0.25
"""Share of the usual time between two frames by which nine in ten may differ from it: stamps are
rounded to milliseconds, and single frames are dropped by any camera."""

SAME_RATE = 0.05
"""Share by which a header's frame rate may be off the time stamps'."""


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


def length_s(times_ms: Sequence[float]) -> float | None:
    """Return how long frames last, the last one included, s; None without times.

    Args:
        times_ms: When each frame was taken, in order.
    """
    if len(times_ms) < 2 or times_ms[-1] <= times_ms[0]:
        return None
    return (times_ms[-1] + float(np.median(np.diff(times_ms)))) / 1000
