"""What cameras, cables and files do to a clip whose motion is known, from harmless to hopeless.

Every degradation takes a clip with a background and gives the clip that a user would have recorded;
the motion stays the same. Knows no model.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.recordings.damage import as_pixels, drifted, faded, gained, jpeg
from geotlm_lm.recordings.read import read_clip

Degrade = Callable[[Clip, np.random.Generator], Clip]
"""Takes a clip and a source of randomness; may refuse, as a reader would."""


@dataclass(frozen=True)
class Degradation:
    """One kind of damage, at rising strengths.

    Args:
        unit: What the levels count.
        levels: Level as the table names it -> what it does; mildest first.
        clips: Largest number of clips it is tried on; None for all there are.
    """

    unit: str
    levels: Mapping[str, Degrade]
    clips: int | None = None


LARGE_CLIPS = 4
"""Clips of 3840x2160 pixels: 100 MB of frames each."""


def degradations() -> dict[str, Degradation]:
    """Return every kind of damage by name, in the order of the table."""
    of_all, of_frames = on_everything, on_frames
    return {
        "as recorded": Degradation("", {"-": lambda clip, rng: clip}),
        "camera noise": _levels("grey levels", (5, 10, 20, 40, 80), lambda v: partial(noisy, v)),
        "JPEG": _levels("quality", (90, 50, 20, 5), lambda v: of_all(partial(jpeg, v))),
        "video": Degradation("codec", {name: partial(filmed, name) for name in CODECS}),
        "brightness drift": _levels(
            "grey levels over the clip", (5, 15, 40, 80), lambda v: partial(drifting, v, 0.0)
        ),
        "gain drift": _levels(
            "share over the clip", (0.05, 0.15, 0.4, 0.8), lambda v: partial(drifting, 0.0, v)
        ),
        "overexposed": _levels("gain", (1.5, 2.5, 5), lambda v: of_all(partial(gained, v))),
        "underexposed": _levels(
            "gain", (0.5, 0.2, 0.1, 0.05), lambda v: of_all(partial(gained, v))
        ),
        "fainter contact": _levels("contrast", (0.5, 0.2, 0.1, 0.05), lambda v: partial(faint, v)),
        "frames dropped": _levels("of 4", (1, 2, 3), lambda v: partial(dropped, v)),
        "frames repeated": _levels("of 4", (1, 2), lambda v: partial(repeated, v)),
        "contact at the border": _levels(
            "px off the middle", (40, 80, 112), lambda v: partial(moved_off, v)
        ),
        "half the frame lost": Degradation(
            "where",
            {
                "in all frames": of_all(half_black),
                "not in the background": of_frames(half_black),
            },
        ),
        "colours in the wrong order": Degradation(
            "where",
            {
                "in all frames": of_all(colours_swapped),
                "not in the background": of_frames(colours_swapped),
            },
        ),
        "small frames": _levels("px", (112, 56, 28, 8), lambda v: of_all(partial(resized, (v, v)))),
        "large frames": Degradation(
            "px", {"3840x2160": of_all(partial(resized, (3840, 2160)))}, LARGE_CLIPS
        ),
        "background not given": Degradation("", {"-": without_background}),
    }


def _levels(
    unit: str, values: tuple[float, ...], degrade: Callable[[float], Degrade]
) -> Degradation:
    return Degradation(unit, {f"{value:g}": degrade(value) for value in values})


def on_everything(change: Callable[[Frames], Frames]) -> Degrade:
    """Return what changes each frame and the background alike."""

    def degrade(clip: Clip, rng: np.random.Generator) -> Clip:
        frames = np.stack([change(frame) for frame in clip.frames])
        return replace(clip, frames=frames, background=change(clip.background))

    return degrade


def on_frames(change: Callable[[Frames], Frames]) -> Degrade:
    """Return what changes each frame and leaves the background."""

    def degrade(clip: Clip, rng: np.random.Generator) -> Clip:
        return replace(clip, frames=np.stack([change(frame) for frame in clip.frames]))

    return degrade


def noisy(sigma_grey: float, clip: Clip, rng: np.random.Generator) -> Clip:
    """Return the clip with white noise in every pixel, colour and frame, the background without."""
    noise = rng.normal(0.0, sigma_grey, clip.frames.shape)
    return replace(clip, frames=as_pixels(clip.frames + noise))


def drifting(offset_grey: float, gain: float, clip: Clip, rng: np.random.Generator) -> Clip:
    """Return the clip growing brighter, evenly from the first frame to the last."""
    return replace(clip, frames=drifted(offset_grey, gain, clip.frames))


def faint(contrast: float, clip: Clip, rng: np.random.Generator) -> Clip:
    """Return the clip with only a share of its change against the background."""
    return replace(clip, frames=faded(contrast, clip.frames, clip.background))


def moved_off(distance_px: float, clip: Clip, rng: np.random.Generator) -> Clip:
    """Return the clip with its imprint moved to the right over the idle gel, cut by the border."""
    idle = clip.background.astype(np.float32)
    rows, columns = idle.shape[:2]
    matrix = np.float32([[1, 0, distance_px * columns / 224], [0, 1, 0]])
    moved = [
        cv2.warpAffine(frame - idle, matrix, (columns, rows), flags=cv2.INTER_LINEAR)
        for frame in clip.frames.astype(np.float32)
    ]
    return replace(clip, frames=as_pixels(idle + np.stack(moved)))


def dropped(count: float, clip: Clip, rng: np.random.Generator) -> Clip:
    """Return the clip without `count` of its inner frames, the last of all if there are none."""
    kept = {1: [0, 2, 3], 2: [0, 3], 3: [0]}[int(count)]
    return clip.select(kept)


def repeated(count: float, clip: Clip, rng: np.random.Generator) -> Clip:
    """Return the clip in which `count` frames show the one before once more."""
    shown = {1: [0, 1, 1, 3], 2: [0, 0, 0, 3]}[int(count)]
    return replace(clip, frames=clip.frames[shown])


def without_background(clip: Clip, rng: np.random.Generator) -> Clip:
    """Return the clip without its idle gel, which then has to be guessed."""
    return replace(clip, background=None)


CODECS = {"MJPG": ".avi", "XVID": ".avi", "mp4v": ".mp4"}
"""Four-letter codes that OpenCV's wheel writes -> container; their default quality."""


def filmed(codec: str, clip: Clip, rng: np.random.Generator) -> Clip:
    """Return the clip written as video and read back."""
    rows, columns = clip.frames.shape[1:3]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"clip{CODECS[codec]}"
        writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*codec), 25.0, (columns, rows))
        for frame in clip.frames:
            writer.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
        writer.release()
        return replace(read_clip(path), background=clip.background)


def half_black(image: Frames) -> Frames:
    """Return an image whose right half is black."""
    darkened = image.copy()
    darkened[:, image.shape[1] // 2 :] = 0
    return darkened


def colours_swapped(image: Frames) -> Frames:
    """Return an image whose red is called blue."""
    return image[..., ::-1].copy()


def resized(size: tuple[int, int], image: Frames) -> Frames:
    """Return an image of (columns, rows) pixels."""
    shrinks = size[0] < image.shape[1]
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)
