"""The frames of a recording that are asked for; refuses what can show no motion."""

from __future__ import annotations

from collections.abc import Iterable
from numbers import Integral

import numpy as np

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip, UsageError, require_inside


def require_motion(clip: Clip) -> Clip:
    """Refuse a clip in which nothing can move.

    Raises:
        UnreadableClip: If it has only one frame.
    """
    if len(clip) < 2:
        raise UnreadableClip(
            f"{clip.name}: only 1 frame was found, motion needs 2 or more; give a recording, or "
            f"several frames of it."
        )
    return clip


def frames_inside(clip: Clip, span: tuple[int, int]) -> Clip:
    """Return the frames of a span, two or more.

    Args:
        clip: The recording.
        span: First and last frame, both included, by their `frame_numbers`: counted from 0 in the
            recording, also where it was read at a stride.

    Raises:
        UsageError: If the span is not inside the clip, runs backwards, or holds one frame only.
        TypeError: If the span is not two whole numbers.
    """
    first, last = _two_numbers(span)
    numbers = np.asarray(clip.frame_numbers)
    require_inside(first, last, int(numbers.min()), int(numbers.max()))
    inside = np.flatnonzero((numbers >= first) & (numbers <= last))
    if len(inside) < 2:
        raise UsageError(
            f"Frames {first}:{last} hold {len(inside)} of the frames that were read, expected 2 or "
            f"more; give a longer span, or cut the recording so that all of it is read."
        )
    return clip.select([int(index) for index in inside])


def _two_numbers(span: object) -> tuple[int, int]:
    numbers = tuple(span) if isinstance(span, Iterable) else ()
    if len(numbers) != 2 or not all(isinstance(number, Integral) for number in numbers):
        raise TypeError(
            f"a span is two frame numbers, found {str(span)[:40]}; give the first and the last to "
            f"use, such as (40, 60)"
        )
    return numbers
