"""Frames from ROS 2 bags, MCAP and SQLite, without ROS; the extra `ros` reads their messages.

Streamed: of a bag of any length no more is held than the frames that fit.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import GeoTLMError, MissingDependency, UnreadableClip
from geotlm_lm.core.image_size import declared_size, is_cut_off
from geotlm_lm.recordings.decoding import AS_STORED, quiet_decoders, rgb_of_8_bits
from geotlm_lm.recordings.frame_times import rate_by, uneven_times_s
from geotlm_lm.recordings.limits import (
    DECODED_FRAMES,
    DECODING_S,
    FEWEST_KEPT,
    RATED_FRAMES,
    kept_frames,
    stride_note,
)

if TYPE_CHECKING:
    from rosbags.rosbag2 import Reader

BAG_SUFFIXES = (".mcap", ".db3")

METADATA = "metadata.yaml"
"""What makes a folder a bag."""

RAW, PACKED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"

ENCODINGS = {
    "rgb8": (3, None),
    "bgr8": (3, cv2.COLOR_BGR2RGB),
    "8UC3": (3, cv2.COLOR_BGR2RGB),
    "mono8": (1, cv2.COLOR_GRAY2RGB),
    "8UC1": (1, cv2.COLOR_GRAY2RGB),
}
"""Encoding of an image -> bytes of a pixel, and OpenCV's conversion to RGB."""

UNORDERED = (
    "The encoding 8UC3 does not tell the order of colours: blue was taken to be first, as OpenCV "
    "has it."
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

    def decoded(self) -> Frames:
        """Return it as uint8 RGB, shape (rows, columns, 3).

        Raises:
            UnreadableClip: If it is damaged, or of an encoding that is not read.
        """
        is_packed = hasattr(self.message, "format")
        return _unpacked(self) if is_packed else _unpadded(self)


def is_bag(path: Path) -> bool:
    """Tell whether a path is a bag by its name: a file of known ending, or a bag's folder."""
    # Unlike the path's own `is_file` it raises nothing where there is no right to look.
    return path.suffix.lower() in BAG_SUFFIXES or os.path.isfile(path / METADATA)


def read_bag(path: Path, topic: str | None = None) -> Clip:
    """Return the clip of the images of a topic, at a stride where not all of them fit.

    Frames are timed by their headers' stamps; where a stamp is missing or one does not rise, by
    when the bag's recorder received them.

    Args:
        path: A .mcap or .db3 file, or a bag's folder.
        topic: Name of the topic; None where the bag has images on one only.

    Raises:
        UnreadableClip: If the bag is damaged, has no such topic, several and none was given, or
            images of changing sizes or of an encoding that is not read.
        MissingDependency: If the extra `ros` is not installed.
    """
    name, kept, times_s = str(path), [], []
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
    notes = [*notes, *rate_notes, *([UNORDERED] if encoding == "8UC3" else [])]
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
    return fps, (*notes, *rate_notes)


def bag_images(path: Path, topic: str | None = None) -> Iterator[BagImage]:
    """Yield the images of a topic in the order in which they were received.

    Args:
        path: As of `read_bag`.
        topic: Likewise.

    Raises:
        UnreadableClip: As of `read_bag`.
        MissingDependency: Likewise.
    """
    reader_of, typestore = _rosbags(path)
    with _refusing_damage(path), reader_of(path) as reader:
        chosen = _topic_of(reader, path, topic)
        connections = [one for one in reader.connections if one.topic == chosen]
        for number, (connection, received_ns, raw) in enumerate(reader.messages(connections)):
            message = typestore.deserialize_cdr(raw, connection.msgtype)
            stamp = message.header.stamp
            stamp_s = stamp.sec + 1e-9 * stamp.nanosec
            yield BagImage(message, stamp_s, 1e-9 * received_ns, f"{path}: image {number}")


def _rosbags(path: Path) -> tuple[type[Reader], Any]:
    try:
        from rosbags.rosbag2 import Reader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingDependency(
            f"{path}: a bag is read with rosbags, which is not installed; run `pip install "
            f"'geotlm-lm[ros]'`."
        ) from error
    # The two types of image are the same in every release of ROS 2; older bags hold no definitions.
    return Reader, get_typestore(Stores.LATEST)


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
    depth, to_rgb = ENCODINGS[message.encoding]
    kept_frames(rows, columns, image.name)  # refused before room is made for it
    line, step, data = columns * depth, message.step, message.data
    if 0 in (rows, columns) or step < line or len(data) < step * rows:
        raise UnreadableClip(
            f"{image.name} has {len(data)} bytes in rows of {step}, expected {rows} rows of "
            f"{line}; record it again."
        )
    lines = data[: step * rows].reshape(rows, step)[:, :line]
    pixels = np.ascontiguousarray(lines.reshape(rows, columns, depth))
    return pixels if to_rgb is None else cv2.cvtColor(pixels, to_rgb)


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
    return rgb_of_8_bits([picture], image.name)[0]


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
        raise UnreadableClip(
            f"{path}: is cut off or is no bag of ROS 2, expected what `ros2 bag record` writes; "
            f"copy it again, or repair it by `mcap recover`."
        ) from error
