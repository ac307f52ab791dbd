"""Video files opened by what can decode them, their pictures as the file states them."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from importlib.util import find_spec
from io import SEEK_END
from pathlib import Path
from typing import IO, TYPE_CHECKING, Protocol

import cv2
import numpy as np

from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import MissingDependency
from geotlm_lm.core.files import plain_name
from geotlm_lm.recordings.decoding import quiet_decoders
from geotlm_lm.recordings.limits import kept_frames
from geotlm_lm.recordings.stated_shape import DAMAGED, StatedShape, video_shape

if TYPE_CHECKING:
    from av.container import InputContainer
    from av.video.frame import VideoFrame
    from PIL.GifImagePlugin import GifImageFile

GIF = ".gif"


class Capture(Protocol):
    """What is used of OpenCV's `VideoCapture`; pictures have blue first."""

    def grab(self) -> bool:
        """Go on to the next picture; False after the last one."""

    def retrieve(self) -> tuple[bool, Frames | None]:
        """Return whether the picture can be decoded, and the picture."""

    def get(self, prop: int, /) -> float:
        """Return one of OpenCV's CAP_PROP_ values; 0 where it is not known."""


class VideoFile:
    """A video's pictures in order, upright and of square pixels, as `Capture` gives them.

    Args:
        capture: That decodes it, and turns pictures as the file states.
        name: Of the file, for errors.
        notes: What else is to be told of the file.
    """

    def __init__(self, capture: Capture, name: str, notes: tuple[str, ...] = ()) -> None:
        self._capture, self._name = capture, name
        self._shape: StatedShape = video_shape(
            capture.get(cv2.CAP_PROP_ORIENTATION_META),
            capture.get(cv2.CAP_PROP_SAR_NUM),
            capture.get(cv2.CAP_PROP_SAR_DEN),
        )
        self.notes = (*self._shape.notes, *notes)
        self.grab, self.get = capture.grab, capture.get

    def retrieve(self) -> tuple[bool, Frames | None]:
        """Return whether the picture can be decoded, and the picture."""
        is_decoded, image = self._capture.retrieve()
        return is_decoded, self._shape.squared(image, self._name) if is_decoded else image

    def read(self) -> tuple[bool, Frames | None]:
        """Go on to the next picture and return it, as `retrieve` does."""
        return self.retrieve() if self.grab() else (False, None)


@contextmanager
def video_file(path: Path) -> Iterator[VideoFile]:
    """Open a video file; one that cannot be decoded has no pictures.

    Raises:
        MissingDependency: If it is AV1 video, and the extra that decodes it is not installed.
    """
    with ExitStack() as opened:
        if path.suffix.lower() == GIF:
            file = opened.enter_context(path.open("rb"))
            yield VideoFile(_Gif(file, str(path)), str(path), _gif_notes(file))
            return
        capture: Capture = opened.enter_context(quiet_capture(path, cv2.CAP_FFMPEG))
        if _is_undecoded_av1(capture, path):
            capture = opened.enter_context(_av_capture(path)) or capture
        yield VideoFile(capture, str(path))


@contextmanager
def quiet_capture(source: Path | int, backend: int) -> Iterator[cv2.VideoCapture]:
    """Open a video or a camera while OpenCV's decoders keep silent, and release it afterwards.

    Args:
        source: Path of a file or device, or a camera's number.
        backend: One of OpenCV's CAP_ constants.
    """
    # Decoders write to stderr on their own; what they say is told in one sentence here instead.
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    with ExitStack() as opened:
        opened.enter_context(quiet_decoders())
        opens = opened.enter_context(plain_name(source)) if isinstance(source, Path) else source
        capture = cv2.VideoCapture(opens, backend)
        opened.callback(capture.release)
        yield capture


def _is_undecoded_av1(capture: cv2.VideoCapture, path: Path) -> bool:
    """Tell whether a file is AV1, which OpenCV opens and mostly was built without a decoder of."""
    code = int(capture.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little", signed=True)
    if code.lower() != b"av01":
        return False
    with quiet_capture(path, cv2.CAP_FFMPEG) as tried:
        return not tried.grab()


@contextmanager
def _av_capture(path: Path) -> Iterator[Capture | None]:
    """Open an AV1 video; None where it is too damaged for that."""
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
            capture = _AvCapture(container)
        except (av.FFmpegError, IndexError):  # IndexError: there is no picture in it
            capture = None
        yield capture


class _AvCapture:
    """A video decoded by PyAV."""

    def __init__(self, container: InputContainer) -> None:
        stream = container.streams.video[0]
        self._frames = container.decode(stream)
        self._ahead: VideoFrame | None = self._next()
        self._frame: VideoFrame | None = None
        first, aspect = self._ahead, stream.sample_aspect_ratio
        self._begin_s = (first and first.time) or 0.0
        self._properties = {
            cv2.CAP_PROP_FPS: float(stream.average_rate or 0),
            cv2.CAP_PROP_FRAME_COUNT: float(stream.frames),
            cv2.CAP_PROP_ORIENTATION_META: float(-first.rotation % 360 if first else 0),
            cv2.CAP_PROP_SAR_NUM: float(aspect.numerator if aspect else 0),
            cv2.CAP_PROP_SAR_DEN: float(aspect.denominator if aspect else 1),
        }

    def grab(self) -> bool:
        self._frame, self._ahead = self._ahead, None
        if self._frame is None:
            self._frame = self._next()
        return self._frame is not None

    def retrieve(self) -> tuple[bool, Frames | None]:
        image = self._frame.to_ndarray(format="bgr24")
        turn = _ROTATIONS.get(round(self.get(cv2.CAP_PROP_ORIENTATION_META)))
        return True, image if turn is None else cv2.rotate(image, turn)

    def get(self, prop: int, /) -> float:
        if prop == cv2.CAP_PROP_POS_MSEC:
            time_s = self._frame.time if self._frame is not None else None
            return 1000 * (time_s - self._begin_s) if time_s is not None else 0.0
        return self._properties.get(prop, 0.0)

    def _next(self) -> VideoFrame | None:
        from av import FFmpegError

        try:
            return next(self._frames, None)
        except FFmpegError:  # what follows is cut off or damaged
            return None


_ROTATIONS = {
    90: cv2.ROTATE_90_CLOCKWISE,
    180: cv2.ROTATE_180,
    270: cv2.ROTATE_90_COUNTERCLOCKWISE,
}


class _Gif:
    """An animated GIF, decoded by Pillow: OpenCV takes durations of 0 and 10 ms for 100."""

    def __init__(self, file: IO[bytes], name: str) -> None:
        from PIL.GifImagePlugin import GifImageFile
        from PIL.Image import DecompressionBombError

        self._image: GifImageFile | None = None
        self._name, self._number = name, -1
        self._time_ms, self._duration_ms = 0.0, 0.0
        with suppress(*DAMAGED, DecompressionBombError):
            self._image = GifImageFile(file)

    def grab(self) -> bool:
        from PIL.Image import DecompressionBombError

        if self._image is None:
            return False
        try:
            self._image.seek(self._number + 1)
            kept_frames(*self._image.size[::-1], self._name)  # before room is made for it
            self._image.load()
        except (*DAMAGED, DecompressionBombError):
            return False
        self._time_ms += self._duration_ms
        self._duration_ms = float(self._image.info.get("duration", 0))
        self._number += 1
        return True

    def retrieve(self) -> tuple[bool, Frames | None]:
        return True, np.asarray(self._image.convert("RGB"))[..., ::-1]

    def get(self, prop: int, /) -> float:
        return self._time_ms if prop == cv2.CAP_PROP_POS_MSEC else 0.0


def _gif_notes(file: IO[bytes]) -> tuple[str, ...]:
    """Return a note where a GIF lacks the semicolon that ends it."""
    file.seek(max(file.seek(0, SEEK_END) - _GIF_END, 0))
    is_ended = file.read().rstrip(b"\0\r\n").endswith(b";")
    return () if is_ended else (_CUT_OFF,)


_GIF_END = 64
"""Bytes at the end of a GIF in which its last one is looked for; some programs fill up with 0."""

_CUT_OFF = (
    "The end of this gif is missing: the file is cut off or damaged; copy or record it again."
)
