"""Frames from video files, decoded by what can, their pictures turned and shaped as stated."""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from io import SEEK_END
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import cv2
import numpy as np

from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import UnreadableClip, require_package
from geotlm_lm.core.files import plain_name
from geotlm_lm.recordings.images import DAMAGED, StatedShape, video_shape
from geotlm_lm.recordings.pixels import quiet_decoders
from geotlm_lm.recordings.policy import Source, SourceFrame, kept_frames

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
        note = self._missing_end(times_ms) if is_whole else None
        notes = [] if note is None else [note]
        if self._suffix in LOSSY_SUFFIXES:
            notes.append(
                f"This {self._suffix[1:]} video is lossy and blurs fine imprints; record .npy, "
                f".png or FFV1 instead."
            )
        return notes

    def _missing_end(self, times_ms: Sequence[float]) -> str | None:
        """Return a sentence where the end of a video is missing; None where all of it is there."""
        end, declared_s = declared_end(self._path), None
        if end is not None and end.duration_s is not None:
            declared_s = end.duration_s
        elif self.header_fps > 0 and len(times_ms) < WHOLE_SHARE * self.declared_frames:
            # Of a container that declares no duration OpenCV guesses the count by its size.
            declared_s = self.declared_frames / self.header_fps
        if declared_s and len(times_ms) > 1 and times_ms[-1] > times_ms[0]:
            # The last frame included.
            length_s = (times_ms[-1] + float(np.median(np.diff(times_ms)))) / 1000
            if length_s and length_s < WHOLE_SHARE * declared_s:
                return (
                    f"Only the first {length_s:.1f} s of {declared_s:.1f} s can be decoded: the "
                    f"file is cut off or damaged; copy or record it again."
                )
        return None if end is None else end.note()

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
    require_package("av", f"{path}: is AV1 video, which is read with av", "lerobot")
    import av

    with (
        suppress(av.FFmpegError),
        plain_name(path) as plain,
        # Titles and tags need not be UTF-8, and are not asked for.
        av.open(plain, metadata_errors="replace") as container,
    ):
        stream = next(iter(container.streams.video), None)
        pictures = iter(()) if stream is None else container.decode(stream)
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
        file.seek(max(file.seek(0, SEEK_END) - _GIF_END, 0))
        if not file.read().rstrip(b"\0\r\n").endswith(b";"):
            source.notes.append(
                "The end of this gif is missing: the file is cut off or damaged; copy or record "
                "it again."
            )
        file.seek(0)
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


_GIF_END = 64
"""Bytes at the end of a GIF in which its last one is looked for; some programs fill up with 0."""


# What a container declares about its own end, read without a decoder: that stops at the end of
# what is there and says nothing. Matroska and WebM: RFC 8794 and 9559. AVI: RIFF chunks, OpenDML's
# among them. MP4 and MOV: boxes of ISO/IEC 14496-12.

_EBML, _SEGMENT, _INFO, _CLUSTER = 0x1A45DFA3, 0x18538067, 0x1549A966, 0x1F43B675
_TICK_NS, _DURATION = 0x2AD7B1, 0x4489

WHOLE_SHARE = 0.95
"""Share of the declared length that a whole recording has at least."""


@dataclass(frozen=True)
class DeclaredEnd:
    """Where a container says that it ends."""

    present_bytes: int
    declared_bytes: int | None  # None as of one that is still being written
    duration_s: float | None = None

    def note(self) -> str | None:
        """Return a sentence where the end is missing or cannot be known; None of a whole file."""
        if self.declared_bytes is None:
            return (
                "The file does not declare where it ends, as one that is still being written: what "
                "comes after its last frame is not seen."
            )
        if self.present_bytes >= self.declared_bytes:
            return None
        share = self.present_bytes / self.declared_bytes
        return (
            f"Only {share:.0%} of the file is there: it is cut off or still being written, and "
            f"what comes later is not seen; copy or record it again."
        )


def declared_end(path: Path) -> DeclaredEnd | None:
    """Return what a video file declares; None where it is of no known container, or unreadable."""
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        head = file.read(12)
        reader = _reader_of(head)
        if reader is None:
            return None
        file.seek(0)
        try:
            return reader(file, size)
        except (struct.error, IndexError, OverflowError):  # it ends within a header
            return DeclaredEnd(size, size + 1)


def _reader_of(head: bytes) -> Callable[[BinaryIO, int], DeclaredEnd] | None:
    if head.startswith(_EBML.to_bytes(4, "big")):
        return _matroska
    if head.startswith(b"RIFF") and head[8:12] == b"AVI ":
        return _avi
    return _boxes if head[4:8] in (b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip") else None


def _matroska(file: BinaryIO, size: int) -> DeclaredEnd:
    for element, begin, length in _elements(file, 0, size):
        if element == _SEGMENT:
            declared = None if length is None else begin + length
            return DeclaredEnd(size, declared, _duration_s(file, begin, size))
    return DeclaredEnd(size, size + 1)


def _duration_s(file: BinaryIO, begin: int, size: int) -> float | None:
    """Return a segment's duration, which its Info holds in ticks; that comes before the frames."""
    for element, at, length in _elements(file, begin, size):
        if element == _INFO and length is not None:
            tick_ns, ticks = 10**6, None
            for field, start, count in _elements(file, at, at + length):
                file.seek(start)
                value = file.read(min(count or 0, 8))
                if field == _TICK_NS:
                    tick_ns = int.from_bytes(value, "big")
                elif field == _DURATION and len(value) in (4, 8):
                    [ticks] = struct.unpack(">f" if len(value) == 4 else ">d", value)
            return 1e-9 * tick_ns * ticks if ticks else None
        if element == _CLUSTER:
            return None
    return None


def _elements(file: BinaryIO, begin: int, end: int) -> Iterator[tuple[int, int, int | None]]:
    """Yield each element's identifier, where its content begins, and its size, None if unknown."""
    while begin < end:
        file.seek(begin)
        element, identifier_bytes = _variable(file, keeps_marker=True)
        length, length_bytes = _variable(file, keeps_marker=False)
        begin += identifier_bytes + length_bytes
        is_unknown = length == 2 ** (7 * length_bytes) - 1
        yield element, begin, None if is_unknown else length
        if is_unknown:
            return
        begin += length


def _variable(file: BinaryIO, *, keeps_marker: bool) -> tuple[int, int]:
    """Return a number of variable length and how many bytes it takes, RFC 8794 section 4."""
    first = file.read(1)[0]
    count = 9 - first.bit_length()
    if count > 8:
        raise IndexError("no length of a variable number")
    rest = file.read(count - 1)
    if len(rest) < count - 1:
        raise IndexError("the file ends within a variable number")
    top = first if keeps_marker else first & (0xFF >> count)
    return int.from_bytes(bytes([top]) + rest, "big"), count


def _avi(file: BinaryIO, size: int) -> DeclaredEnd:
    """Read the RIFF chunks, of which a file of more than 1 GiB has several."""
    begin = 0
    while begin < size:
        file.seek(begin)
        name, length = struct.unpack("<4sI", file.read(8))
        if name != b"RIFF":  # what some recorders leave behind the last one
            break
        if length in (0, 2**32 - 1):  # filled in when the file is closed
            return DeclaredEnd(size, None)
        begin += 8 + length + length % 2
    return DeclaredEnd(size, begin - (begin == size + 1))  # the last one's padding may be missing


def _boxes(file: BinaryIO, size: int) -> DeclaredEnd:
    begin = 0
    while begin < size:
        file.seek(begin)
        length, name = struct.unpack(">I4s", file.read(8))
        if length == 1:
            [length] = struct.unpack(">Q", file.read(8))
        if length == 0:  # to the end of the file
            return DeclaredEnd(size, size)
        if length < 8:  # no box: what stands behind the last one
            break
        begin += length
    return DeclaredEnd(size, begin)
