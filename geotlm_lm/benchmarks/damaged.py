"""What cameras, cables and files do to a clip of known motion, and recordings at the edge of sense.

Every damage takes a clip with a background and gives the clip that a user would have recorded; the
motion stays the same. Where nothing can be told of an extreme recording, no motion is right, only
an abstention or a refusal. Knows no model.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import Motion
from geotlm_lm.recordings.pixels import as_pixels, drifted, faded, gained, jpeg
from geotlm_lm.recordings.read import read_clip

Damage = Callable[[Clip, np.random.Generator], Clip]
"""Takes a clip and a source of randomness; may refuse, as a reader would."""


DROPPED = {1: [0, 2, 3], 2: [0, 3], 3: [0]}
REPEATED = {1: [0, 1, 1, 3], 2: [0, 0, 0, 3]}
"""Frames dropped, or that show the one before once more -> the frames that are shown."""

CODECS = {"MJPG": ".avi", "XVID": ".avi", "mp4v": ".mp4"}
"""Four-letter codes that OpenCV's wheel writes -> container; their default quality."""


def damage_kinds() -> dict[str, dict[str, Damage]]:
    """Return every kind of damage by name: level -> what it does, mildest first."""
    return {
        "as recorded": {"-": lambda clip, rng: clip},
        "camera noise": _levels("grey levels", (5, 10, 20, 40, 80), _noisy),
        "JPEG": _of_images("quality", (90, 50, 20, 5), jpeg),
        "video": {f"{name} codec": partial(_filmed, name) for name in CODECS},
        "brightness drift": _levels(
            "grey levels over the clip",
            (5, 15, 40, 80),
            lambda v, c, rng: replace(c, frames=drifted(v, 0.0, c.frames)),
        ),
        "overexposed": _of_images("gain", (1.5, 2.5, 5), gained),
        "underexposed": _of_images("gain", (0.5, 0.2, 0.1, 0.05), gained),
        "fainter contact": _levels(
            "contrast",
            (0.5, 0.2, 0.1, 0.05),
            lambda v, c, rng: replace(c, frames=faded(v, c.frames, c.background)),
        ),
        "frames dropped": _levels("of 4", DROPPED, lambda v, c, rng: c.select(DROPPED[v])),
        "frames repeated": _levels(
            "of 4", REPEATED, lambda v, c, rng: replace(c, frames=c.frames[REPEATED[v]])
        ),
        "contact at the border": _levels("px off the middle", (40, 80, 112), _moved_off),
        "half the frame lost": _everywhere_or_frames_only(
            lambda image: image * (np.indices(image.shape)[1] < image.shape[1] // 2)
        ),
        "colours in the wrong order": _everywhere_or_frames_only(
            lambda image: image[..., ::-1].copy()
        ),
        "small frames": _of_images("px", (112, 56, 28, 8), lambda v, x: _resized((v, v), x)),
        "background not given": {"-": lambda clip, rng: replace(clip, background=None)},
    }


def _levels(unit: str, values: Iterable[float], damage: Callable[..., Clip]) -> dict[str, Damage]:
    return {f"{value:g} {unit}": partial(damage, value) for value in values}


def _of_images(unit: str, values: Iterable[float], change: Callable) -> dict[str, Damage]:
    return _levels(unit, values, lambda v, clip, rng: _each_image(partial(change, v), clip))


def _everywhere_or_frames_only(change: Callable[[Frames], Frames]) -> dict[str, Damage]:
    return {
        "everywhere": lambda clip, rng: _each_image(change, clip),
        "frames-only": lambda clip, rng: replace(
            _each_image(change, clip), background=clip.background
        ),
    }


def _each_image(change: Callable[[Frames], Frames], clip: Clip) -> Clip:
    frames = np.stack([change(frame) for frame in clip.frames])
    return replace(clip, frames=frames, background=change(clip.background))


def _noisy(sigma_grey: float, clip: Clip, rng: np.random.Generator) -> Clip:
    noise = rng.normal(0.0, sigma_grey, clip.frames.shape)
    return replace(clip, frames=as_pixels(clip.frames + noise))


def _moved_off(distance_px: float, clip: Clip, rng: np.random.Generator) -> Clip:
    idle = clip.background.astype(np.float32)
    rows, columns = idle.shape[:2]
    matrix = np.float32([[1, 0, distance_px * columns / 224], [0, 1, 0]])
    moved = [
        cv2.warpAffine(frame - idle, matrix, (columns, rows), flags=cv2.INTER_LINEAR)
        for frame in clip.frames.astype(np.float32)
    ]
    return replace(clip, frames=as_pixels(idle + np.stack(moved)))


def _filmed(codec: str, clip: Clip, rng: np.random.Generator) -> Clip:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"clip{CODECS[codec]}"
        write_video(path, codec, clip.frames)
        return replace(read_clip(path), background=clip.background)


def write_video(path: Path, codec: str, frames: Frames) -> None:
    """Write RGB frames (t, rows, columns, 3) as a video of 25 frames per second."""
    size = frames.shape[2], frames.shape[1]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*codec), 25.0, size)
    for frame in frames:
        writer.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
    writer.release()


def _resized(size: tuple[int, int], image: Frames) -> Frames:
    shrinks = size[0] < image.shape[1]
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)


LONG_FRAMES, LONG_SIDE = 10_000, 64
"""A recording of 10,000 frames of 64x64 pixels takes 123 MB; of 224x224 it would be strided."""

UNTOUCHED = frozenset({Motion.NONE})
UNKNOWABLE: frozenset[Motion] = frozenset()


class Extreme(NamedTuple):
    """A recording: the motions that are right, and what returns it or refuses as a reader would."""

    right: frozenset[Motion]
    make: Callable[[], Clip]


def extreme_clips(
    touched: Clip, motion: Motion, *, long_frames: int = LONG_FRAMES
) -> dict[str, Extreme]:
    """Return every extreme recording by name, some made from a touch and its motion."""
    frames, idle, same = touched.frames, touched.background, frozenset({motion})
    rng, shape = np.random.default_rng(0), (FRAME_COUNT, *idle.shape)
    noise, still = rng.integers(0, 256, shape).astype(np.uint8), _still(idle, idle)
    faint = _noisy(4.0, still, np.random.default_rng(0))
    frozen, other = _still(frames[-1], idle), np.zeros((8, 9, 3), np.uint8)
    made = {
        "noise alone, all greys": Extreme(UNKNOWABLE, partial(Clip, noise)),
        "noise alone, idle gel given": Extreme(UNKNOWABLE, partial(Clip, noise, background=idle)),
        "idle gel, noise of 4 grey": Extreme(UNTOUCHED, lambda: faint),
        "idle gel, exactly the background": Extreme(UNTOUCHED, lambda: still),
        "a touch frozen in one frame": Extreme(frozenset({Motion.STILL}), lambda: frozen),
        "one frame": Extreme(UNKNOWABLE, lambda: touched.select([0])),
        "two frames": Extreme(same, lambda: touched.select([0, 3])),
        f"{long_frames:,} frames": Extreme(same, lambda: _long(touched, long_frames)),
        "background of another size": Extreme(same, lambda: replace(touched, background=other)),
    }
    for size in ((8, 8), (7, 7), (3840, 2160), (2000, 8)):
        made[f"{size[0]}x{size[1]} pixels"] = Extreme(same, partial(_sized, touched, size))
    return _constant_clips(idle) | made


def _constant_clips(idle: Frames) -> dict[str, Extreme]:
    clips = {}
    for name, grey in (("black", 0), ("grey 128", 128), ("white", 255)):
        flat = np.full((FRAME_COUNT, *idle.shape), grey, np.uint8)
        # A constant image without a background might be an idle gel, unless it is no image.
        clips[name] = Extreme(UNTOUCHED if 0 < grey < 255 else UNKNOWABLE, partial(Clip, flat))
        clips[f"{name}, idle gel given"] = Extreme(UNKNOWABLE, partial(Clip, flat, background=idle))
    flicker = np.zeros((FRAME_COUNT, *idle.shape), np.uint8)
    flicker[1::2] = 255
    clips["black and white in turn"] = Extreme(UNKNOWABLE, partial(Clip, flicker, background=idle))
    for name, step in (("a hot pixel", 0), ("a moving pixel", 5)):
        frames = np.repeat(idle[None], FRAME_COUNT, axis=0)
        for number, frame in enumerate(frames):
            frame[len(frame) // 2, frame.shape[1] // 2 + step * number] = 255
        clips[name] = Extreme(UNTOUCHED, partial(Clip, frames, background=idle))
    return clips


def _still(frame: Frames, idle: Frames) -> Clip:
    return Clip(np.repeat(frame[None], FRAME_COUNT, axis=0), background=idle)


def _sized(clip: Clip, size: tuple[int, int]) -> Clip:
    frames = np.stack([_resized(size, frame) for frame in clip.frames])
    return replace(clip, frames=frames, background=_resized(size, clip.background))


def _long(clip: Clip, count: int) -> Clip:
    """Return the idle gel, then each of the clip's frames in equal shares."""
    small, rng, lead = _sized(clip, (LONG_SIDE, LONG_SIDE)), np.random.default_rng(0), count // 10
    shares = np.arange(count - lead) * FRAME_COUNT // (count - lead)
    long = np.concatenate([np.repeat(small.background[None], lead, axis=0), small.frames[shares]])
    # Camera noise: no frame is a copy of the one before.
    return Clip(np.minimum(long, 254) + rng.integers(0, 2, long.shape, dtype=np.uint8))
