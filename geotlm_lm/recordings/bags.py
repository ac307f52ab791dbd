"""Frames from bags of ROS 2 and ROS 1, without ROS; the extra `ros` reads their messages.

Streamed: of a bag of any length no more is held than the frames that fit.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import GeoTLMError, MissingDependency, UnreadableClip
from geotlm_lm.core.files import is_plain, plain_name
from geotlm_lm.core.image_size import declared_size, is_cut_off
from geotlm_lm.recordings.decoding import AS_STORED, of_8_bits, quiet_decoders, rgb_of_8_bits
from geotlm_lm.recordings.encodings import ENCODINGS
from geotlm_lm.recordings.frame_times import rate_by, uneven_times_s
from geotlm_lm.recordings.limits import (
    DECODED_FRAMES,
    DECODING_S,
    FEWEST_KEPT,
    RATED_FRAMES,
    kept_frames,
    stride_note,
)
from geotlm_lm.recordings.stated_shape import StatedShape, image_shape

if TYPE_CHECKING:
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader

ROS_1 = ".bag"
"""Ending of the files that ROS 1 writes."""

BAG_SUFFIXES = (".mcap", ".db3", ROS_1)

METADATA = "metadata.yaml"
"""What makes a folder a bag."""

RAW, PACKED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"

UNORDERED = (
    "The encoding {} does not tell the order of colours: blue was taken to be first, as OpenCV has "
    "it."
)


@dataclass(frozen=True, eq=False)
class BagImage:
    """A message with an image, not decoded yet.

    Args:
        message: As the bag's reader returns it.
        stamp_s: When its header says it was taken, seconds; 0 where it does not.
        received_s: When the bag's recorder received it, seconds.
        name: Of the bag and the frame, for errors.
    """

    message: Any
    stamp_s: float
    received_s: float
    name: str

    @property
    def is_packed(self) -> bool:
        """Whether it is compressed, as JPEG or PNG."""
        return hasattr(self.message, "format")

    @property
    def stated_shape(self) -> StatedShape:
        """What a compressed one states about its pixels and how it is turned."""
        return image_shape(BytesIO(self.message.data)) if self.is_packed else StatedShape()

    def decoded(self) -> Frames:
        """Return it as uint8 RGB, shape (rows, columns, 3).

        Raises:
            UnreadableClip: If it is damaged, or of an encoding that is not read.
        """
        return _unpacked(self) if self.is_packed else _unpadded(self)


def is_bag(path: Path) -> bool:
    """Tell whether a path is a bag by its name: a file of known ending, or a bag's folder."""
    # Unlike the path's own `is_file` it raises nothing where there is no right to look.
    return _is_part(path) or os.path.isfile(path / METADATA)


def read_bag(path: Path, topic: str | None = None) -> Clip:
    """Return the clip of the images of a topic, at a stride where not all of them fit.

    Frames are timed by their headers' stamps; where a stamp is missing or one does not rise, by
    when the bag's recorder received them.

    Args:
        path: A .mcap, .db3 or .bag file, or a bag's folder.
        topic: Name of the topic; None where the bag has images on one only.

    Raises:
        UnreadableClip: If the bag is damaged, has no such topic, several and none was given, or
            images of changing sizes or of an encoding that is not read.
        MissingDependency: If the extra `ros` is not installed.
    """
    name, kept, times_s = str(path), [], []
    shape_notes: tuple[str, ...] = ()
    stride, seen, encoding, until = 1, 0, "", time.monotonic() + DECODING_S
    is_whole = True
    for seen, image in enumerate(bag_images(path, topic)):
        if seen >= DECODED_FRAMES or (seen >= FEWEST_KEPT and time.monotonic() > until):
            is_whole = False
            break
        times_s.append((image.stamp_s, image.received_s))
        if seen % stride:
            continue
        encoding = getattr(image.message, "encoding", "")
        frame = image.decoded()
        shape_notes = shape_notes if kept else image.stated_shape.notes
        if kept and frame.shape != kept[0].shape:
            raise resized(name, seen, frame.shape, kept[0].shape)
        if len(kept) >= kept_frames(*frame.shape[:2], name):
            kept, stride = kept[::2], 2 * stride
        if seen % stride == 0:
            kept.append(frame)
    if not kept:
        raise UnreadableClip(f"{name}: the topic holds no image; record it again.")
    seen = len(times_s)
    times_ms, notes = _times_ms(times_s)
    fps, rate_notes = rate_by(times_ms, 0.0)
    notes = [*shape_notes, *notes, *rate_notes, *_colour_notes(encoding)]
    if stride > 1:
        notes.append(stride_note(stride, seen))
    if not is_whole:
        notes.append(f"Only the first {seen} frames were read; cut the recording.")
    return Clip(
        np.stack(kept),
        fps=fps,
        name=name,
        frame_numbers=tuple(range(0, seen, stride)),
        recorded_frames=seen,
        notes=tuple(notes),
        times_s=uneven_times_s(times_ms, fps),
    )


def resized(
    name: str, number: int, shape: tuple[int, ...], first: tuple[int, ...]
) -> UnreadableClip:
    """Return the error of an image of another size than the first, each (rows, columns, 3)."""
    return UnreadableClip(
        f"{name}: image {number} is {shape[1]} x {shape[0]} pixels after {first[1]} x {first[0]}, "
        f"expected one size; record it at one size."
    )


def bag_rate(path: Path, topic: str | None = None) -> tuple[float | None, tuple[str, ...]]:
    """Return the frame rate by the first images' times, as `rate_by` does.

    Args:
        path: As of `read_bag`.
        topic: Likewise.

    Raises:
        UnreadableClip: As of `read_bag`.
        MissingDependency: Likewise.
    """
    first = list(islice(bag_images(path, topic), RATED_FRAMES))
    if not first:
        raise UnreadableClip(f"{path}: the topic holds no image; record it again.")
    times_ms, notes = _times_ms([(one.stamp_s, one.received_s) for one in first])
    fps, rate_notes = rate_by(times_ms, 0.0)
    return fps, (*first[0].stated_shape.notes, *notes, *rate_notes)


def bag_images(path: Path, topic: str | None = None) -> Iterator[BagImage]:
    """Yield the images of a topic in the order in which they were received.

    Args:
        path: As of `read_bag`.
        topic: Likewise.

    Raises:
        UnreadableClip: As of `read_bag`.
        MissingDependency: Likewise.
    """
    reader_of, deserialize = _rosbags(path)
    with (
        _refusing_damage(path),
        plain_name(_plain_part(path)) as plain,
        reader_of(Path(plain)) as reader,
    ):
        chosen = _topic_of(reader, path, topic)
        connections = [one for one in reader.connections if one.topic == chosen]
        for number, (connection, received_ns, raw) in enumerate(reader.messages(connections)):
            message = deserialize(raw, connection.msgtype)
            stamp = message.header.stamp
            stamp_s = stamp.sec + 1e-9 * stamp.nanosec
            yield BagImage(message, stamp_s, 1e-9 * received_ns, f"{path}: image {number}")


def _plain_part(path: Path) -> Path:
    """Return what to open: of a folder whose file has a name that a reader misses, that file."""
    parts = [part for part in path.iterdir() if _is_part(part)] if path.is_dir() else []
    misread = [part for part in parts if not is_plain(part.name)]
    if not misread:
        return path
    if len(parts) > 1:
        raise UnreadableClip(
            f"{path}: {misread[0].name} is missed by what reads bags, expected names without #, ? "
            f"and %; give its parts one by one, each as a recording."
        )
    return misread[0]


def _is_part(path: Path) -> bool:
    return path.suffix.lower() in BAG_SUFFIXES


def _rosbags(path: Path) -> tuple[type[Reader | Reader1], Callable[[bytes, str], Any]]:
    """Return what reads the messages of a bag, and what reads one of them."""
    try:
        from rosbags.rosbag1 import Reader as Reader1
        from rosbags.rosbag2 import Reader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingDependency(
            f"{path}: a bag is read with rosbags, which is not installed; run `pip install "
            f"'geotlm-lm[ros]'`."
        ) from error
    # The two types of image are the same in every release of ROS 2; older bags hold no definitions.
    if path.suffix.lower() != ROS_1:
        return Reader, get_typestore(Stores.LATEST).deserialize_cdr
    return Reader1, get_typestore(Stores.ROS1_NOETIC).deserialize_ros1


def _topic_of(reader: Reader, path: Path, topic: str | None) -> str:
    """Return the topic to read, refusing a bag that leaves it open."""
    counts: dict[str, int] = {}
    for one in reader.connections:
        if one.msgtype in (RAW, PACKED):
            counts[one.topic] = counts.get(one.topic, 0) + one.msgcount
    if not counts:
        others = ", ".join(sorted({one.topic for one in reader.connections})) or "no topic"
        raise UnreadableClip(
            f"{path}: holds no images but {others}, expected a topic of {RAW} or {PACKED}; record "
            f"the sensor's."
        )
    told = ", ".join(f"{name} ({count} images)" for name, count in sorted(counts.items()))
    if topic is None and len(counts) > 1:
        raise UnreadableClip(
            f"{path}: holds images on {len(counts)} topics, {told}, expected one; give it by "
            f"--topic."
        )
    if topic is not None and topic not in counts:
        raise UnreadableClip(
            f"{path}: holds no images on the topic {topic}, expected {told}; give one by --topic."
        )
    return topic or next(iter(counts))


def _unpadded(image: BagImage) -> Frames:
    message, rows, columns = image.message, image.message.height, image.message.width
    if message.encoding not in ENCODINGS:
        raise UnreadableClip(
            f"{image.name} has the encoding {message.encoding or '(none)'}, expected "
            f"{', '.join(ENCODINGS)}; publish the camera's images in one of these."
        )
    encoding = ENCODINGS[message.encoding]
    order = ">" if message.is_bigendian else "<"
    kind = np.dtype(np.uint8 if encoding.bits == 8 else f"{order}u2")
    kept_frames(rows, columns, image.name)  # refused before room is made for it
    line = columns * encoding.channels * kind.itemsize
    step, data = message.step, message.data
    if 0 in (rows, columns) or step < line or len(data) < step * rows:
        raise UnreadableClip(
            f"{image.name} has {len(data)} bytes in rows of {step}, expected {rows} rows of "
            f"{line}; record it again."
        )
    lines = np.ascontiguousarray(data[: step * rows].reshape(rows, step)[:, :line])
    pixels = lines.view(kind).astype(kind.newbyteorder("=")).reshape(rows, columns, -1)
    [pixels] = of_8_bits([pixels], image.name)
    if encoding.to_rgb is None:
        return pixels
    try:
        return cv2.cvtColor(pixels, encoding.to_rgb)
    except cv2.error as error:  # an odd number of columns in pairs of pixels
        raise UnreadableClip(
            f"{image.name} has {columns} x {rows} pixels, which the encoding {message.encoding} "
            f"does not divide into its groups; publish the camera's images as rgb8."
        ) from error


def _colour_notes(encoding: str) -> list[str]:
    """Return a note where an encoding names no order of its colours."""
    is_unordered = encoding.endswith(("UC3", "UC4"))
    return [UNORDERED.format(encoding)] if is_unordered else []


def _unpacked(image: BagImage) -> Frames:
    stored = image.message.data.tobytes()
    if (size := declared_size(stored)) is not None:
        kept_frames(*size, image.name)
    is_whole = bool(stored) and not is_cut_off(stored)
    with quiet_decoders():
        picture = cv2.imdecode(image.message.data, AS_STORED) if is_whole else None
    if picture is None:
        raise UnreadableClip(
            f"{image.name} ({image.message.format or 'of no format'}) is cut off or is no picture, "
            f"expected jpeg or png; record it again."
        )
    return image.stated_shape.squared(rgb_of_8_bits([picture], image.name)[0], image.name)


def _times_ms(times_s: list[tuple[float, float]]) -> tuple[NDArray[np.float64], list[str]]:
    """Return the times of images by one clock, from (stamp, received) pairs, and a note on it."""
    stamps_s, received_s = np.array(times_s).T
    if (stamps_s > 0).all() and (np.diff(stamps_s) > 0).all():
        return 1000 * (stamps_s - stamps_s[0]), []
    found = "do not rise" if (stamps_s > 0).all() else "are missing"
    note = f"Stamps of the images {found}: the times at which the bag received them were taken."
    return 1000 * (received_s - received_s[0]), [note]


@contextmanager
def _refusing_damage(path: Path) -> Iterator[None]:
    """Turn whatever the readers of bags raise on a damaged one into one sentence.

    Theirs, those of SQLite and of the packers, and what Python says of numbers out of range.
    """
    try:
        yield
    except GeoTLMError:
        raise
    except Exception as error:
        is_first = path.suffix.lower() == ROS_1
        kind, writer, repair = (
            ("ROS 1", "rosbag record", "rosbag reindex")
            if is_first
            else ("ROS 2", "ros2 bag record", "mcap recover")
        )
        raise UnreadableClip(
            f"{path}: is cut off or is no bag of {kind}, expected what `{writer}` writes; copy it "
            f"again, or repair it by `{repair}`."
        ) from error
