"""Frames from video files, at a stride that keeps long recordings within memory."""

from __future__ import annotations

import time
from pathlib import Path

import cv2
import numpy as np

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.recordings.containers import WHOLE_SHARE, cut_off_note, declared_end
from geotlm_lm.recordings.frame_times import length_s, rate_by, uneven_times_s
from geotlm_lm.recordings.limits import (
    DECODED_FRAMES,
    DECODING_S,
    FEWEST_KEPT,
    RATED_FRAMES,
    kept_frames,
    stride_note,
)
from geotlm_lm.recordings.video_file import GIF, Capture, video_file

VIDEO_SUFFIXES = (".mp4", ".m4v", ".avi", ".mov", ".mkv", ".webm", GIF)

LOSSY_SUFFIXES = (".mp4", ".m4v", ".webm", GIF)
"""Containers that nearly always hold lossy video: mp4v costs 4.1 grey levels on a gel image, MJPG
2.1, FFV1 none; VP8 and VP9 2.3, where mp4v costs 2.4 (measured, of another clip); the 256 colours
of a GIF 2.3."""


def read_video(path: Path) -> Clip:
    """Return the clip in a video file.

    Raises:
        UnreadableClip: If no frame of it can be decoded, or the frames are too large.
        MissingDependency: If it is AV1 video, and what decodes it is not installed.
    """
    with video_file(path) as capture:
        frames, stride, times_ms, is_whole = _decode(capture, str(path))
        told = float(capture.get(cv2.CAP_PROP_FPS))
        declared = float(capture.get(cv2.CAP_PROP_FRAME_COUNT))
    if not frames:
        raise undecoded(path)
    seen, suffix = len(times_ms), path.suffix.lower()
    fps, notes = rate_by(times_ms, told)
    notes = (*capture.notes, *notes)
    if is_whole:
        # Of a container that declares no duration OpenCV guesses the count by its size.
        declared_s = declared / told if told > 0 and seen < WHOLE_SHARE * declared else None
        cut_off = cut_off_note(path, seen, length_s(times_ms), declared_s)
        notes = notes if cut_off is None else (*notes, cut_off)
    if suffix in LOSSY_SUFFIXES:
        notes = (
            *notes,
            f"This {suffix[1:]} video is lossy and blurs fine imprints; record .npy, .png or FFV1 "
            f"instead.",
        )
    if stride > 1:
        notes = (*notes, stride_note(stride, seen))
    if not is_whole:
        notes = (*notes, f"Only the first {seen} frames were read; cut the recording.")
    return Clip(
        np.stack(frames),
        fps=fps,
        name=str(path),
        frame_numbers=tuple(range(0, seen, stride)),
        recorded_frames=seen,
        notes=notes,
        times_s=uneven_times_s(times_ms, fps),
    )


def undecoded(path: Path) -> UnreadableClip:
    """Return the error of a video of which no frame can be decoded."""
    end = declared_end(path)
    if end is not None and end.declared_bytes is not None and end.note() is not None:
        share = end.present_bytes / end.declared_bytes
        return UnreadableClip(
            f"{path}: only {share:.0%} of the file is there, cut off before its index; copy or "
            f"record it again."
        )
    return UnreadableClip(
        f"{path}: no frame of it can be decoded, expected a {', '.join(VIDEO_SUFFIXES)} video; "
        f"copy or export it again."
    )


def rate_ahead(capture: Capture) -> tuple[float | None, tuple[str, ...]] | None:
    """Return the frame rate by the first frames' times, as `rate_by` does; None without a frame.

    Args:
        capture: Open at its first frame; `RATED_FRAMES` of its frames are passed over.
    """
    times_ms = []
    while len(times_ms) < RATED_FRAMES and capture.grab():
        times_ms.append(float(capture.get(cv2.CAP_PROP_POS_MSEC)))
    return rate_by(times_ms, float(capture.get(cv2.CAP_PROP_FPS))) if times_ms else None


def _decode(capture: Capture, name: str) -> tuple[list[np.ndarray], int, list[float], bool]:
    """Return RGB frames, their stride, the times of all frames seen, and whether these are all.

    The stride doubles whenever the frames kept no longer fit: counts in headers are often wrong.
    """
    frames: list[np.ndarray] = []
    times_ms: list[float] = []
    stride, seen, until = 1, 0, time.monotonic() + DECODING_S
    while is_more := capture.grab():
        if seen >= DECODED_FRAMES or (seen >= FEWEST_KEPT and time.monotonic() > until):
            break
        if seen % stride == 0:
            is_decoded, image = capture.retrieve()
            if not is_decoded:
                is_more = False
                break
            if frames and image.shape != frames[0].shape:
                raise UnreadableClip(
                    f"{name}: frame {seen} is {image.shape[1]} x {image.shape[0]} pixels after "
                    f"{frames[0].shape[1]} x {frames[0].shape[0]}, expected one size; export the "
                    f"recording at one size."
                )
            if len(frames) >= kept_frames(*image.shape[:2], name):
                frames = frames[::2]
                stride *= 2
            if seen % stride == 0:
                frames.append(cv2.cvtColor(image, cv2.COLOR_BGR2RGB))
        times_ms.append(float(capture.get(cv2.CAP_PROP_POS_MSEC)))
        seen += 1
    return frames, stride, times_ms, not is_more
