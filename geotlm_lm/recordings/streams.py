"""Streams of frames: a camera, or a recording played; late frames are dropped and counted.

Frames of a source that does not wait go through a bounded buffer: when the reader falls behind, the
oldest are dropped.
"""

from __future__ import annotations

import math
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from queue import Empty, SimpleQueue

import cv2
import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import MissingDependency, Stalled, UnreadableClip
from geotlm_lm.recordings.legible import DARK_GREY
from geotlm_lm.recordings.pixels import check_layout
from geotlm_lm.recordings.policy import rate_ahead, require_same_size
from geotlm_lm.recordings.read import (
    is_streamed,
    read_clip,
    require_file,
    require_rate,
    require_there,
    streamed_source,
)
from geotlm_lm.recordings.video import VIDEO_SUFFIXES, declared_end, quiet_capture

DEFAULT_FPS = 25.0
"""Taken where a source does not say: a GelSight Mini's rate."""

BUFFERED_FRAMES = 25
"""Frames that may wait: a second of a GelSight Mini; after that an answer is no longer live."""

THREAD_END_S = 1.0
"""Seconds the thread that brings the frames is waited for: one that is inside a decoder when Python
ends aborts the process, and no frame takes as long."""

SILENT_S = 2.0
"""Seconds without a frame after which a live source is reported silent, and again after twice as
many each time."""

STALLED_S = 10.0
"""Seconds without a frame after which a reader waits for no more."""

STUCK_EVERY_PX = 8
"""Of so many rows and columns one is looked at: noise leaves not all of them as they are."""


@dataclass(frozen=True, eq=False)
class StreamFrame:
    """One frame of a stream, uint8 RGB, seconds into the stream, counted from 0."""

    image: Frames
    time_s: float
    number: int


@dataclass(frozen=True)
class Patience:
    """How long a source may be silent before its reader is refused; a recording may pause."""

    stalled_s: float = math.inf
    # Called with the seconds without a frame so far, at rising intervals.
    tell: Callable[[float], None] | None = None


def rising_s() -> Iterator[float]:
    """Return the seconds after which to report what goes on, and again."""
    return (SILENT_S * 2**number for number in count())


class LatestFrames:
    """A buffer between a source that does not wait and a reader that may be slow.

    Beyond its capacity the oldest frame is dropped.
    """

    def __init__(
        self,
        capacity: int = BUFFERED_FRAMES,
        patience: Patience | None = None,
        name: str = "The source",
    ) -> None:
        self._name, self._capacity = name, capacity
        self._waiting: SimpleQueue[StreamFrame | Exception | None] = SimpleQueue()
        self._patience = patience or Patience()
        self.dropped = 0

    def put(self, frame: StreamFrame) -> None:
        """Add a frame; never waits."""
        self._waiting.put(frame)
        if self._waiting.qsize() > self._capacity:
            with suppress(Empty):  # read meanwhile
                self._waiting.get_nowait()
                self.dropped += 1

    def close(self, error: Exception | None = None) -> None:
        """End the stream; what waits is still read, then `error` is raised to the reader."""
        self._waiting.put(error)

    def __iter__(self) -> Iterator[StreamFrame]:
        """Yield frames in order, waiting for each, until the stream is closed."""
        while isinstance(frame := self._next(), StreamFrame):
            yield frame
        if frame is not None:
            raise frame

    def _next(self) -> StreamFrame | Exception | None:
        began, stalled_s = time.monotonic(), self._patience.stalled_s
        moments_s = rising_s() if self._patience.tell else iter(())
        due_s = next(moments_s, math.inf)
        while True:
            silent_s = time.monotonic() - began
            next_s = min(due_s, stalled_s) - silent_s
            with suppress(Empty):  # half a second at most: a signal must be heard
                return self._waiting.get(timeout=min(max(next_s, 0.0), 0.5))
            if next_s > 0:
                continue
            if due_s > min(silent_s, stalled_s):
                raise Stalled(
                    f"{self._name} has given no frame for {stalled_s:g} s; check its cable, close "
                    f"other programs that use it, and start again, or wait longer by "
                    f"--stalled-after."
                )
            self._patience.tell(due_s)
            due_s = next(moments_s)


class Unwaiting(ABC):
    """A source that does not wait for its reader: a thread brings the frames into a buffer."""

    is_live = False
    """Whether its frames are taken now, so that one that does not come is missing."""

    def __init__(self, name: str, buffer: LatestFrames | None = None) -> None:
        self.name, self._buffer, self._is_read = name, buffer or LatestFrames(), True

    @property
    def dropped(self) -> int:
        """Frames the reader was too slow for."""
        return self._buffer.dropped

    def __iter__(self) -> Iterator[StreamFrame]:
        """Yield the newest frames until the reader stops or they end."""
        bringer = threading.Thread(target=self._bring_all, daemon=True)
        bringer.start()
        try:
            yield from self._buffer
        finally:
            self._is_read = False
            bringer.join(THREAD_END_S)

    def _bring_all(self) -> None:
        try:
            self._bring()
        except Exception as error:  # of any kind: the reader must not wait for ever
            self._buffer.close(error)
        else:
            self._buffer.close()

    @abstractmethod
    def _bring(self) -> None:
        """Put frames into the buffer until they end or nobody reads."""


class Recording:
    """A file played frame by frame, with the options of `open_source`; nothing is dropped.

    `fps` is the rate of the frames it gives: less than the recording's own where a long array is
    read at a stride.
    """

    is_live, dropped = False, 0

    def __init__(
        self,
        path: Path,
        fps: float | None = None,
        layout: str | None = None,
        square_pixels: bool | None = None,
        topic: str | None = None,
    ) -> None:
        self.name, self._path, self._topic = str(path), path, topic
        self._is_rate_given, self._clip, step = fps is not None, None, 1
        self._is_square = square_pixels
        require_there(path)
        if is_streamed(path):
            is_video = path.suffix.lower() in VIDEO_SUFFIXES
            if is_video:
                require_file(path)  # a pipe of that name would be waited for without end
            source = streamed_source(path, topic)
            recorded_fps, notes = rate_ahead(source)
            end = declared_end(path) if is_video else None
            missing = None if end is None else end.note()
            self.notes = (*source.notes, *(notes if fps is None else ()))
            self.notes += () if missing is None else (missing,)
        else:
            self._clip = read_clip(path, layout=layout, square_pixels=square_pixels)
            self.notes, recorded_fps = self._clip.notes, self._clip.fps
            # The usual step, as frames may be missing between two.
            step = int(np.diff(self._clip.frame_numbers).min())
        self._recorded_fps, self.is_rate_assumed = _rate(fps, recorded_fps or 0.0)
        self.fps = self._recorded_fps / step

    def whole(self) -> Clip | None:
        """Return all of the recording, for its idle gel; None where it cannot be read at once."""
        if self._clip is not None:
            return self._clip
        try:
            return read_clip(self._path, square_pixels=self._is_square, topic=self._topic)
        except UnreadableClip:  # as of one that is still being written
            return None

    def __iter__(self) -> Iterator[StreamFrame]:
        """Yield every frame; a video or a bag is decoded as it is read, however long it is.

        Its frames have their own times, unless a frame rate was given: they need not be even.
        """
        if self._clip is not None:
            for number, image in zip(self._clip.frame_numbers, self._clip.frames, strict=True):
                yield StreamFrame(image, number / self._recorded_fps, number)
            return
        source, step_s = streamed_source(self._path, self._topic), 1 / self._recorded_fps
        time_s, first_ms, first_image = -step_s, 0.0, None
        with closing(source.frames(1)) as frames:
            for number, frame in enumerate(frames):
                image = frame.decode()
                if image is None:
                    return
                first_image = image if first_image is None else first_image
                require_same_size(source, number, image, first_image)
                if self._is_rate_given:
                    time_s = number / self._recorded_fps
                elif frame.received_ms is not None:
                    # Stamps that do not rise are left to what follows the stream.
                    is_stamped = frame.stamp_ms is not None
                    time_s = (frame.stamp_ms if is_stamped else frame.received_ms) / 1000
                else:
                    first_ms = first_ms if number else frame.stamp_ms
                    stamp_s = frame.stamp_ms / 1000 - first_ms / 1000
                    # Files that have no stamps have the same one again and again.
                    time_s = stamp_s if stamp_s > time_s else time_s + step_s
                yield StreamFrame(image, time_s, number)


class RealTimePlayback(Unwaiting):
    """A recording played at its own rate, as a camera would give it: late frames are dropped."""

    def __init__(self, recording: Recording) -> None:
        super().__init__(recording.name)
        self.fps, self._recording = recording.fps, recording
        self.is_rate_assumed, self.notes = recording.is_rate_assumed, recording.notes

    def _bring(self) -> None:
        began = time.monotonic()
        for frame in self._recording:
            if not self._is_read:
                return
            time.sleep(max(began + frame.time_s - time.monotonic(), 0.0))
            self._buffer.put(frame)


class Camera(Unwaiting):
    """A camera, read as fast as it gives frames; each has its own time, whatever the rate."""

    notes: tuple[str, ...] = ()
    is_live = True

    def __init__(
        self, device: int | str, fps: float | None = None, patience: Patience | None = None
    ) -> None:
        patience, shown_name = patience or Patience(STALLED_S), f"Camera {device}"
        super().__init__(str(device), LatestFrames(patience=patience, name=shown_name))
        self._opened, self._is_open = ExitStack(), False
        first = LatestFrames(patience=patience, name=shown_name)
        threading.Thread(target=self._open, args=(device, first), daemon=True).start()
        next(iter(first), None)
        if not self._is_open:
            self._opened.close()
            raise MissingDependency(_advice(device))
        self.fps, self.is_rate_assumed = _rate(fps, float(self._capture.get(cv2.CAP_PROP_FPS)))

    def _open(self, device: int | str, first: LatestFrames) -> None:
        """Wait for the first frame; a driver may do so for ever."""
        try:
            source = Path(device) if isinstance(device, str) else device
            self._capture = self._opened.enter_context(quiet_capture(source, cv2.CAP_ANY))
            self._is_open = self._capture.isOpened() and self._capture.grab()
        finally:
            first.close()

    def _bring(self) -> None:
        began, reason = time.monotonic(), ""
        with self._opened:
            for number in count():
                try:
                    is_there, image = self._capture.read()
                except cv2.error as error:  # as some drivers do where others give no frame
                    is_there, reason = False, f" ({error})"
                if not is_there or not self._is_read:
                    break
                image = cv2.cvtColor(image, cv2.COLOR_BGR2RGB)
                self._buffer.put(StreamFrame(image, time.monotonic() - began, number))
        raise MissingDependency(
            f"Camera {self.name} stopped giving frames after {time.monotonic() - began:.1f} s"
            f"{reason}; check its cable and start again."
        )


def open_source(
    name: str,
    *,
    at_its_rate: bool = False,
    fps: float | None = None,
    layout: str | None = None,
    square_pixels: bool | None = None,
    topic: str | None = None,
    patience: Patience | None = None,
) -> Recording | RealTimePlayback | Camera:
    """Return the stream called `name`: a camera's number, a device file, or a recording.

    Args:
        name: For example "0", "/dev/video0" or "clip.avi".
        at_its_rate: Play a recording as fast as it was taken, and drop what is too late.
        fps: Frames per second; None to take what the recording or the camera says.
        layout: Axes of an array, its order of colours; see `read_clip`. None to guess.
        square_pixels: Of an array or images; None as in `read_clip`.
        topic: Of a bag's images; None as in `read_clip`.
        patience: With a camera that gives no frames; None for the usual. A recording may pause.

    Raises:
        MissingDependency: If a camera does not open, or a bag and the extra `ros` is not there.
        Stalled: If a camera opens and gives no frame.
        UnreadableClip: If a file is missing or holds no frames.
        UsageError: If the frame rate or the layout makes no sense.
    """
    require_rate(fps)
    check_layout(layout)
    if name.isdecimal() and len(name) < 4:
        return Camera(int(name), fps, patience)
    if name.startswith("/dev/"):
        return Camera(name, fps, patience)
    recording = Recording(Path(name), fps, layout, square_pixels, topic)
    return RealTimePlayback(recording) if at_its_rate else recording


def _rate(fps: float | None, source_fps: float) -> tuple[float, bool]:
    """Return frames per second, and whether neither the user nor the source says so."""
    if fps is not None:
        return fps, False
    return (source_fps, False) if 0 < source_fps < 1e4 else (DEFAULT_FPS, True)


def _advice(device: int | str) -> str:
    cameras = sorted(str(path) for path in Path("/dev").glob("video*"))
    listed = f"cameras found: {', '.join(cameras)}" if cameras else "no /dev/video* was found"
    return (
        f"Camera {device} does not open ({listed}); plug the sensor in, close other programs that "
        f"use it, see that your user is in the group 'video', or give a recording's path."
    )


class StuckPicture:
    """Notices that frames are all the same, or black, for some time; `note` says so until then."""

    def __init__(self) -> None:
        self._before: Frames | None = None
        self.note = ""
        self._kind, self._since_s, self._moments_s = "", 0.0, rising_s()
        self._due_s = next(self._moments_s)

    def after(self, image: Frames, time_s: float) -> str:
        """Take in the next frame, and return a sentence, at rising times, or ""."""
        seen = image[::STUCK_EVERY_PX, ::STUCK_EVERY_PX].copy()
        is_same = self._before is not None and np.array_equal(seen, self._before)
        kind = "black" if seen.max() <= DARK_GREY else "all the same" if is_same else ""
        self._before = seen
        if kind != self._kind or not kind:
            self.note, self._kind = "", kind
            self._since_s, self._moments_s = time_s, rising_s()
            self._due_s = next(self._moments_s)
        if not kind or time_s - self._since_s < self._due_s:
            return ""
        stuck_s, self._due_s = self._due_s, next(self._moments_s)
        self.note = (
            f"The camera's frames have been {kind} for {stuck_s:g} s; check its cable and the "
            f"sensor's lights."
        )
        return self.note
