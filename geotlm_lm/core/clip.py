"""A tactile clip: frames of a camera-based touch sensor, checked at birth."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.errors import UnreadableClip

Frames = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Clip:
    """Frames in time order, RGB, and what is known about how they were taken.

    Args:
        frames: uint8, shape (t, rows, columns, 3), t >= 1; not copied, read-only through the clip.
            Those of 224 x 224 stand for a 4:3 picture that was squashed to a square; give a square
            camera's in another size.
        fps: Frames per second of that recording, the rate `frame_numbers` count in, however many of
            its frames are here; None when unknown. One that no camera has counts as unknown, and a
            note says so.
        background: The idle gel, uint8, shape (rows, columns, 3); None when unknown.
        name: What errors and answers call the clip: a path or an identifier.
        frame_numbers: Where the frames stood in the recording they were taken from, from 0.
        notes: What a reader guessed or warns about, one sentence each.
        times_s: When each frame of that recording was taken, by its number, seconds from the first
            one on; () where they are as even as `fps` tells, or nothing tells it.
        recorded_frames: How many frames that recording has, however many of them are here; 0 where
            they are as many as their numbers tell.

    Raises:
        UnreadableClip: If the frames or the background are not of this form.
        TypeError: If frames or background are no arrays, or the frame rate is no number.
        ValueError: If there are not as many frame numbers as frames.
    """

    frames: Frames
    fps: float | None = None
    background: Frames | None = None
    name: str = "clip"
    frame_numbers: tuple[int, ...] = ()
    notes: tuple[str, ...] = field(default=())
    times_s: tuple[float, ...] = ()
    recorded_frames: int = 0

    def __post_init__(self) -> None:
        frames = self.frames
        _require_arrays(frames, self.background)
        if frames.dtype != np.uint8 or frames.ndim != 4 or frames.shape[-1] != 3:
            raise UnreadableClip(
                f"{self.name}: found {frames.dtype} frames of shape {frames.shape}, expected uint8 "
                f"(frames, rows, columns, 3); convert the array first."
            )
        if 0 in frames.shape:
            raise UnreadableClip(
                f"{self.name}: holds no pixels (shape {frames.shape}); record it again."
            )
        if min(frames.shape[1:3]) < MIN_SIDE:
            raise UnreadableClip(
                f"{self.name}: frames are {frames.shape[2]}x{frames.shape[1]} pixels, expected at "
                f"least {MIN_SIDE} per side; export the recording at its full size."
            )
        if self.background is not None and self.background.shape != frames.shape[1:]:
            raise UnreadableClip(
                f"{self.name}: the background has shape {self.background.shape}, the frames "
                f"{frames.shape[1:]}; give an idle frame of the same size."
            )
        if self.background is not None and self.background.dtype != np.uint8:
            raise UnreadableClip(
                f"{self.name}: the background is {self.background.dtype}, expected uint8 as the "
                f"frames are; convert the array first."
            )
        self._leave_out_senseless_rate()
        if not self.frame_numbers:
            object.__setattr__(self, "frame_numbers", tuple(range(len(frames))))
        if len(self.frame_numbers) != len(frames):
            raise ValueError(f"{len(frames)} frames have {len(self.frame_numbers)} numbers")
        counted = max(self.recorded_frames, max(self.frame_numbers) + 1)
        object.__setattr__(self, "recorded_frames", counted)
        # Only the clip's own view is locked: the caller's array may be a buffer that is used again.
        own = frames.view()
        own.setflags(write=False)
        object.__setattr__(self, "frames", own)

    def _leave_out_senseless_rate(self) -> None:
        require_number(self.fps)
        if self.fps is None or 0 < self.fps < MOST_FPS:
            return
        note = (
            f"The frame rate {self.fps:g} is not used, expected more than 0 and less than "
            f"{MOST_FPS:g} per second."
        )
        object.__setattr__(self, "fps", None)
        object.__setattr__(self, "notes", (*self.notes, note))

    def __len__(self) -> int:
        return len(self.frames)

    @property
    def recorded_s(self) -> float | None:
        """How long that recording is, its last frame included; None where nothing tells it."""
        if self.fps is None:
            return None
        return self.second_of(self.recorded_frames, self.fps)

    @property
    def is_timed(self) -> bool:
        """Whether it is known when its frames were taken."""
        return self.fps is not None or bool(self.times_s)

    def second_of(self, number: int, assumed_fps: float) -> float:
        """Return when a frame was taken, s from the first; by `assumed_fps` where it is unknown."""
        step_s = 1 / (self.fps or assumed_fps)
        if not self.times_s:
            return number * step_s
        last = len(self.times_s) - 1
        return self.times_s[min(number, last)] + max(number - last, 0) * step_s

    def select(self, indices: list[int] | tuple[int, ...]) -> Clip:
        """Return the clip of the frames at `indices`, keeping where they stood."""
        return replace(
            self,
            frames=self.frames[list(indices)],
            frame_numbers=tuple(self.frame_numbers[index] for index in indices),
        )

    def reversed(self) -> Clip:
        """Return the clip played backwards."""
        return self.select(range(len(self) - 1, -1, -1))

    def with_note(self, note: str) -> Clip:
        """Return the clip with one more note."""
        return replace(self, notes=(*self.notes, note))


def require_number(fps: object) -> None:
    """Refuse a frame rate that is no number; None is none."""
    is_scalar = isinstance(fps, np.ndarray) and fps.ndim == 0  # as an archive holds it
    if fps is not None and not is_scalar and not isinstance(fps, Real):
        raise TypeError(
            f"fps is a number, found {type(fps).__name__}; give frames per second such as 25.0, or "
            f"leave it out"
        )


def _require_arrays(frames: object, background: object) -> None:
    if not isinstance(frames, np.ndarray):
        raise TypeError(
            f"Clip takes one numpy array of frames, found {type(frames).__name__}; stack them by "
            f"np.stack(frames), or read a file by read_clip(path)"
        )
    if not isinstance(background, np.ndarray | None):
        raise TypeError(
            f"the background of a Clip is a numpy array, found {type(background).__name__}; give "
            f"an idle frame of the same size, or leave it out"
        )


MOST_FPS = 1e5
"""Frames per second a clip may have; more is taken for a mistake."""

MIN_SIDE = 8
"""Smallest side in pixels a clip may have; below it no imprint can be resolved."""
