"""Where a stream comes from: a camera, or a recording played frame by frame."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import count
from pathlib import Path

import cv2
import numpy as np

from geotlm_lm.core.errors import MissingDependency, UnreadableClip
from geotlm_lm.recordings.bags import bag_images, bag_rate, is_bag, resized
from geotlm_lm.recordings.containers import declared_end
from geotlm_lm.recordings.latest_frames import StreamFrame, Unwaiting
from geotlm_lm.recordings.pixels import check_layout
from geotlm_lm.recordings.read import read_clip, require_file, require_rate
from geotlm_lm.recordings.video import VIDEO_SUFFIXES, rate_ahead, undecoded
from geotlm_lm.recordings.video_file import quiet_capture, video_file

DEFAULT_FPS = 25.0
"""Taken where a source does not say: a GelSight Mini's rate."""


class Recording:
    """A file played frame by frame; nothing is dropped.

    `fps` is the rate of the frames it gives: less than the recording's own where a long array is
    read at a stride.

    Args:
        path: A video, an array, a bag, or a folder of images.
        fps: Frames per second of the whole recording; None to take what the file says.
        layout: Axes of an array; None to guess.
        square_pixels: Whether an array's or images' pixels are square; None as in `read_clip`.
        topic: Of a bag's images; None where it has images on one topic only.

    Raises:
        UnreadableClip: If it is missing or holds no frames, in one sentence.
        MissingDependency: If it is a bag and the extra `ros` is not installed.
    """

    def __init__(
        self,
        path: Path,
        fps: float | None = None,
        layout: str | None = None,
        square_pixels: bool | None = None,
        topic: str | None = None,
    ) -> None:
        self.name, self.dropped, self._is_rate_given = str(path), 0, fps is not None
        self._path, self._is_video = path, path.suffix.lower() in VIDEO_SUFFIXES
        self._topic, self._is_bag = topic, is_bag(path)
        if not path.exists():
            raise UnreadableClip(f"{path}: no such file or folder; check the path.")
        if self._is_video:
            require_file(path)
            with video_file(path) as capture:
                rated = rate_ahead(capture)
            if rated is None:
                raise undecoded(path)
            rate, notes = rated
            told = rate or 0.0
            self.notes = (*capture.notes, *(notes if fps is None else ()))
            end = declared_end(path)
            if end is not None and (missing := end.note()) is not None:
                self.notes = (*self.notes, missing)
        elif self._is_bag:
            rate, notes = bag_rate(path, topic)
            told, self.notes = rate or 0.0, notes if fps is None else ()
        else:
            self._clip = read_clip(path, layout=layout, square_pixels=square_pixels)
            self.notes = self._clip.notes
            told = self._clip.fps or 0.0
        self._recorded_fps, self.is_rate_assumed = _rate(fps, told)
        is_streamed = self._is_video or self._is_bag
        # The usual step, as frames may be missing between two.
        step = 1 if is_streamed else int(np.diff(self._clip.frame_numbers).min())
        self.fps = self._recorded_fps / step

    def __iter__(self) -> Iterator[StreamFrame]:
        """Yield every frame; a video or a bag is decoded as it is read, however long it is.

        Its frames have their own times, unless a frame rate was given: they need not be even.
        """
        if self._is_bag:
            yield from self._of_bag()
            return
        if not self._is_video:
            for number, image in zip(self._clip.frame_numbers, self._clip.frames, strict=True):
                yield StreamFrame(image, number / self._recorded_fps, number)
            return
        step_s = 1 / self._recorded_fps
        time_s, first_s = -step_s, 0.0
        with video_file(self._path) as capture:
            for number in count():
                is_decoded, image = capture.read()
                if not is_decoded:
                    return
                stamp_s = float(capture.get(cv2.CAP_PROP_POS_MSEC)) / 1000
                first_s = first_s if number else stamp_s
                is_later = stamp_s - first_s > time_s  # false of files that have no stamps
                is_stamped = is_later and not self._is_rate_given
                time_s = stamp_s - first_s if is_stamped else time_s + step_s
                yield StreamFrame(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), time_s, number)

    def _of_bag(self) -> Iterator[StreamFrame]:
        first = shape = None
        for number, one in enumerate(bag_images(self._path, self._topic)):
            image, first = one.decoded(), first or one
            shape = shape or image.shape
            if image.shape != shape:
                raise resized(self.name, number, image.shape, shape)
            # Stamps that are missing or do not rise are left to whoever follows the stream.
            is_stamped = first.stamp_s > 0 and one.stamp_s > 0
            taken_s = (
                one.stamp_s - first.stamp_s if is_stamped else one.received_s - first.received_s
            )
            time_s = number / self._recorded_fps if self._is_rate_given else taken_s
            yield StreamFrame(image, time_s, number)


class RealTimePlayback(Unwaiting):
    """A recording played at its own rate, as a camera would give it: late frames are dropped.

    Args:
        recording: What is played.
    """

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
    """A camera, read as fast as it gives frames; nothing about it is guessed but its rate.

    Args:
        device: Its number, or the path of its device file.
        fps: Frames per second; None to take what it says. Each frame has its own time all the same.

    Raises:
        MissingDependency: If it does not open, with what to do.
    """

    notes: tuple[str, ...] = ()

    def __init__(self, device: int | str, fps: float | None = None) -> None:
        super().__init__(str(device))
        self._opened = ExitStack()
        source = Path(device) if isinstance(device, str) else device
        self._capture = self._opened.enter_context(quiet_capture(source, cv2.CAP_ANY))
        if not (self._capture.isOpened() and self._capture.grab()):
            self._opened.close()
            raise MissingDependency(_advice(device))
        told = float(self._capture.get(cv2.CAP_PROP_FPS))
        self.fps, self.is_rate_assumed = _rate(fps, told)

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
) -> Recording | RealTimePlayback | Camera:
    """Return the stream called `name`: a camera's number, a device file, or a recording.

    Args:
        name: For example "0", "/dev/video0" or "clip.avi".
        at_its_rate: Play a recording as fast as it was taken, and drop what is too late.
        fps: Frames per second; None to take what the recording or the camera says.
        layout: Axes of an array, its order of colours; see `read_clip`. None to guess.
        square_pixels: Of an array or images; None as in `read_clip`.
        topic: Of a bag's images; None as in `read_clip`.

    Raises:
        MissingDependency: If a camera does not open, or a bag and the extra `ros` is not there.
        UnreadableClip: If a file is missing or holds no frames.
        UsageError: If the frame rate or the layout makes no sense.
    """
    require_rate(fps)
    check_layout(layout)
    if name.isdecimal() and len(name) < 4:
        return Camera(int(name), fps)
    if name.startswith("/dev/"):
        return Camera(name, fps)
    recording = Recording(Path(name), fps, layout, square_pixels, topic)
    return RealTimePlayback(recording) if at_its_rate else recording


def _rate(given: float | None, told: float) -> tuple[float, bool]:
    """Return frames per second, and whether neither the user nor the source says so."""
    if given is not None:
        return given, False
    return (told, False) if 0 < told < 1e4 else (DEFAULT_FPS, True)


def _advice(device: int | str) -> str:
    found = sorted(str(path) for path in Path("/dev").glob("video*"))
    seen = f"cameras found: {', '.join(found)}" if found else "no /dev/video* was found"
    return (
        f"Camera {device} does not open ({seen}); plug the sensor in, close other programs that "
        f"use it, see that your user is in the group 'video', or give a recording's path."
    )
