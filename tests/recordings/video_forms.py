"""Videos in forms that OpenCV does not write: AV1, GIF, pixels that are not square, turned."""

import os
import struct

import av

QUARTERS = {90: (0, 1, -1, 0), 180: (-1, 0, 0, -1), 270: (0, -1, 1, 0)}
"""Degrees clockwise -> the matrix that an .mp4 states."""


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
