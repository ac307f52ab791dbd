"""Videos in forms that OpenCV does not write: AV1, GIF, pixels that are not square, turned."""

import os
import struct

import av
from PIL import Image

from tests.recordings.test_read import write_video

QUARTERS = {90: (0, 1, -1, 0), 180: (-1, 0, 0, -1), 270: (0, -1, 1, 0)}
"""Degrees clockwise -> the matrix that an .mp4 states."""


def write_gif(path, frames, durations_ms):
    first, *others = map(Image.fromarray, frames)
    first.save(path, save_all=True, append_images=others, duration=durations_ms)
    return path


def write_av(path, frames, codec="libsvtav1", fps=10, aspect=None):
    """Write frames by PyAV, with the width of a pixel over its height where it is given."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=fps)
        stream.height, stream.width = frames[0].shape[:2]
        stream.pix_fmt = "yuv420p"
        if aspect is not None:
            stream.codec_context.sample_aspect_ratio = aspect
        for frame in frames:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="rgb24")))
        container.mux(stream.encode(None))
    if codec == "libsvtav1" and hasattr(os, "sched_setscheduler"):
        # Run by root, its encoder leaves this process, and all it starts, at real-time priority.
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    return path


def turned(path, degrees):
    """State in an .mp4 that its pictures are to be turned clockwise."""
    stored = bytearray(path.read_bytes())
    at = stored.index(b"tkhd") + 44
    across, down, over, under = (value << 16 for value in QUARTERS[degrees])
    stored[at : at + 36] = struct.pack(">9i", across, down, 0, over, under, 0, 0, 0, 1 << 30)
    path.write_bytes(stored)
    return path


def shown_as(path, frames, width, height):
    """Write an .mkv of small frames that states another size to show them in."""
    rows, columns = frames[0].shape[:2]
    write_video(path, frames)
    stored = path.read_bytes()
    size = bytes([0xB0, 0x81, columns, 0xBA, 0x81, rows])
    kept = b"\x55\xee\x81\0"
    before = b"\xe0\x8a" + size + b"\x54\xb2\x81\x04" + kept + b"\xec\x01" + bytes(6) + b"\2\0\0"
    assert stored.count(before) == 1
    shown = bytes([0x54, 0xB0, 0x81, width, 0x54, 0xBA, 0x81, height])
    after = b"\xe0\x8e" + size + shown + kept
    left = len(before) - len(after) - 2
    path.write_bytes(stored.replace(before, after + bytes([0xEC, 0x80 + left]) + bytes(left)))
    return path
