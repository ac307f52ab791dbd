"""Whether frames hold a picture at all: exposure and noise, far outside what a working camera does.

A model asked about what no camera meant to show still names a motion, and with confidence; such
frames are refused in a sentence instead. Knows the idle gel, not what touches it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.numbers import quantile_by_rank

Colours = NDArray[np.uint8]
"""Pixels, colour first: (3, frames, rows, columns), or (3, rows, columns) of one image."""

DARK_GREY = 8
"""A pixel counts as black up to this level in every colour."""

WHITE_GREY = 255
"""A colour that has reached the end of its scale."""

DIM_GREY = 18
"""Least median of a frame's brightest colour. A tenth of the usual exposure leaves 10 to 12, on
which an imprint changes a pixel by a level or two and one contact in three is told wrong; a fifth
leaves 20 to 23, and five in six are told right. Real recordings have 99 and more."""

MOST_BLACK = 0.4
"""Share of a frame that may be black: a letterbox is 0.25 of it, half a frame 0.5."""

MOST_WHITE = 0.3
"""Share of a frame in which a colour may be at its end; 0.00 on real recordings, at most 0.01 on
simulated ones."""

MOST_NOISE_GREY = 9.0
"""White noise a frame may carry. Real recordings have 0.5 at most, simulated ones 2.5; at 10 one
answer in ten is wrong with a probability above 0.9."""

MOST_CHANGE_GREY = 12.0
"""Change of the whole image's brightness within the clip: 4 at most on 792 real windows and 6 on
1,200 simulated clips; at 15 one answer in five is wrong."""

MOST_OFFSET_GREY = 25.0
"""The same against the idle gel, where a large contact counts too: at most 6, and 19."""

FEWEST_PX = 24
"""Side of the smallest frame: of 60 simulated clips brought to 28 pixels 58 were told right, to 8
pixels 31, with probabilities as high."""

LEAST_DAMAGE_GREY = 6.0
"""Change of the whole image, on average, to a damaged frame and back: a decoder goes on behind the
bytes it cannot read with the rest of the picture shifted or grey, 7 to 43 levels off."""

LEAST_DAMAGE_RATIO = 6.0
"""The same in changes between the two frames beside it: 2.8 at most on 311 real recordings, where
contact begins and ends."""

SAMPLED_SIDE = 32
"""Rows, and columns where single pixels will do, that are looked at."""

FINE_SIDE = 32
"""Below it neighbouring pixels differ by the imprint itself, and noise cannot be told from it."""


def require_legible(clip: Clip) -> Clip:
    """Return a few frames beside their background, unless they hold no picture of a gel.

    Refused are tiny frames, one mostly black, dim or overexposed, frames that are mostly noise, or
    whose brightness is far from the background's or changes within the clip.
    """
    height, width = clip.frames.shape[1:3]
    if min(height, width) < FEWEST_PX:
        raise UnreadableClip(
            f"{clip.name}: frames are {width}x{height} pixels, expected at least {FEWEST_PX} a "
            f"side; export the recording at a larger size."
        )
    rows, columns = (max(1, side // SAMPLED_SIDE) for side in (height, width))
    # Colours first: numpy looks through neighbours in memory several times faster.
    sample = np.ascontiguousarray(clip.frames[:, ::rows, ::columns].transpose(3, 0, 1, 2))
    _require_exposed(clip, sample)
    is_fine = min(height, width) >= FINE_SIDE
    noise = noise_grey(clip.frames[:, :: 2 * rows, :, GREEN]) if is_fine else 0.0
    if noise > MOST_NOISE_GREY:
        raise UnreadableClip(
            f"{clip.name}: the frames carry noise of {noise:.0f} grey levels, expected at most "
            f"{MOST_NOISE_GREY:g}; lower the camera's gain, or average several frames into each."
        )
    if clip.background is not None:
        idle = clip.background[::rows, ::columns].transpose(2, 0, 1)
        _require_steady(clip, sample, idle)
    return clip


def require_any_legible(clip: Clip) -> Clip:
    """Return a recording, unless no frame looked at holds a picture: a flash is no harm."""
    refusals = []
    for place in sorted({round(place) for place in np.linspace(0, len(clip) - 1, LOOKED_AT)}):
        try:
            require_legible(replace(clip.select([place]), background=None))
        except UnreadableClip as error:
            refusals.append(error)
        else:
            return clip
    raise refusals[0]


def without_damaged(clip: Clip) -> Clip:
    """Return a recording without single frames unlike the two beside them, which a note names.

    Decoders take a picture of which some bytes were overwritten for a whole one.
    """
    if len(clip) < 3:
        return clip
    rows, columns = (max(1, side // SAMPLED_SIDE) for side in clip.frames.shape[1:3])
    sample = clip.frames[:, ::rows, ::columns].astype(np.int16)
    step = np.abs(np.diff(sample, axis=0)).mean(axis=(1, 2, 3))
    beside = np.abs(sample[2:] - sample[:-2]).mean(axis=(1, 2, 3))
    there_and_back = np.minimum(step[:-1], step[1:])
    is_damaged = (there_and_back >= LEAST_DAMAGE_GREY) & (
        there_and_back >= LEAST_DAMAGE_RATIO * beside
    )
    places = np.flatnonzero(is_damaged) + 1
    if not len(places):
        return clip
    numbers = ", ".join(str(clip.frame_numbers[place]) for place in places[:LOOKED_AT])
    kept = clip.select([place for place in range(len(clip)) if place not in set(places)])
    return kept.with_note(
        f"Left out: {len(places)} frames ({numbers}) unlike both their neighbours, as damaged "
        f"pictures are; copy or record the recording again."
    )


LOOKED_AT = 9
"""Frames of a recording that are looked at for a picture at most."""


def noise_grey(lines: NDArray[np.uint8]) -> float:
    """Return the deviation of the white noise along rows of pixels, (..., columns), grey levels.

    From the median size of second differences, to which a smooth image adds next to nothing and a
    few edges nothing at all (a normal distribution's median is 0.6745 of its deviation).
    """
    wide = lines.astype(np.int16)
    bend = wide[..., :-2] - 2 * wide[..., 1:-1] + wide[..., 2:]
    return float(quantile_by_rank(np.abs(bend))) / (0.6745 * np.sqrt(6.0))


def _require_exposed(clip: Clip, sample: Colours) -> None:
    brightest = sample.max(axis=0)
    black = (brightest <= DARK_GREY).mean(axis=(1, 2))
    white = (brightest == WHITE_GREY).mean(axis=(1, 2))
    if black.max() > MOST_BLACK:
        raise UnreadableClip(
            f"{clip.name}: {black.max():.0%} of frame {_number(clip, black)} is black, expected "
            f"at most {MOST_BLACK:.0%}; check the camera and the sensor's lights."
        )
    level = np.array([int(quantile_by_rank(frame)) for frame in brightest])
    if level.min() < DIM_GREY:
        raise UnreadableClip(
            f"{clip.name}: frame {_number(clip, -level)} is dim, its middle grey level is "
            f"{level.min():.0f}, expected at least {DIM_GREY}; lengthen the camera's exposure."
        )
    if white.max() > MOST_WHITE:
        raise UnreadableClip(
            f"{clip.name}: {white.max():.0%} of frame {_number(clip, white)} is overexposed, "
            f"expected at most {MOST_WHITE:.0%}; shorten the camera's exposure."
        )


def _require_steady(clip: Clip, sample: Colours, idle: Colours) -> None:
    residual = sample.astype(np.int16) - idle[:, None]
    offsets = np.array(
        [[quantile_by_rank(frame) for frame in colour] for colour in residual], np.float64
    )
    within = np.ptp(offsets, axis=1)
    if within.max() > MOST_CHANGE_GREY:
        raise UnreadableClip(
            f"{clip.name}: the brightness of the whole image changes by {within.max():.0f} grey "
            f"levels within the clip, expected at most {MOST_CHANGE_GREY:g}; lock the camera's "
            f"exposure."
        )
    worst = np.abs(offsets).max(axis=0)
    if worst.max() > MOST_OFFSET_GREY:
        raise UnreadableClip(
            f"{clip.name}: frame {_number(clip, worst)} is {worst.max():.0f} grey levels off the "
            f"background, expected at most {MOST_OFFSET_GREY:g}; give a background taken with the "
            f"same camera, lights and exposure."
        )


def _number(clip: Clip, values: NDArray[np.floating]) -> int:
    return clip.frame_numbers[int(np.argmax(values))]


GREEN = 1
"""The colour whose noise is measured: two of a camera's four photosites read it."""
