"""Frames from video files, decoded by what can, their pictures turned and shaped as stated."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from importlib.util import find_spec
from io import SEEK_END
from itertools import chain
from pathlib import Path
from typing import IO, TYPE_CHECKING

import cv2
import numpy as np

from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import MissingDependency, UnreadableClip
from geotlm_lm.core.files import plain_name
from geotlm_lm.recordings.containers import WHOLE_SHARE, cut_off_note, declared_end
from geotlm_lm.recordings.pixels import quiet_decoders
from geotlm_lm.recordings.policy import Source, SourceFrame, kept_frames
from geotlm_lm.recordings.stated_shape import DAMAGED, StatedShape, video_shape

if TYPE_CHECKING:
    from av.video.frame import VideoFrame

GIF = ".gif"

VIDEO_SUFFIXES = (".mp4", ".m4v", ".avi", ".mov", ".mkv", ".webm", GIF)

LOSSY_SUFFIXES = (".mp4", ".m4v", ".webm", GIF)
"""Containers that nearly always hold lossy video: mp4v costs 4.1 grey levels on a gel image, MJPG
2.1, FFV1 none; VP8 and VP9 2.3, where mp4v costs 2.4 (measured, of another clip); the 256 colours
of a GIF 2.3."""


class VideoSource(Source):
    """A video file as a source of frames; AV1 needs the extra `lerobot`."""

    declared_frames = 0.0
    """How many frames the header says there are; often a guess by the file's size."""

    def __init__(self, path: Path) -> None:
        super().__init__(str(path), self._decoded, end_notes=self._end, no_frames=self._undecoded)
        self._path, self._suffix = path, path.suffix.lower()

    def _decoded(self, stride: int) -> Iterator[SourceFrame]:
        if self._suffix == GIF:
            yield from _gif_frames(self._path, self)
            return
        with quiet_capture(self._path, cv2.CAP_FFMPEG) as capture:
            if not _is_undecoded_av1(capture, self._path):
                yield from _captured_frames(capture, self)
                return
        yield from _av_frames(self._path, self)

    def _end(self, times_ms: Sequence[float], is_whole: bool) -> list[str]:
        notes, declared_s, length_s = [], None, None
        if is_whole:
            # Of a container that declares no duration OpenCV guesses the count by its size.
            if self.header_fps > 0 and len(times_ms) < WHOLE_SHARE * self.declared_frames:
                declared_s = self.declared_frames / self.header_fps
            if len(times_ms) > 1 and times_ms[-1] > times_ms[0]:  # the last frame included
                length_s = (times_ms[-1] + float(np.median(np.diff(times_ms)))) / 1000
            note = cut_off_note(self._path, len(times_ms), length_s, declared_s)
            notes += [] if note is None else [note]
        if self._suffix in LOSSY_SUFFIXES:
            notes.append(
                f"This {self._suffix[1:]} video is lossy and blurs fine imprints; record .npy, "
                f".png or FFV1 instead."
            )
        return notes

    def _undecoded(self) -> UnreadableClip:
        end = declared_end(self._path)
        if end is not None and end.declared_bytes is not None and end.note() is not None:
            share = end.present_bytes / end.declared_bytes
            return UnreadableClip(
                f"{self._path}: only {share:.0%} of the file is there, cut off before its index; "
                f"copy or record it again."
            )
        return UnreadableClip(
            f"{self._path}: no frame of it can be decoded, expected a "
            f"{', '.join(VIDEO_SUFFIXES)} video; copy or export it again."
        )


@contextmanager
def quiet_capture(source: Path | int, backend: int) -> Iterator[cv2.VideoCapture]:
    """Open a video or a camera while OpenCV's decoders keep silent, and release it afterwards."""
    # Decoders write to stderr on their own; readers raise one sentence instead.
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    with ExitStack() as opened:
        opened.enter_context(quiet_decoders())
        opens = opened.enter_context(plain_name(source)) if isinstance(source, Path) else source
        capture = cv2.VideoCapture(opens, backend)
        opened.callback(capture.release)
        yield capture


def _captured_frames(capture: cv2.VideoCapture, source: VideoSource) -> Iterator[SourceFrame]:
    shape = video_shape(
        capture.get(cv2.CAP_PROP_ORIENTATION_META),
        capture.get(cv2.CAP_PROP_SAR_NUM),
        capture.get(cv2.CAP_PROP_SAR_DEN),
    )
    source.notes += shape.notes
    source.header_fps = float(capture.get(cv2.CAP_PROP_FPS))
    source.declared_frames = float(capture.get(cv2.CAP_PROP_FRAME_COUNT))

    def decode() -> Frames | None:
        is_decoded, image = capture.retrieve()
        return _as_shown(image, shape, source.name) if is_decoded else None

    while capture.grab():
        yield SourceFrame(decode, float(capture.get(cv2.CAP_PROP_POS_MSEC)))


def _as_shown(image: Frames, shape: StatedShape, name: str) -> Frames:
    return cv2.cvtColor(shape.squared(image, name), cv2.COLOR_BGR2RGB)


def _is_undecoded_av1(capture: cv2.VideoCapture, path: Path) -> bool:
    """Tell whether a file is AV1, which OpenCV opens and mostly was built without a decoder of."""
    code = int(capture.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little", signed=True)
    if code.lower() != b"av01":
        return False
    with quiet_capture(path, cv2.CAP_FFMPEG) as second:
        return not second.grab()


def _av_frames(path: Path, source: VideoSource) -> Iterator[SourceFrame]:
    """Yield the frames of an AV1 video; none of one too damaged to be opened."""
    if find_spec("av") is None:
        raise MissingDependency(
            f"{path}: is AV1 video, which is read with av, which is not installed; run "
            f"`pip install 'geotlm-lm[lerobot]'`."
        )
    import av

    with ExitStack() as opened:
        plain = opened.enter_context(plain_name(path))
        try:
            # Titles and tags need not be UTF-8, and are not asked for.
            container = opened.enter_context(av.open(plain, metadata_errors="replace"))
            stream = container.streams.video[0]
        except (av.FFmpegError, IndexError):  # IndexError: there is no picture in it
            return
        pictures = _until_damage(container.decode(stream))
        first = next(pictures, None)
        if first is None:
            return
        degrees, aspect = -first.rotation % 360, stream.sample_aspect_ratio
        shape = video_shape(
            degrees, aspect.numerator if aspect else 0, aspect.denominator if aspect else 1
        )
        source.notes += shape.notes
        source.header_fps = float(stream.average_rate or 0)
        source.declared_frames = float(stream.frames)

        def decode(picture: VideoFrame) -> Frames:
            image = picture.to_ndarray(format="bgr24")
            turn = _ROTATIONS.get(round(degrees))
            image = image if turn is None else cv2.rotate(image, turn)
            return _as_shown(image, shape, source.name)

        for picture in chain([first], pictures):
            is_timed = picture.time is not None
            time_ms = 1000 * (picture.time - (first.time or 0.0)) if is_timed else 0.0
            yield SourceFrame(partial(decode, picture), time_ms)


def _until_damage(pictures: Iterator[VideoFrame]) -> Iterator[VideoFrame]:
    from av import FFmpegError

    with suppress(FFmpegError):
        yield from pictures


_ROTATIONS = {
    90: cv2.ROTATE_90_CLOCKWISE,
    180: cv2.ROTATE_180,
    270: cv2.ROTATE_90_COUNTERCLOCKWISE,
}


def _gif_frames(path: Path, source: VideoSource) -> Iterator[SourceFrame]:
    """Yield the frames of a GIF by Pillow: OpenCV takes durations of 0 and 10 ms for 100."""
    from PIL.GifImagePlugin import GifImageFile
    from PIL.Image import DecompressionBombError

    with path.open("rb") as file:
        source.notes += _gif_notes(file)
        number, time_ms = 0, 0.0
        with suppress(*DAMAGED, DecompressionBombError):
            image = GifImageFile(file)
            while True:
                image.seek(number)  # EOFError behind the last one
                kept_frames(*image.size[::-1], source.name)  # before room is made for it
                image.load()
                yield SourceFrame(lambda: np.asarray(image.convert("RGB")), time_ms)
                time_ms += float(image.info.get("duration", 0))
                number += 1


def _gif_notes(file: IO[bytes]) -> tuple[str, ...]:
    """Return a note where a GIF lacks the semicolon that ends it."""
    file.seek(max(file.seek(0, SEEK_END) - _GIF_END, 0))
    is_ended = file.read().rstrip(b"\0\r\n").endswith(b";")
    file.seek(0)
    if is_ended:
        return ()
    return (
        "The end of this gif is missing: the file is cut off or damaged; copy or record it again.",
    )


_GIF_END = 64
"""Bytes at the end of a GIF in which its last one is looked for; some programs fill up with 0."""
