"""Any recording on disk to a clip or to its frames one by one: the room's front door.

The recordings of a folder are listed here as well, and what reading one will take.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass, field, replace
from itertools import islice
from numbers import Integral
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from geotlm_lm.core.clip import MOST_FPS, Clip, Frames, require_number
from geotlm_lm.core.errors import UnreadableClip, UsageError, nearest, require_inside
from geotlm_lm.core.image_size import declared_size, page_sizes
from geotlm_lm.recordings.arrays import (
    ARRAY_SUFFIXES,
    declared_count,
    declared_frames,
    map_array,
    read_archive,
    read_array,
    stated_square_pixels,
)
from geotlm_lm.recordings.bags import BAG_SUFFIXES, BagSource, is_bag
from geotlm_lm.recordings.images import (
    IMAGE_SUFFIXES,
    STACK_SUFFIXES,
    folder_images,
    is_stack,
    listed,
    read_folder,
    read_stack,
    read_still_image,
)
from geotlm_lm.recordings.legible import without_damaged
from geotlm_lm.recordings.pixels import (
    Order,
    check_layout,
    parts_of,
    still_to_rgb,
    with_pixel_shape,
    with_square_pixels,
)
from geotlm_lm.recordings.policy import DECODED_FRAMES, KEPT_BYTES, Source, read_source
from geotlm_lm.recordings.video import GIF, VIDEO_SUFFIXES, VideoSource, quiet_capture

CLIP_SUFFIXES = (*ARRAY_SUFFIXES, *VIDEO_SUFFIXES, *STACK_SUFFIXES, *BAG_SUFFIXES)
"""Endings of files that are a recording each; a TIFF of one page is a frame."""

EXPECTED = f"{', '.join(CLIP_SUFFIXES)} or folders of images"
"""What a recording is, for sentences."""

PACKED_RATIO = 64
"""Times a bag or a GIF unpacks to at most, as is assumed: neither declares what its frames take."""

HEADER_BYTES = 2**20
"""Of an image, in which its size is looked for."""


def read_clip(
    path: str | Path,
    *,
    layout: str | None = None,
    fps: float | None = None,
    background: str | Path | None = None,
    square_pixels: bool | None = None,
    topic: str | None = None,
) -> Clip:
    """Return the recording at `path`, of any length from 2 frames.

    Args:
        path: A .npy or .npz array, a .mp4, .m4v, .avi, .mov, .mkv, .webm or .gif video, a .tif of
            several pages, a .mcap or .db3 bag of ROS 2 or its folder, a .bag of ROS 1, or a folder
            of images.
        layout: Axes of an array: "THWC", "TCHW" or "THW" (grey); "BGR", or "THWC-BGR", where its
            colours are in OpenCV's order, those of a background in an array as well; None to guess
            axes and take colours for RGB. Of anything else it is not used, and a note says so.
        fps: Frames per second of the whole recording, evenly; None to take what the file says.
        background: An image or .npy file of the idle gel; None to take what the file holds.
        square_pixels: Whether the camera's pixels are square though the frames are of 224 x 224;
            None to take what a .npz states by `square_pixels`, and where none does, with a note, a
            4:3 picture squashed to a square.
        topic: Of a bag's images; None where it has images on one topic only.

    Raises:
        UnreadableClip: If a file is missing, damaged, or holds no clip, in one sentence.
        MissingDependency: If it is a bag and the extra `ros` is not installed, or AV1 video and the
            extra `lerobot` is not.
        UsageError: If the layout or the frame rate makes no sense.
        TypeError: If an argument is of another type, such as an array for `path`.
    """
    if not isinstance(path, str | PathLike):
        raise TypeError(
            f"read_clip takes a path, found {type(path).__name__}; make a clip of an array by "
            f"Clip(frames)"
        )
    if background is not None and not isinstance(background, str | PathLike):
        raise TypeError(
            f"the background is a path, found {type(background).__name__}; give an image in memory "
            f"by dataclasses.replace(clip, background=image)"
        )
    path = _path_of(path, "a recording's")
    checked = check_layout(layout)
    require_rate(fps)
    clip = _read(path, checked, topic)
    if path.suffix.lower() not in ARRAY_SUFFIXES:
        clip = without_damaged(clip)
        if checked is not None:
            note = f"The layout {checked} is not used: only arrays have one to tell."
            clip = clip.with_note(note)
    if topic is not None and not is_bag(path):
        clip = clip.with_note(f"The topic {topic} is not used: only bags have topics.")
    require_motion(clip)
    if fps is not None:
        clip = replace(clip, fps=fps, times_s=())
    if background is not None:
        clip = replace(clip, background=read_background(background, parts_of(checked)[1]))
    if square_pixels is None and path.suffix.lower() == ".npz":
        square_pixels = stated_square_pixels(path)
    return with_pixel_shape(clip, is_square=square_pixels)


def require_rate(fps: float | None) -> None:
    """Refuse a frame rate that no camera has; None is none."""
    require_number(fps)
    if fps is not None and not 0 < fps < MOST_FPS:
        raise UsageError(
            f"A frame rate of {fps:g} was given, expected more than 0 and less than "
            f"{MOST_FPS:g} per second; give the camera's, or leave it out."
        )


def read_background(path: str | Path, order: Order = "RGB") -> Frames:
    """Return the idle gel in an image or .npy file, uint8, shape (rows, columns, 3).

    The order is that of the colours in an array; those of an image are known.
    """
    path = _path_of(path, "an image's")
    require_file(path, "an image")
    if path.suffix.lower() == ".npy":
        return still_to_rgb(map_array(path), order, str(path))
    if path.suffix.lower() in IMAGE_SUFFIXES:
        return read_still_image(path)
    raise UnreadableClip(
        f"{path}: a background is read from .npy, {', '.join(IMAGE_SUFFIXES)}; save one idle frame "
        f"as one of these."
    )


def _path_of(path: str | PathLike[str], wanted: str) -> Path:
    if not fspath(path):  # which stands for the current folder, as nobody means it
        raise UnreadableClip(f"An empty path was given, expected {wanted}; give it.")
    return Path(path)


def _read(path: Path, layout: str | None, topic: str | None) -> Clip:
    if require_there(path).is_dir():
        return read_source(BagSource(path, topic)) if is_bag(path) else read_folder(path)
    require_file(path)
    suffix = path.suffix.lower()
    if suffix == ".npy":
        return read_array(path, layout)
    if suffix == ".npz":
        return read_archive(path, layout)
    if is_streamed(path):
        return read_source(streamed_source(path, topic))
    if suffix in STACK_SUFFIXES:
        return read_stack(path)
    if suffix in IMAGE_SUFFIXES:
        raise UnreadableClip(
            f"{path}: only 1 frame was found, motion needs 2 or more; give the folder it lies in."
        )
    ending = f"named '{suffix}'" if suffix else "without an ending"
    raise UnreadableClip(
        f"{path}: files {ending} are not known, expected {', '.join(CLIP_SUFFIXES)} or a folder of "
        f"images; export the recording as one of these."
    )


def require_there(path: Path) -> Path:
    """Return a path that leads somewhere; refuse any other."""
    try:
        is_there = path.exists()
    except OSError as error:  # no right to look into a folder above it, or too long a name
        raise _unopened(path, error) from error
    if not is_there:
        raise UnreadableClip(f"{path}: no such file or folder; {_advice(path)}")
    return path


def _advice(path: Path) -> str:
    """Return what to do where a path leads nowhere; the nearest name beside it, if one is alike."""
    try:
        near = nearest(path.name, (beside.name for beside in islice(path.parent.iterdir(), 5000)))
    except OSError:
        near = None
    return "check the path." if near is None else f"did you mean '{path.with_name(near)}'?"


def require_file(path: Path, wanted: str = "a recording") -> None:
    """Refuse what is missing, empty, no regular file, or cannot be opened."""
    if not require_there(path).is_file():
        raise UnreadableClip(f"{path}: is not a regular file; give {wanted}.")
    if path.stat().st_size == 0:
        raise UnreadableClip(f"{path}: is empty (0 bytes); copy or record it again.")
    try:
        path.open("rb").close()
    except OSError as error:
        raise _unopened(path, error) from error


def _unopened(path: Path, error: OSError) -> UnreadableClip:
    return UnreadableClip(
        f"{path}: cannot be opened ({error.strerror}); check the path and its permissions."
    )


def is_streamed(path: str | Path) -> bool:
    """Tell whether a recording is decoded frame by frame as it is played, and never held whole."""
    return Path(path).suffix.lower() in VIDEO_SUFFIXES or is_bag(Path(path))


def streamed_source(path: Path, topic: str | None = None) -> Source:
    """Return the frames of a video or a bag."""
    return BagSource(path, topic) if is_bag(path) else VideoSource(path)


def each_frame(
    clip: Clip, *, square_pixels: bool = False, topic: str | None = None
) -> Iterator[tuple[int, Frames]]:
    """Yield the number of every frame of a recording, and the frame, uint8 RGB.

    A video or a bag of which only a part fits into memory is decoded anew, frame by frame, with the
    options that the clip was read with.
    """
    numbers, path = clip.frame_numbers, Path(clip.name)
    is_whole = len(numbers) < 2 or np.diff(numbers).min() == 1
    if is_whole or not is_streamed(path):
        yield from zip(numbers, clip.frames, strict=True)
        return
    with closing(streamed_source(path, topic).frames(1)) as frames:
        for number, frame in enumerate(frames):
            image = frame.decode()
            if image is None:
                return
            yield number, with_square_pixels(image) if square_pixels else image


def require_motion(clip: Clip) -> Clip:
    """Refuse a clip of only one frame, in which nothing can move."""
    if len(clip) < 2:
        raise UnreadableClip(
            f"{clip.name}: only 1 frame was found, motion needs 2 or more; give a recording, or "
            f"several frames of it."
        )
    return clip


def frames_inside(clip: Clip, span: tuple[int, int]) -> Clip:
    """Return the frames from a first to a last, both included, two or more.

    They are given by their `frame_numbers`: counted from 0 in the recording, also where it was read
    at a stride.

    Raises:
        UsageError: If the span is not inside the clip, runs backwards, or holds one frame only.
        TypeError: If the span is not two whole numbers.
    """
    ends = tuple(span) if isinstance(span, Iterable) else ()
    if len(ends) != 2 or not all(isinstance(number, Integral) for number in ends):
        raise TypeError(
            f"a span is two frame numbers, found {str(span)[:40]}; give the first and the last to "
            f"use, such as (40, 60)"
        )
    first, last = ends
    numbers = np.asarray(clip.frame_numbers)
    require_inside(first, last, int(numbers.min()), int(numbers.max()))
    inside = np.flatnonzero((numbers >= first) & (numbers <= last))
    if len(inside) < 2:
        raise UsageError(
            f"Frames {first}:{last} hold {len(inside)} of the frames that were read, expected 2 or "
            f"more; give a longer span, or cut the recording so that all of it is read."
        )
    return clip.select([int(index) for index in inside])


def clips_in(folder: Path) -> list[Path]:
    """Return every recording of a folder, by name: known files, bags, folders of images.

    A TIFF counts as one where it has several pages. A folder without any is refused.
    """
    seen = _seen_in(folder)
    recordings = [path for path in seen if _is_recording(path)]
    images = [path for path in seen if path.suffix.lower() in IMAGE_SUFFIXES]
    if images and not recordings:
        raise UnreadableClip(
            f"{folder}: holds images, which are frames of one recording, expected a folder of "
            f"recordings: {EXPECTED}; give the folder that this one lies in."
        )
    if not recordings:
        raise UnreadableClip(
            f"{folder}: holds no recording, expected {EXPECTED}; give the folder they lie in."
        )
    return recordings


def skipped_in(folder: Path) -> list[Path]:
    """Return what `clips_in` leaves out, by name; hidden files are passed over."""
    return [path for path in _seen_in(folder) if not _is_recording(path)]


def _seen_in(folder: Path) -> list[Path]:
    if not os.path.isdir(folder):  # unlike the path's own, it raises nothing
        kind = "is a file, expected a folder" if os.path.exists(folder) else "no such folder"
        raise UnreadableClip(f"{folder}: {kind}; give the one your recordings lie in.")
    return sorted(path for path in listed(folder) if not path.name.startswith("."))


def _is_recording(path: Path) -> bool:
    if not path.is_dir():
        suffix = path.suffix.lower()
        return is_stack(path) if suffix in STACK_SUFFIXES else suffix in CLIP_SUFFIXES
    if is_bag(path):
        return True
    try:
        return any(Path(name).suffix.lower() in IMAGE_SUFFIXES for name in os.listdir(path))
    except OSError:
        return True  # reading it will say why it cannot be opened


def declared_length(path: Path) -> tuple[int | None, float | None]:
    """Return how many frames a recording declares and their rate, None of what it does not tell.

    Nothing is decoded, so a file that is cut off has fewer.
    """
    suffix = path.suffix.lower()
    try:
        if path.is_dir() and not is_bag(path):
            return len(folder_images(path).frames) or None, None
        if suffix in ARRAY_SUFFIXES:
            return declared_count(path)
        if suffix not in VIDEO_SUFFIXES:
            return None, None
        with quiet_capture(path, cv2.CAP_FFMPEG) as capture:
            frames, fps = (capture.get(of) for of in (cv2.CAP_PROP_FRAME_COUNT, cv2.CAP_PROP_FPS))
        is_rated = 0 < frames < 10**9 and 0 < fps < MOST_FPS
        return (round(frames), round(fps, 3)) if is_rated else (None, None)
    except (UnreadableClip, OSError):
        return None, None


def declared_bytes(path: Path) -> int:
    """Return the bytes of frames that reading a recording will hold; nothing is decoded.

    No more than are ever kept; 0 of what cannot be read, as reading it will say.
    """
    try:
        return min(_declared(path), KEPT_BYTES)
    except (UnreadableClip, OSError):
        return 0


def _declared(path: Path) -> int:
    suffix = path.suffix.lower()
    if is_bag(path):
        files = path.iterdir() if path.is_dir() else (path,)
        return PACKED_RATIO * sum(file.stat().st_size for file in files)
    if path.is_dir():
        images = folder_images(path).frames
        if not images:
            return 0
        with images[0].open("rb") as file:
            size = declared_size(file.read(HEADER_BYTES)) or (0, 0)
        return len(images) * 3 * math.prod(size)
    if suffix in ARRAY_SUFFIXES:
        return declared_frames(path)
    if suffix == GIF:
        return PACKED_RATIO * path.stat().st_size
    if suffix in VIDEO_SUFFIXES:
        with quiet_capture(path, cv2.CAP_FFMPEG) as capture:
            sides = (cv2.CAP_PROP_FRAME_HEIGHT, cv2.CAP_PROP_FRAME_WIDTH)
            rows, columns = (int(capture.get(side)) for side in sides)
            count = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
        # A container that does not say how many frames it holds may hold as many as fit.
        return 3 * rows * columns * count if count > 0 else KEPT_BYTES * (rows > 0)
    if suffix in STACK_SUFFIXES:
        with path.open("rb") as file:
            return sum(3 * math.prod(size or ()) for size in page_sizes(file, DECODED_FRAMES))
    return 0


@dataclass(frozen=True)
class StoredRecording:
    """A recording on disk, and the options of `read_clip` to read it with."""

    path: Path
    reading: Mapping[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Of the file or folder."""
        return self.path.name

    def read(self) -> Clip:
        """Return its frames; as of `read_clip`."""
        return read_clip(self.path, **self.reading)

    @property
    def seen_at(self) -> Path:
        """What a machine that reads it must have: the folder, as the file may be gone by now."""
        return self.path.parent

    def stamp(self) -> list[Any]:
        """Return what changes when the file does or is read otherwise, plain JSON values."""
        return [self.name, stamp_of(self.path), dict(self.reading)]


def stamp_of(path: Path) -> list[int]:
    """Return a file's size and time of change; nothing of a link that leads nowhere."""
    try:
        about = path.stat()
    except OSError:
        return []
    return [about.st_size, about.st_mtime_ns]
