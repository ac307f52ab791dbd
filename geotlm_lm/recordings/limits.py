"""How much of a recording is held in memory, and the sentence that says what was left out."""

from __future__ import annotations

KEPT_BYTES = 512 * 2**20
"""Bytes of frames held at most: 2,300 frames of 320x240, a minute and a half at 25 fps."""

DECLARED_BYTES = 16 * 2**30
"""Bytes an array file may declare; more is taken for a damaged or hostile header."""

DECODED_FRAMES = 20_000
"""Frames decoded from a video at most: 20 s of work at 320x240 (measured: 0.9 ms a frame)."""


def kept_frames(frame_bytes: int) -> int:
    """Return how many frames of `frame_bytes` fit; at least 4, however large they are."""
    return max(KEPT_BYTES // max(frame_bytes, 1), 4)


def stride_for(frame_count: int, frame_bytes: int) -> int:
    """Return the smallest stride at which a recording fits."""
    return -(-frame_count // kept_frames(frame_bytes))


def stride_note(stride: int, frame_count: int) -> str:
    """Return what a stride above 1 left out."""
    return (
        f"Of {frame_count} frames one in {stride} was read to bound memory; "
        f"cut the recording to see all of them."
    )
