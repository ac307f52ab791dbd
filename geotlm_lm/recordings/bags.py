"""Frames from bags of ROS 2 and ROS 1, without ROS; the extra `ros` reads their messages."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import TopicNeeded, UnreadableClip, damage_as, require_package
from geotlm_lm.core.files import is_plain, plain_name
from geotlm_lm.recordings.images import StatedShape, decoded_image, image_shape
from geotlm_lm.recordings.pixels import of_8_bits
from geotlm_lm.recordings.policy import Source, SourceFrame, kept_frames

if TYPE_CHECKING:
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader

ROS_1 = ".bag"
"""Ending of the files that ROS 1 writes."""

BAG_SUFFIXES = (".mcap", ".db3", ROS_1)

METADATA = "metadata.yaml"
"""What makes a folder a bag."""

RAW, PACKED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"


# Mosaics are named by the four pixels at the upper left, as ROS does, and not by OpenCV's older
# names, which begin at the second row and column.
_FORMS = (
    ("rgb{}", 3, None),
    ("bgr{}", 3, cv2.COLOR_BGR2RGB),
    ("rgba{}", 4, cv2.COLOR_RGBA2RGB),
    ("bgra{}", 4, cv2.COLOR_BGRA2RGB),
    ("mono{}", 1, cv2.COLOR_GRAY2RGB),
    ("{}UC1", 1, cv2.COLOR_GRAY2RGB),
    ("{}UC3", 3, cv2.COLOR_BGR2RGB),
    ("{}UC4", 4, cv2.COLOR_BGRA2RGB),
    ("yuv422", 2, cv2.COLOR_YUV2RGB_UYVY),
    ("uyvy", 2, cv2.COLOR_YUV2RGB_UYVY),
    ("yuv422_yuy2", 2, cv2.COLOR_YUV2RGB_YUY2),
    ("yuyv", 2, cv2.COLOR_YUV2RGB_YUY2),
    ("bayer_rggb{}", 1, cv2.COLOR_BayerRGGB2RGB),
    ("bayer_bggr{}", 1, cv2.COLOR_BayerBGGR2RGB),
    ("bayer_gbrg{}", 1, cv2.COLOR_BayerGBRG2RGB),
    ("bayer_grbg{}", 1, cv2.COLOR_BayerGRBG2RGB),
)

ENCODINGS = {
    form.format(bits): (channels, to_rgb, bits)
    for form, channels, to_rgb in _FORMS
    for bits in ((8, 16) if "{}" in form else (8,))
}
"""How an image message holds a pixel: channels, conversion to RGB if any, bits, by its name."""


def is_bag(path: Path) -> bool:
    """Tell whether a path is a bag by its name: a file of known ending, or a bag's folder."""
    # Unlike the path's own `is_file` it raises nothing where there is no right to look.
    return _is_part(path) or os.path.isfile(path / METADATA)


class BagSource(Source):
    """The images of a topic in the order in which they were received.

    Frames are timed by their headers' stamps; where a stamp is missing or one does not rise, by
    when the bag's recorder received them. No topic is needed where the bag has images on one only.
    """

    def __init__(self, path: Path, topic: str | None = None) -> None:
        super().__init__(
            str(path),
            self._images,
            end_notes=lambda times_ms, is_whole: self._colour_notes,
            no_frames=lambda: UnreadableClip(f"{path}: the topic holds no image; record it again."),
        )
        self._path, self._topic = path, topic
        self._colour_notes: list[str] = []

    def _images(self, stride: int) -> Iterator[SourceFrame]:
        path = self._path
        reader_of, deserialize = _rosbags(path)
        with (
            damage_as(_damage(path)),
            plain_name(_plain_part(path)) as plain,
            reader_of(Path(plain)) as reader,
        ):
            topic = _topic_of(reader, path, self._topic)
            connections = [link for link in reader.connections if link.topic == topic]
            first_stamp_s = first_received_s = 0.0
            for number, (link, received_ns, raw) in enumerate(reader.messages(connections)):
                message, received_s = deserialize(raw, link.msgtype), 1e-9 * received_ns
                stamp_s = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
                if number == 0:
                    first_stamp_s, first_received_s = stamp_s, received_s
                    self._note_first(message)
                yield SourceFrame(
                    partial(_decoded, message, f"{path}: image {number}"),
                    1000 * (stamp_s - first_stamp_s) if min(first_stamp_s, stamp_s) > 0 else None,
                    1000 * (received_s - first_received_s),
                )

    def _note_first(self, message: Any) -> None:
        self.notes += _stated_shape(message).notes
        encoding = getattr(message, "encoding", "")
        if encoding.endswith(("UC3", "UC4")):
            self._colour_notes.append(
                f"The encoding {encoding} does not tell the order of colours: blue was taken to be "
                f"first, as OpenCV has it."
            )


def _stated_shape(message: Any) -> StatedShape:
    """Return what a compressed image states about its pixels and how it is turned."""
    return image_shape(BytesIO(message.data)) if hasattr(message, "format") else StatedShape()


def _decoded(message: Any, name: str) -> Frames:
    """Return a message's image as uint8 RGB, shape (rows, columns, 3)."""
    if not hasattr(message, "format"):
        return _unpadded(message, name)
    refusal = (
        f"{name} ({message.format or 'of no format'}) is cut off or is no picture, expected jpeg "
        f"or png; record it again."
    )
    image = decoded_image(message.data.tobytes(), name, refusal)
    return _stated_shape(message).squared(image, name)


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
    require_package("rosbags", f"{path}: a bag is read with rosbags", "ros")
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    # The two types of image are the same in every release of ROS 2; older bags hold no definitions.
    if path.suffix.lower() != ROS_1:
        return Reader, get_typestore(Stores.LATEST).deserialize_cdr
    return Reader1, get_typestore(Stores.ROS1_NOETIC).deserialize_ros1


def _topic_of(reader: Reader, path: Path, topic: str | None) -> str:
    """Return the topic to read, refusing a bag that leaves it open."""
    counts: dict[str, int] = {}
    for link in reader.connections:
        if link.msgtype in (RAW, PACKED):
            counts[link.topic] = counts.get(link.topic, 0) + link.msgcount
    if not counts:
        others = ", ".join(sorted({link.topic for link in reader.connections})) or "no topic"
        raise UnreadableClip(
            f"{path}: holds no images but {others}, expected a topic of {RAW} or {PACKED}; record "
            f"the sensor's."
        )
    images = ", ".join(f"{name} ({count} images)" for name, count in sorted(counts.items()))
    if topic is None and len(counts) > 1:
        raise TopicNeeded(
            f"{path}: holds images on {len(counts)} topics, {images}, expected one; give it by "
            f"--topic."
        )
    if topic is not None and topic not in counts:
        raise TopicNeeded(
            f"{path}: holds no images on the topic {topic}, expected {images}; give one by --topic."
        )
    return topic or next(iter(counts))


def _unpadded(message: Any, name: str) -> Frames:
    rows, columns = message.height, message.width
    if message.encoding not in ENCODINGS:
        raise UnreadableClip(
            f"{name} has the encoding {message.encoding or '(none)'}, expected "
            f"{', '.join(ENCODINGS)}; publish the camera's images in one of these."
        )
    channels, to_rgb, bits = ENCODINGS[message.encoding]
    order = ">" if message.is_bigendian else "<"
    kind = np.dtype(np.uint8 if bits == 8 else f"{order}u2")
    kept_frames(rows, columns, name)  # refused before room is made for it
    line = columns * channels * kind.itemsize
    step, data = message.step, message.data
    if 0 in (rows, columns) or step < line or len(data) < step * rows:
        raise UnreadableClip(
            f"{name} has {len(data)} bytes in rows of {step}, expected {rows} rows of "
            f"{line}; record it again."
        )
    lines = np.ascontiguousarray(data[: step * rows].reshape(rows, step)[:, :line])
    pixels = lines.view(kind).astype(kind.newbyteorder("=")).reshape(rows, columns, -1)
    [pixels] = of_8_bits([pixels], name)
    if to_rgb is None:
        return pixels
    try:
        return cv2.cvtColor(pixels, to_rgb)
    except cv2.error as error:  # an odd number of columns in pairs of pixels
        raise UnreadableClip(
            f"{name} has {columns} x {rows} pixels, which the encoding {message.encoding} "
            f"does not divide into its groups; publish the camera's images as rgb8."
        ) from error


def _damage(path: Path) -> str:
    kind, writer, repair = "ROS 2", "ros2 bag record", "mcap recover"
    if path.suffix.lower() == ROS_1:
        kind, writer, repair = "ROS 1", "rosbag record", "rosbag reindex"
    return (
        f"{path}: is cut off or is no bag of {kind}, expected what `{writer}` writes; copy it "
        f"again, or repair it by `{repair}`."
    )
