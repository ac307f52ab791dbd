"""The few frames of a recording that show its motion; knows contact and ways, names no motion."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from numbers import Integral

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.recordings.idle import activity_grey, find_idle, split_in_two
from geotlm_lm.recordings.imprints import imprints_of, strength_of
from geotlm_lm.recordings.travel import main_way, travelled_path

CONTACT_SHARE = 0.6
"""Share of the strongest imprint (its 0.9 quantile) that counts as full contact: above it, real
presses are past pressing in and before release."""

LIKENESS = 0.7
"""Correlation neighbouring chosen frames must keep: beyond about ten degrees of turn it falls
below, and dense optical flow breaks there too. From 0.6 to 0.8 real recordings score alike."""

MOST_TURN_RAD = 0.15
"""Turn between neighbouring chosen frames as `travelled_path` measures it: 9 degrees, about twice
that in truth. Shapes that a part of a turn lays on themselves look alike beyond it."""

NO_WAY = 0.03
"""Main motion, in radii of the imprint, below which the path is no more than noise: a motion too
sudden for it, as in a recording that repeats its frames, or none. Of 134 real recordings none is
below."""

LEAST_OF_WAY, LEAST_WAY = 0.1, 0.15
"""How much of the main motion a window must show, as a share and in radii of the imprint, whichever
is less; where none does whose frames look alike, the motion is too fast for it, and frames in
direct succession are taken."""

NEXT_TO_BEST = 0.95
"""Share of the best window's shortest step from which windows count as equally good; the one in the
middle of the main motion is taken. Along an even turn noise would decide otherwise."""

STEADINESS = 1.15
"""Largest ratio of imprint strengths among chosen frames: pressing in and releasing change the
strength, turning and sliding do not."""

STILL_CHANGE = 0.01
"""Loss of correlation from the first to the last chosen frame below which nothing moves in it."""

FAINT_IMPRINT = 0.75
"""Grey levels (rms) by which a touch changes the image, against a known background. Measured on
real recordings: 90 % of untouched frames are below 0.66, 95 % of those in contact above 0.8."""

CANDIDATE_LIMIT = 512
"""Frames compared with each other at most; longer recordings are compared at a stride."""


def choose_frames(
    clip: Clip, count: int = FRAME_COUNT, *, span: tuple[int, int] | None = None
) -> Clip:
    """Return the `count` frames that show the motion best, in time order.

    A clip of exactly `count` frames stays as it is. A shorter one repeats frames evenly: a, b
    becomes a, a, b, b and a, b, c becomes a, b, b, c, so that playing it backwards stays exactly
    that. From a longer one, frames at full contact and steady strength are taken, evenly spaced
    over the span in which each step goes furthest along the recording's main motion while
    neighbours still look alike; so a small turn back before it, or a slip after it, is not taken
    for it. Where the imprint only grows or fades, they span that change. An idle gel found in the
    recording becomes the background.

    Args:
        clip: A recording of any length from 2 frames.
        count: How many frames to return, at least 2.
        span: First and last frame to use instead, both included, by their `frame_numbers`: counted
            from 0 in the recording, also where it was read at a stride.

    Returns:
        A clip of `count` frames whose last note says which ones they are.

    Raises:
        UnreadableClip: If the clip has only one frame.
        UsageError: If the span is not inside the clip, runs backwards, or holds one frame only.
        TypeError: If the span is not two whole numbers.
    """
    require_motion(clip)
    if span is None and len(clip) == count:
        return _told(clip)
    asked = None if span is None else _inside(clip, span)
    grey = None
    if clip.background is None and len(clip) > count:
        grey = activity_grey(clip.frames)
        idle = find_idle(clip, grey)
        if idle is not None:
            note = "Background: the recording's own untouched frames."
            clip = replace(clip, background=idle).with_note(note)
    if asked is not None:
        indices = asked[_evenly(0, len(asked) - 1, count)]
    elif len(clip) < count:
        indices = _evenly(0, len(clip) - 1, count)
    else:
        indices = _indices_of_motion(clip, count, grey)
    return _told(clip.select([int(index) for index in indices]))


def require_motion(clip: Clip) -> None:
    """Refuse a clip in which nothing can move.

    Raises:
        UnreadableClip: If it has only one frame.
    """
    if len(clip) < 2:
        raise UnreadableClip(
            f"{clip.name}: only 1 frame was found, motion needs 2 or more; give a recording, or "
            f"several frames of it."
        )


def _told(clip: Clip) -> Clip:
    numbers = ", ".join(str(number) for number in clip.frame_numbers)
    note = f"Frames {numbers} are used."
    return clip if note in clip.notes else clip.with_note(note)


def _inside(clip: Clip, span: tuple[int, int]) -> NDArray[np.int64]:
    """Return the indices of the frames of `span`, two or more."""
    first, last = _two_numbers(span)
    numbers = np.asarray(clip.frame_numbers)
    if not numbers.min() <= first < last <= numbers.max():
        raise UsageError(
            f"Frames {first}:{last} were asked for, expected FIRST < LAST within "
            f"{numbers.min()}:{numbers.max()}; give frame numbers inside the recording."
        )
    inside = np.flatnonzero((numbers >= first) & (numbers <= last))
    if len(inside) < 2:
        raise UsageError(
            f"Frames {first}:{last} hold {len(inside)} of the frames that were read, expected 2 or "
            f"more; give a longer span, or cut the recording so that all of it is read."
        )
    return inside


def _two_numbers(span: object) -> tuple[int, int]:
    numbers = tuple(span) if isinstance(span, Iterable) else ()
    if len(numbers) != 2 or not all(isinstance(number, Integral) for number in numbers):
        raise TypeError(
            f"a span is two frame numbers, found {str(span)[:40]}; give the first and the last to "
            f"use, such as (40, 60)"
        )
    return numbers


def _indices_of_motion(
    clip: Clip, count: int, grey: NDArray[np.float32] | None
) -> NDArray[np.int64]:
    """Return the indices of the most telling window of a clip longer than `count`.

    On 180 simulated recordings the model's words are right on 164, where they are on 155 if the
    window is the one whose ends look least alike; on 134 real ones on 126 and 122.

    Args:
        clip: The recording.
        count: Frames of a window.
        grey: Its `activity_grey`, if that is known already.
    """
    stride = -(-len(clip) // CANDIDATE_LIMIT)
    grey = activity_grey(clip.frames[::stride]) if grey is None else grey[::stride]
    imprints = imprints_of(grey, clip.background)
    strength = strength_of(imprints)
    flat = (imprints / np.maximum(strength, 1e-6)[:, None, None]).reshape(len(imprints), -1)
    likeness = flat @ flat.T / flat.shape[1]
    is_full = strength > _full_contact(strength)
    windows = _windows(len(imprints), count)
    strengths = strength[windows]
    is_steady = (
        is_full[windows].all(axis=0)
        & (strengths.max(axis=0) < STEADINESS * strengths.min(axis=0))
        & (1 - likeness[windows[0], windows[-1]] > STILL_CHANGE)
    )
    path = travelled_path(imprints, is_full)
    way = main_way(path)
    far = float(np.linalg.norm(way))
    if far < NO_WAY:
        return _least_alike(likeness, strength, windows) * stride
    along = path @ way / far
    went = np.diff(along[windows], axis=0)  # (count - 1, windows)
    aside = np.abs(along[windows[[0, -1]]].mean(axis=0) - (along.min() + along.max()) / 2)
    turned = np.abs(np.diff(path[windows, 2], axis=0))
    steps = likeness[windows[:-1], windows[1:]]
    is_alike = (steps.min(axis=0) > LIKENESS) & (turned.max(axis=0) < MOST_TURN_RAD)
    is_shortest = windows[-1] - windows[0] == count - 1
    best = _most_even(is_steady & is_alike, went, aside)
    if best is None or went[:, best].sum() < min(LEAST_OF_WAY * far, LEAST_WAY):
        best = _most_even(is_steady & (is_alike | is_shortest), went, aside)
    if best is not None:
        return windows[:, best] * stride
    return _growth(strength, count) * stride


def _least_alike(
    likeness: NDArray[np.float32], strength: NDArray[np.float32], windows: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return the window whose ends look least alike while neighbours do look alike."""
    full = max(CONTACT_SHARE * float(np.quantile(strength, 0.9)), split_in_two(strength)[0])
    strengths, steps = strength[windows], likeness[windows[:-1], windows[1:]]
    is_fit = (
        (strengths.min(axis=0) > full)
        & (steps.min(axis=0) > LIKENESS)
        & (strengths.max(axis=0) < STEADINESS * strengths.min(axis=0))
    )
    change = np.where(is_fit, 1 - likeness[windows[0], windows[-1]], -1.0)
    best = int(np.argmax(change))
    return windows[:, best] if change[best] > STILL_CHANGE else _growth(strength, len(windows))


def _full_contact(strength: NDArray[np.float32]) -> float:
    """Return the strength above which a frame is at full contact.

    Where frames fall into a weak and a strong group, it is only the strong one. Without a known gel
    the two are next to equal: its own structure outweighs the touch, and every frame counts.
    """
    full = CONTACT_SHARE * float(np.quantile(strength, 0.9))
    threshold, gap = split_in_two(strength)
    is_weak_apart = threshold - gap / 2 < CONTACT_SHARE * (threshold + gap / 2)
    return max(full, threshold) if is_weak_apart else full


def _most_even(
    is_fit: NDArray[np.bool_], went: NDArray[np.float64], aside: NDArray[np.float64]
) -> int | None:
    """Return the fit window whose shortest step goes furthest; None where none is fit.

    Of windows next to equal, it is the one in the middle of the motion: forwards and backwards the
    same.

    Args:
        is_fit: Shape (windows,).
        went: Way of each step along the main motion, shape (steps, windows).
        aside: Way from the window's middle to the motion's, shape (windows,).
    """
    if not is_fit.any():
        return None
    shortest = np.where(is_fit, went.min(axis=0), -np.inf)
    best = shortest.max()
    is_as_good = shortest >= best - (1 - NEXT_TO_BEST) * abs(best)
    return int(np.argmin(np.where(is_as_good, aside, np.inf)))


def _windows(frame_count: int, count: int) -> NDArray[np.int64]:
    """Return all evenly spaced windows of `count` different frames, shape (count, windows).

    Their frames are the rows: what is asked of every window is then asked of whole rows, in a tenth
    of the time that numpy takes for as many columns.
    """
    first, last = np.triu_indices(frame_count, count - 1)
    share = np.arange(count)[:, None] / (count - 1)
    return np.rint(first + (last - first) * share).astype(np.int64)


def _growth(strength: NDArray[np.float32], count: int) -> NDArray[np.int64]:
    """Return frames over which the imprint grows or, if it was there from the start, fades."""
    weakest, strongest = float(strength.min()), float(strength.max())
    if strongest <= STEADINESS * weakest:  # equal where all frames are, and both are 0
        return _evenly(0, len(strength) - 1, count)
    is_weak = strength < weakest + 0.1 * (strongest - weakest)
    is_strong = strength > weakest + 0.9 * (strongest - weakest)
    peak = int(np.argmax(is_strong))
    before = np.flatnonzero(is_weak[:peak])
    if len(before):
        return _evenly(int(before[-1]), peak, count)
    faded = int(np.argmax(is_weak))
    return _evenly(int(np.flatnonzero(is_strong[:faded])[-1]), faded, count)


def _evenly(first: int, last: int, count: int) -> NDArray[np.int64]:
    return np.rint(np.linspace(first, last, count)).astype(np.int64)
