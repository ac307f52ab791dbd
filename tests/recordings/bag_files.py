"""Bags of ROS 2 and ROS 1, written by the library that reads them without ROS."""

import cv2
import numpy as np
import pytest

rosbags = pytest.importorskip("rosbags", reason="needs the extra `ros`")

from rosbags.rosbag1 import Writer as Writer1  # noqa: E402
from rosbags.rosbag2 import (  # noqa: E402
    CompressionFormat,
    CompressionMode,
    StoragePlugin,
    Writer,
)
from rosbags.typesys import Stores, get_typestore  # noqa: E402

MCAP, SQLITE = StoragePlugin.MCAP, StoragePlugin.SQLITE3
PER_FILE, PER_MESSAGE = CompressionMode.FILE, CompressionMode.MESSAGE
TYPES = get_typestore(Stores.ROS2_JAZZY)
TYPES_1 = get_typestore(Stores.ROS1_NOETIC)
IMAGE, PACKED, TEXT = (
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/CompressedImage",
    "std_msgs/msg/String",
)
TOPIC = "/gelsight/image_raw"
STEP_NS = 40_000_000
START_NS = 1_700_000_000 * 10**9

CONVERSIONS = {
    "rgb8": None,
    "bgr8": cv2.COLOR_RGB2BGR,
    "8UC3": cv2.COLOR_RGB2BGR,
    "mono8": cv2.COLOR_RGB2GRAY,
}


def header(stamp_ns):
    time = TYPES.types["builtin_interfaces/msg/Time"](*divmod(int(stamp_ns), 10**9))
    return TYPES.types["std_msgs/msg/Header"](time, "gelsight")


def raw(frame, stamp_ns, encoding="rgb8", padding=0):
    """Return an image message of an RGB frame, with `padding` bytes behind each row."""
    to = CONVERSIONS.get(encoding)
    stored = frame if to is None else cv2.cvtColor(frame, to)
    rows, columns = stored.shape[:2]
    lines = np.pad(stored.reshape(rows, -1), ((0, 0), (0, padding)), constant_values=99)
    is_bigendian = 1  # which says nothing of bytes
    return TYPES.types[IMAGE](
        header(stamp_ns), rows, columns, encoding, is_bigendian, lines.shape[1], lines.reshape(-1)
    )


def stored_as(pixels, encoding, stamp_ns=START_NS):
    """Return an image message of pixels as the encoding stores them, (rows, columns, channels)."""
    rows, columns = pixels.shape[:2]
    data = np.frombuffer(pixels.tobytes(), np.uint8)
    is_bigendian = int(pixels.dtype.byteorder == ">")
    step = len(data) // rows
    about = (rows, columns, encoding, is_bigendian, step, data)
    return TYPES.types[IMAGE](header(stamp_ns), *about)


def packed(frame, stamp_ns, ending="png"):
    """Return a compressed image message of an RGB frame."""
    stored = cv2.imencode(f".{ending}", cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))[1]
    form = {"png": "png", "jpg": "bgr8; jpeg compressed bgr8"}[ending]
    return TYPES.types[PACKED](header(stamp_ns), form, stored.reshape(-1))


def even_ns(count):
    return START_NS + STEP_NS * np.arange(count)


def write_bag(folder, topics, *, received_ns=None, storage=MCAP, compression=None):
    """Write messages by topic to a folder; without `received_ns` one comes every 40 ms."""
    writer = Writer(folder, version=9, storage_plugin=storage)
    if compression is not None:
        writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        lines = []
        for topic, messages in topics.items():
            kind = messages[0].__msgtype__
            connection = writer.add_connection(topic, kind, typestore=TYPES)
            times = even_ns(len(messages)) if received_ns is None else received_ns
            lines += [
                (int(at), number, connection, TYPES.serialize_cdr(one, kind))
                for number, (at, one) in enumerate(zip(times, messages, strict=True))
            ]
        for at, _, connection, data in sorted(lines, key=lambda line: line[:2]):
            writer.write(connection, at, data)
    return folder


def raw_bag(folder, frames, encoding="rgb8", **options):
    """Write frames to one topic of a bag, 25 a second."""
    messages = [raw(*one, encoding) for one in zip(frames, even_ns(len(frames)), strict=True)]
    return write_bag(folder, {TOPIC: messages}, **options)


def first_bag(path, topics):
    """Write messages of ROS 2 by topic as ROS 1 does, 25 a second of each topic."""
    with Writer1(path) as writer:
        for topic, messages in topics.items():
            kind = messages[0].__msgtype__
            connection = writer.add_connection(topic, kind, typestore=TYPES_1)
            for at, message in zip(even_ns(len(messages)), messages, strict=True):
                about = TYPES_1.types["std_msgs/msg/Header"](0, message.header.stamp, "gelsight")
                fields = {**vars(message), "header": about}
                first = TYPES_1.types[kind](
                    **{name: value for name, value in fields.items() if name != "__msgtype__"}
                )
                writer.write(connection, int(at), TYPES_1.serialize_ros1(first, kind))
    return path


def text(words="hello"):
    return TYPES.types[TEXT](words)
