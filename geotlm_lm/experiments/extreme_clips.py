"""Recordings at the edge of sense: no contact, no picture, one frame, ten thousand, eight pixels.

Each comes with the motions that are a right answer to it; where nothing can be told there is none,
and only an abstention or a refusal is right. Knows no model.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import Motion
from geotlm_lm.experiments.degradations import noisy, resized
from geotlm_lm.recordings.read import read_clip

LONG_FRAMES = 10_000
LONG_SIDE = 64
"""A recording of 10,000 frames of 64x64 pixels takes 123 MB; of 224x224 it would be strided."""

UNTOUCHED = frozenset({Motion.NONE})
UNKNOWABLE: frozenset[Motion] = frozenset()


@dataclass(frozen=True)
class Extreme:
    """One recording that is asked about.

    Args:
        right: Motions that are right; none where nothing can be told.
        make: Returns the clip; may refuse as a reader would.
    """

    right: frozenset[Motion]
    make: Callable[[], Clip]


def extreme_clips(touched: Clip, motion: Motion) -> dict[str, Extreme]:
    """Return every extreme recording by name.

    Args:
        touched: A clip of a touch with its background, from which some are made.
        motion: What the object in it does.
    """
    idle, same = touched.background, frozenset({motion})
    return {
        **dict(_flat_clips(idle)),
        **dict(_dotted_clips(idle)),
        "noise alone, all greys": Extreme(UNKNOWABLE, lambda: Clip(_noise(idle))),
        "noise alone, idle gel given": Extreme(
            UNKNOWABLE, lambda: Clip(_noise(idle), background=idle)
        ),
        "idle gel, noise of 4 grey": Extreme(UNTOUCHED, lambda: _idle_with_noise(idle, 4.0)),
        "idle gel, exactly the background": Extreme(UNTOUCHED, lambda: _still(idle, idle)),
        "a touch frozen in one frame": Extreme(
            frozenset({Motion.STILL}), lambda: _still(touched.frames[-1], idle)
        ),
        "one frame": Extreme(UNKNOWABLE, lambda: touched.select([0])),
        "two frames": Extreme(same, lambda: touched.select([0, 3])),
        "10,000 frames": Extreme(same, lambda: _long(touched)),
        "8x8 pixels": Extreme(same, lambda: _sized(touched, (8, 8))),
        "7x7 pixels": Extreme(same, lambda: _sized(touched, (7, 7))),
        "3840x2160 pixels": Extreme(same, lambda: _sized(touched, (3840, 2160))),
        "2000x8 pixels": Extreme(same, lambda: _sized(touched, (2000, 8))),
        "colours first, (T,3,H,W)": Extreme(
            same, lambda: _filed(np.moveaxis(touched.frames, -1, 1), idle)
        ),
        "four colours": Extreme(same, lambda: _filed(np.pad(touched.frames, _ALPHA), idle)),
        "no colour axis": Extreme(same, lambda: _filed(touched.frames[..., 0], None)),
        "16-bit values": Extreme(
            same, lambda: _filed(touched.frames.astype(np.uint16) * 257, None)
        ),
        "a NaN in one frame": Extreme(same, lambda: _filed(_with_nan(touched.frames), None)),
        "background of another size": Extreme(
            same, lambda: replace(touched, background=np.zeros((8, 9, 3), np.uint8))
        ),
    }


_ALPHA = ((0, 0), (0, 0), (0, 0), (0, 1))


def _flat_clips(idle: Frames) -> Iterator[tuple[str, Extreme]]:
    """Yield constant images, without a background and against a real idle gel."""
    for name, grey in (("black", 0), ("grey 128", 128), ("white", 255)):
        flat = np.full((FRAME_COUNT, *idle.shape), grey, np.uint8)
        # A constant image without a background might be an idle gel, unless it is no image.
        right = UNTOUCHED if 0 < grey < 255 else UNKNOWABLE
        yield name, Extreme(right, lambda flat=flat: Clip(flat))
        yield (
            f"{name}, idle gel given",
            Extreme(UNKNOWABLE, lambda flat=flat: Clip(flat, background=idle)),
        )
    flicker = np.zeros((FRAME_COUNT, *idle.shape), np.uint8)
    flicker[1::2] = 255
    yield "black and white in turn", Extreme(UNKNOWABLE, lambda: Clip(flicker, background=idle))


def _dotted_clips(idle: Frames) -> Iterator[tuple[str, Extreme]]:
    """Yield an idle gel with one bright pixel, which stays or moves: nothing touches it."""
    for name, step in (("a hot pixel", 0), ("a moving pixel", 5)):
        frames = np.repeat(idle[None], FRAME_COUNT, axis=0)
        for number, frame in enumerate(frames):
            frame[len(frame) // 2, frame.shape[1] // 2 + step * number] = 255
        yield name, Extreme(UNTOUCHED, lambda frames=frames: Clip(frames, background=idle))


def _noise(idle: Frames) -> Frames:
    rng = np.random.default_rng(0)
    return rng.integers(0, 256, (FRAME_COUNT, *idle.shape)).astype(np.uint8)


def _still(frame: Frames, idle: Frames) -> Clip:
    return Clip(np.repeat(frame[None], FRAME_COUNT, axis=0), background=idle)


def _idle_with_noise(idle: Frames, sigma_grey: float) -> Clip:
    return noisy(sigma_grey, _still(idle, idle), np.random.default_rng(0))


def _sized(clip: Clip, size: tuple[int, int]) -> Clip:
    frames = np.stack([resized(size, frame) for frame in clip.frames])
    return replace(clip, frames=frames, background=resized(size, clip.background))


def _long(clip: Clip) -> Clip:
    """Return the idle gel, then each of the clip's frames in equal shares, read from a file."""
    size = (LONG_SIDE, LONG_SIDE)
    idle, frames = resized(size, clip.background), [resized(size, one) for one in clip.frames]
    rng = np.random.default_rng(0)
    lead = LONG_FRAMES // 10
    order = [idle] * lead + [
        frames[number * FRAME_COUNT // (LONG_FRAMES - lead)] for number in range(LONG_FRAMES - lead)
    ]
    long = np.stack(order)
    # Camera noise: no frame is a copy of the one before.
    long = np.minimum(long, 254) + rng.integers(0, 2, long.shape, dtype=np.uint8)
    return _filed(long, None)


def _filed(array: NDArray, background: Frames | None) -> Clip:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "clip.npy"
        np.save(path, array)
        try:
            clip = read_clip(path)
        except UnreadableClip as error:  # told without the folder, which is another every time
            raise UnreadableClip(str(error).replace(f"{folder}/", "")) from error
    return replace(clip, background=background, name=path.name)


def _with_nan(frames: Frames) -> NDArray[np.float32]:
    values = frames / np.float32(255)
    values[2, 3, 4, 0] = np.nan
    return values
