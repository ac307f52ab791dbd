"""The one reading policy: how many frames are held, which, when they were taken, and the notes.

A reader gives a `Source`: what its file declares, and its frames, each decoded on demand.
`read_source` keeps those that fit and makes the clip; streams play the same frames.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from itertools import count, islice
from statistics import median
from typing import NamedTuple

import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import UnreadableClip

KEPT_BYTES = 512 * 2**20
"""Bytes of frames held at most: 2,300 frames of 320x240, a minute and a half at 25 fps."""

DECLARED_BYTES = 16 * 2**30
"""Bytes an array file may declare; more is taken for a damaged or hostile header."""

DECODED_FRAMES = 20_000
"""Frames decoded from a video at most: 20 s of work at 320x240 (measured: 0.9 ms a frame)."""

DECODING_S = 60.0
"""Seconds spent on decoding a video at most: one upload of huge frames must not hold up others."""

RATED_FRAMES = 32
"""Frames looked at before a recording is played, to learn its rate: 30 ms of work at 320x240."""

FEWEST_KEPT = 4
"""Frames that must fit at least, as many as an answer looks at: 44 million pixels each."""

EVEN_STEP = 0.25
"""Share of the usual time between two frames by which nine in ten may differ from it: stamps are
rounded to milliseconds, and single frames are dropped by any camera."""

FEWEST_EVEN = 0.9
"""Share of steps that come evenly, below which no frame rate holds."""

SAME_RATE = 0.05
"""Share by which a header's frame rate may be off the time stamps'."""

ROUNDED_S = 0.002
"""Difference that the rounding of stamps to milliseconds makes."""


class SourceFrame(NamedTuple):
    """A frame of a recording, not decoded yet.

    `decode` returns it as uint8 RGB, until the next frame is asked for; None where it and what
    follows cannot be decoded.
    """

    decode: Callable[[], Frames | None]
    stamp_ms: float | None = None
    received_ms: float | None = None  # by a recorder; None where only stamps are stored


@dataclass(eq=False)
class Source:
    """A recording's frames and what its file declares about them, read once.

    `frames` yields every n-th one, n given; n is 1 where `count` is None. What is not known before
    is filled in while frames are yielded: `header_fps`, `notes`.
    """

    name: str
    frames: Callable[[int], Iterator[SourceFrame]]
    count: int | None = None  # None where only reading tells: headers of videos are often wrong
    size: tuple[int, int] = (0, 0)  # rows and columns, of a known count
    stored_bytes: int = 0  # of a frame in another form that has to be held as well
    header_fps: float = 0.0  # 0 where the header does not say
    notes: list[str] = field(default_factory=list)
    # From the frames' times in ms and whether the recording was read to its end.
    end_notes: Callable[[Sequence[float], bool], Sequence[str]] = lambda times_ms, is_whole: ()
    no_frames: Callable[[], UnreadableClip] | None = None
    numbers: Sequence[int] = ()  # where the frames stood; () for one after the other
    is_whole: bool = True  # whether `count` is all of them


def read_source(source: Source) -> Clip:
    """Return the frames that fit as a clip, with notes on what was guessed and what was left out.

    Of a known count the stride is known too; else it doubles whenever what is kept no longer fits.

    Raises:
        UnreadableClip: If there is no frame, one is damaged or too large, or their sizes differ.
    """
    is_counted, is_whole = source.count is not None, source.is_whole
    stride = every = 1
    if is_counted:
        stride = every = stride_for(source.count, *source.size, source.name, source.stored_bytes)
    kept: list[Frames] = []
    times: list[tuple[float | None, float | None]] = []
    until, room = time.monotonic() + DECODING_S, None
    with closing(source.frames(stride)) as frames:
        for number, frame in zip(count(0, every), frames, strict=False):
            is_late = number >= FEWEST_KEPT and time.monotonic() > until
            if not is_counted and (number >= DECODED_FRAMES or is_late):
                is_whole = False
                break
            if number % stride == 0:
                image = frame.decode()
                if image is None:
                    break
                require_same_size(source, number, image, kept[0] if kept else image)
                if not is_counted and len(kept) >= kept_frames(*image.shape[:2], source.name):
                    kept, stride = kept[::2], 2 * stride
                if number % stride == 0:
                    if is_counted and room is None:  # stacked later they would be held twice
                        room = np.empty((-(-source.count // every), *image.shape), np.uint8)
                    if room is not None:
                        room[len(kept)] = image
                        image = room[len(kept)]
                    kept.append(image)
            times.append((frame.stamp_ms, frame.received_ms))
    if not kept:
        raise source.no_frames()
    seen = source.count or len(times)
    times_ms, clock_notes = one_clock(times)
    fps, rate_notes = rate_by(times_ms, source.header_fps)
    notes = [*source.notes, *clock_notes, *rate_notes, *source.end_notes(times_ms, is_whole)]
    if stride > 1:
        notes.append(stride_note(stride, seen))
    if not is_whole:
        notes.append(f"Only the first {seen} frames were read; cut the recording.")
    numbers = source.numbers or range(seen)
    return Clip(
        np.stack(kept) if room is None else room,
        fps=fps,
        name=source.name,
        frame_numbers=tuple(numbers[::stride]),
        recorded_frames=numbers[-1] + 1,
        notes=tuple(notes),
        times_s=uneven_times_s(times_ms, fps),
    )


def require_same_size(source: Source, number: int, image: Frames, first: Frames) -> None:
    """Refuse a frame of another size than the first."""
    if image.shape != first.shape:
        raise UnreadableClip(
            f"{source.name}: frame {number} is {image.shape[1]} x {image.shape[0]} pixels after "
            f"{first.shape[1]} x {first.shape[0]}, expected one size; record or export it at one "
            f"size."
        )


def kept_frames(rows: int, columns: int, name: str) -> int:
    """Return how many RGB frames of this size fit."""
    fitting = KEPT_BYTES // max(3 * rows * columns, 1)
    if fitting < FEWEST_KEPT:
        limit = KEPT_BYTES // (3 * FEWEST_KEPT) // 10**6
        raise UnreadableClip(
            f"{name}: frames are {columns}x{rows} pixels, expected at most {limit} million; "
            f"export the recording at a smaller size."
        )
    return fitting


def stride_for(frame_count: int, rows: int, columns: int, name: str, stored_bytes: int = 0) -> int:
    """Return the smallest stride at which frames fit, `stored_bytes` of each beside them."""
    fitting = kept_frames(rows, columns, name)
    if stored_bytes:
        fitting = min(fitting, KEPT_BYTES // stored_bytes)
    return -(-frame_count // fitting)


def stride_note(stride: int, frame_count: int) -> str:
    """Return what a stride above 1 left out."""
    return (
        f"Of {frame_count} frames one in {stride} was read to bound memory; "
        f"cut the recording to see all of them."
    )


def rate_ahead(source: Source) -> tuple[float | None, tuple[str, ...]]:
    """Return the frame rate by the first frames' times, and notes, as `rate_by` does."""
    with closing(source.frames(1)) as frames:
        times = [(frame.stamp_ms, frame.received_ms) for frame in islice(frames, RATED_FRAMES)]
    if not times:
        raise source.no_frames()
    times_ms, clock_notes = one_clock(times)
    fps, rate_notes = rate_by(times_ms, source.header_fps)
    return fps, (*clock_notes, *rate_notes)


def one_clock(
    times: Sequence[tuple[float | None, float | None]],
) -> tuple[Sequence[float], tuple[str, ...]]:
    """Return frames' times by one clock, ms, () without any; a note if these are not the stamps."""
    stamps_ms, received_ms = zip(*times, strict=True)
    is_stamped = None not in stamps_ms
    if received_ms[0] is None:
        return (stamps_ms if is_stamped else ()), ()
    if is_stamped and (np.diff(stamps_ms) > 0).all():
        return stamps_ms, ()
    lack = "do not rise" if is_stamped else "are missing"
    return received_ms, (
        f"Stamps of the images {lack}: the times at which the bag received them were taken.",
    )


def rate_by(times_ms: Sequence[float], header_fps: float) -> tuple[float | None, tuple[str, ...]]:
    """Return the frame rate, None where no single one holds; a note where the header errs."""
    steps = np.diff(np.asarray(times_ms, np.float64))
    if len(steps) < 2 or steps.min() <= 0:  # no stamps, or none to rely on
        return header_fps or None, ()
    usual = float(np.median(steps))
    is_even = np.abs(steps - usual) <= max(EVEN_STEP * usual, 2.0)
    if is_even.mean() < FEWEST_EVEN:
        return None, (
            f"The frames are {steps.min():.0f} to {steps.max():.0f} ms apart, so that no frame "
            f"rate holds for all of them; give that of the frames used by fps.",
        )
    measured = 1000 / float(steps[is_even].mean())
    if header_fps <= 0:
        return measured, ()
    if abs(measured - header_fps) <= SAME_RATE * measured:
        return header_fps, ()
    return measured, (
        f"The frame rate {measured:.4g} was taken from the frames' times; the header says "
        f"{header_fps:.4g}.",
    )


def uneven_times_s(times_ms: Sequence[float], fps: float | None) -> tuple[float, ...]:
    """Return when frames were taken, seconds from the first; () where `fps` says as much.

    Times that do not rise say nothing.
    """
    times = np.asarray(times_ms, np.float64)
    if len(times) < 2 or np.diff(times).min() <= 0:
        return ()
    times_s = (times - times[0]) / 1000
    if fps and np.abs(times_s - np.arange(len(times)) / fps).max() <= ROUNDED_S:
        return ()
    return tuple(times_s.tolist())


GAP_S, GAP_STEPS = 0.3, 4.0
"""Time between two frames, and the same in usual ones, from which on frames are missed."""

STEADY_STEPS = 15
"""Steps that the usual one is the median of."""

SET_BACK_FRAMES = 3
"""Frames in a row, rising among themselves, whose times lie back: then the clock was set."""


class FrameClock:
    """Turns the times of a source into times that rise."""

    def __init__(self) -> None:
        self._last_s, self._shift_s = -math.inf, 0.0
        self._steps: deque[float] = deque(maxlen=STEADY_STEPS)
        self._back: list[float] = []
        self._late, self._set_back, self._gaps = 0, -1, 0
        self._longest_s, self._after_gap = 0.0, -1

    def time_of(self, source_s: float, number: int) -> float | None:
        """Return when a frame was taken, in s, or None for a frame that is to be left out."""
        time_s = source_s + self._shift_s
        if not math.isfinite(time_s):
            self._late += 1
            return None
        if time_s <= self._last_s:
            if not self._is_set_back(source_s):
                self._late += 1
                return None
            # Those that were left out until the clock was known to be set took their time too.
            time_s = self._last_s + len(self._back) * self._usual_s
            self._shift_s, self._set_back = time_s - source_s, number
        elif self._steps:
            self._watch_for_gap(time_s - self._last_s, number)
        if math.isfinite(self._last_s):
            self._steps.append(time_s - self._last_s)
        self._last_s, self._back = time_s, []
        return time_s

    def notes(self) -> list[str]:
        """Return what was amiss, one sentence each."""
        notes = []
        if self._late:
            notes.append(f"{self._late} frames were no later than those before and left out.")
        if self._set_back >= 0:
            notes.append(
                f"The frames' times go back before frame {self._set_back}; they count on from "
                f"there."
            )
        if self._gaps:
            often = "" if self._gaps == 1 else f"; {self._gaps - 1} shorter gaps"
            notes.append(
                f"No frame came for {self._longest_s:.2f} s before frame {self._after_gap}{often}: "
                f"what happened meanwhile is not known."
            )
        return notes

    @property
    def _usual_s(self) -> float:
        return median(self._steps) if self._steps else 0.04

    def _is_set_back(self, source_s: float) -> bool:
        rises = self._back and source_s > self._back[-1]
        self._back = [*self._back, source_s] if rises else [source_s]
        return len(self._back) >= SET_BACK_FRAMES

    def _watch_for_gap(self, step_s: float, number: int) -> None:
        if step_s <= max(GAP_S, GAP_STEPS * self._usual_s):
            return
        self._gaps += 1
        if step_s > self._longest_s:
            self._longest_s, self._after_gap = step_s, number
