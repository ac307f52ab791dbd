"""How much of a recording is held in memory, and the sentence that says what was left out."""

from __future__ import annotations

from geotlm_lm.core.errors import UnreadableClip

KEPT_BYTES = 512 * 2**20
"""Bytes of frames held at most: 2,300 frames of 320x240, a minute and a half at 25 fps."""

DECLARED_BYTES = 16 * 2**30
"""Bytes an array file may declare; more is taken for a damaged or hostile header."""

DECODED_FRAMES = 20_000
"""Frames decoded from a video at most: 20 s of work at 320x240 (measured: 0.9 ms a frame)."""

DECODING_S = 60.0
"""Seconds spent on decoding a video at most: one upload of huge frames must not hold up others."""

RATED_FRAMES = 32
"""Frames looked at before a recording is played, to learn its rate: 30 ms of work at 320x240."""

FEWEST_KEPT = 4
"""Frames that must fit at least, as many as an answer looks at: 44 million pixels each."""


def kept_frames(rows: int, columns: int, name: str) -> int:
    """Return how many RGB frames of this size fit.

    Args:
        rows: Of one frame.
        columns: Of one frame.
        name: Of the file, for errors.

    Raises:
        UnreadableClip: If not even `FEWEST_KEPT` do.
    """
    count = KEPT_BYTES // max(3 * rows * columns, 1)
    if count < FEWEST_KEPT:
        limit = KEPT_BYTES // (3 * FEWEST_KEPT) // 10**6
        raise UnreadableClip(
            f"{name}: frames are {columns}x{rows} pixels, expected at most {limit} million; "
            f"export the recording at a smaller size."
        )
    return count


def stride_for(frame_count: int, rows: int, columns: int, name: str) -> int:
    """Return the smallest stride at which a recording fits.

    Raises:
        UnreadableClip: If its frames are too large.
    """
    return -(-frame_count // kept_frames(rows, columns, name))


def stride_note(stride: int, frame_count: int) -> str:
    """Return what a stride above 1 left out."""
    return (
        f"Of {frame_count} frames one in {stride} was read to bound memory; "
        f"cut the recording to see all of them."
    )
