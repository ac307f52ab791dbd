"""A whole recording examined: every frame once, then those that were kept."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.doctor import gel, light, picture, timing
from geotlm_lm.doctor.finding import Finding
from geotlm_lm.track.exposure import small_colours

MOST_FRAMES = 6000
"""Frames of a recording that are looked at one by one: four minutes at 25 a second."""


def examine(clip: Clip, frames: Iterable[tuple[int, Frames]] | None = None) -> list[Finding]:
    """Return what was found, in the order in which it is told.

    Args:
        clip: As it was read.
        frames: Number and picture of each frame of the recording, as `each_frame` yields them; None
            for those of the clip.
    """
    smalls, repeats, numbers, before = [], [], [], None
    every = frames or zip(clip.frame_numbers, clip.frames, strict=True)
    for number, frame in every:
        if len(numbers) == MOST_FRAMES:
            break
        numbers.append(number)
        smalls.append(small_colours(frame))
        if before is not None:
            repeats.append(np.array_equal(frame, before))
        before = frame
    is_every = numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    idle_found, idle = gel.idle_gel(clip)
    seen = idle if idle is not None else _median_of(clip)
    return [
        timing.frame_rate(clip),
        timing.missing_frames(clip),
        *timing.file_end(clip),
        timing.repeated_frames(np.array(repeats, bool), is_every=is_every),
        picture.size(clip),
        picture.pixel_shape(clip),
        picture.mount(clip),
        gel.colours(seen),
        *light.drifts(smalls),
        *light.pixels(clip),
        idle_found,
        gel.contrast(clip, idle),
        gel.markers(seen),
    ]


def _median_of(clip: Clip) -> Frames:
    chosen = np.unique(np.linspace(0, len(clip) - 1, 9).round().astype(int))
    return np.median(clip.frames[chosen], axis=0).astype(np.uint8)
