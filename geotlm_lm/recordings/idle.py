"""The idle gel, found in a recording or guessed from its shading; what imprints add to it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.alignment.dots import ACTIVITY_WIDTH, activity_grey, filled, is_marked, shrunk
from geotlm_lm.core.clip import Clip, Frames

POLYNOMIAL_DEGREE = 6
"""Degree of the shading in each direction. Measured on 17 real recordings, four in-contact frames:
2.8 grey levels (rms, median) from the true idle gel and 3.8 inside the imprint, where the frames
themselves are 10.4 off; 4.3 and 5.0 at degree 4."""

FIT_WIDTH = 40
"""Columns of the image the shading is fitted on; an imprint is wider than 1/40 of the image."""

FIT_ITERATIONS = 4
"""Rounds of down-weighting; more begin to down-weight the shading at the rim (measured)."""

FIT_SCALE = 4.0
"""Grey levels below which being off the fit costs no weight: real shading is off by about 3."""

FIT_FRAMES = 8
"""Frames the shading is fitted on at most; more of them add time, not pixels off the imprint."""

LOST_SHARE = 0.2
"""Share of a change that may be structure the leading frames lost. What touches an idle gel only
adds to it: 0; a lifted object takes its imprint away: 1; a moved one takes it and adds it: 1/2.
Measured on 111 real recordings: idle found in 78 %, in 3 % of their in-contact parts by mistake."""


CONTACT_UNKNOWN = (
    "Whether anything touches the gel is not known without an idle frame: begin a recording before "
    "the touch, or give one as its background."
)


def estimate_background(frames: Frames) -> Frames:
    """Guess the idle gel, (rows, columns, 3), from frames that may all be in contact.

    A smooth shading (a polynomial per channel) is fitted to all frames together, and pixels off the
    fit lose their weight, so that most of an imprint drops out. Fine dirt does not come back.
    """
    rows, columns = frames.shape[1:3]
    chosen = np.unique(np.linspace(0, len(frames) - 1, FIT_FRAMES).round().astype(int))
    small = np.stack([shrunk(frames[index], FIT_WIDTH) for index in chosen]).astype(np.float32)
    small_rows, small_columns = small.shape[1:3]
    across, down = _powers(small_columns), _powers(small_rows)
    basis = np.einsum("ri,cj->rcij", down, across).reshape(small_rows * small_columns, -1)
    # In float64: in float32 the guess moved by a grey level with the number of BLAS threads.
    basis = basis.astype(np.float64)
    values = small.reshape(len(small), -1, 3).astype(np.float64)
    target = values.mean(axis=0)
    weight = np.ones(len(basis))
    for _ in range(FIT_ITERATIONS):
        # Pixels share one weight over frames and channels: where the gel is touched, all are off.
        weighted = basis * weight[:, None]
        normal = weighted.T @ basis + RIDGE * len(basis) * np.eye(basis.shape[1])
        shading = basis @ np.linalg.solve(normal, weighted.T @ target)
        off = np.sqrt(np.square(values - shading).mean(axis=(0, 2)))
        scale = max(float(np.quantile(off, 0.3)), FIT_SCALE)
        weight = 1 / np.square(1 + np.square(off / scale))
    coefficients = np.linalg.solve(normal, weighted.T @ target)
    cube = coefficients.reshape(POLYNOMIAL_DEGREE + 1, POLYNOMIAL_DEGREE + 1, 3)
    lines = np.tensordot(_powers(rows), cube, axes=(1, 0))
    full = np.einsum("rjk,cj->rck", lines, _powers(columns), optimize=True)
    return np.clip(np.rint(full), 0, 255).astype(np.uint8)


RIDGE = 1e-6
"""Relative ridge that keeps the fit solvable where touched pixels leave few others."""


def find_idle(clip: Clip, grey: NDArray[np.float32] | None = None) -> Frames | None:
    """Return the idle gel of a recording that starts, ends or rests in between untouched.

    None where it does not. Frames that agree with each other while others differ clearly, and lose
    none of what these showed, are idle; their median is the background. Most of the time goes into
    `grey`, the frames' `activity_grey`, where it is not known already. Of a gel with dots, which a
    touch moves, what is between them is looked at.
    """
    grey = activity_grey(clip.frames) if grey is None else grey
    places = _marked_idle(clip.frames) if is_marked(grey) else _plain_idle(grey)
    if not len(places):
        return None
    picked = places[np.unique(np.linspace(0, len(places) - 1, 9).round().astype(int))]
    return np.median(clip.frames[picked], axis=0).astype(np.uint8)


def _plain_idle(grey: NDArray[np.float32]) -> NDArray[np.int64]:
    """Return which frames show the idle gel, of a gel without dots; none where it is not seen."""
    numbers = np.arange(len(grey))
    for order in (slice(None), slice(None, None, -1)):
        count = _leading_idle(grey[order])
        if count:
            return numbers[order][:count]
    quietest = int(np.square(_structure(grey)).sum(axis=(1, 2)).argmin())
    rest, is_touched, apart = _rest_around(grey, quietest)
    if len(rest) < REST_FRAMES or apart < CLEAR_CHANGE:
        return numbers[:0]
    lost = lost_share(np.median(grey[rest], axis=0), grey[is_touched])
    return rest if np.median(lost) < LOST_SHARE else numbers[:0]


def _marked_idle(frames: Frames) -> NDArray[np.int64]:
    """Return which frames show the idle gel, of a gel with dots; none where it is not seen."""
    pictures = activity_colours(frames)
    looks = texture(pictures)
    quietest = int(np.square(looks).sum(axis=(1, 2, 3)).argmin())
    flat = looks.reshape(*looks.shape[:2], -1)
    for place in (0, len(looks) - 1, quietest):
        rest, is_touched, apart = _rest_around(flat, place)
        least = LEADING_FRAMES if place == 0 else REST_FRAMES
        if len(rest) < least or apart < CLEAR_TEXTURE:
            continue
        if texture_lost(pictures[rest], pictures[is_touched]) < MARKED_LOST:
            return rest
    return np.arange(0)


def _rest_around(
    images: NDArray[np.float32], place: int
) -> tuple[NDArray[np.int64], NDArray[np.bool_], float]:
    """Return the frames around one that look like it, those that differ most, and by how much.

    That is in grey levels (rms), without the noise of single frames.
    """
    around = slice(max(place - 2, 0), place + 3)
    for _ in range(2):
        # The second round compares with the middle of the rest, as `_leading_idle` does.
        change = _rms_from(np.median(images[around], axis=0), images)
        is_touched = change > split_in_two(change)[0]
        if is_touched[place] or not is_touched.any():
            return np.arange(0), is_touched, 0.0
        low, high = np.quantile(change[~is_touched], 0.25), np.median(change[is_touched])
        away = np.flatnonzero(change > low + REST_SHARE * (high - low))
        first = int(away[away < place].max(initial=-1)) + 1
        end = int(away[away > place].min(initial=len(images)))
        around = slice(first + (end - first) // 4, end - (end - first) // 4)
    rest = np.arange(first, end)
    apart = np.sqrt(max(high**2 - np.median(change[rest]) ** 2, 0.0))
    return rest, change >= high, float(apart)


REST_SHARE = 0.5
"""Share of the change up to which a gel rests: what creeps all the time is soon beyond it."""

LEADING_FRAMES = 4
"""Frames of a rest at the start of a recording of a gel with dots: a window of four shows none."""

REST_FRAMES = 18
"""Frames of a rest at the end of a recording or in its middle: a grip that opens a little and keeps
its object looks as if it had let go, for 16 frames at most in 61 real recordings of marked gels."""

CLEAR_TEXTURE = 0.9
"""Change between touched and idle frames' `texture`, grey levels (rms). Six real recordings of
noisy gels with dots have 2.2 to 3.1, twelve of clear ones 1.2 to 3.4."""

MARKED_LOST = 0.325
"""As of `LOST_SHARE`, by `texture_lost`. Twelve real recordings of clear gels with dots that begin
untouched have 0.1 or less, five of six noisy ones 0.11 to 0.32 (one 0.5: its pad moves as a whole).
Of those that do not, grips that open have 0.7 or more and most held objects 0.33 or more; three
that hardly show at all have 0.24 to 0.32, and are taken for idle."""

TEXTURE_SIGMAS, TEXTURE_GREY = (1.0, 4.0), 8.0
"""Pixels of the activity image between which texture is, and the grey levels it is cut to: the rim
of a lamp's light would outweigh all else when the pad moves."""


def texture(pictures: NDArray[np.generic]) -> NDArray[np.float32]:
    """Return what pictures show between dots, but for shading; both of shape (t, rows, columns, 3).

    They are `ACTIVITY_WIDTH` columns wide.
    """
    fine, coarse = TEXTURE_SIGMAS
    looks = []
    for picture in pictures:
        image = filled(picture.astype(np.float32))
        band = cv2.GaussianBlur(image, (0, 0), fine) - cv2.GaussianBlur(image, (0, 0), coarse)
        looks.append(np.clip(band, -TEXTURE_GREY, TEXTURE_GREY))
    return np.stack(looks)


def texture_lost(idle: NDArray[np.generic], touched: NDArray[np.generic]) -> float:
    """Return which share of the change of texture is texture of the idle frames that is gone.

    As `lost_share`, of pictures as of `texture`, where it changes most. Every other idle frame is
    compared with the others, so that their noise is not taken for texture.
    """
    averages = (idle[::2], idle[1::2], touched)
    one, other, later = texture(np.stack([part.mean(axis=0) for part in averages]))
    change = ((later - one) * (later - other)).sum(axis=-1)
    gone = -((later - one) * other + (later - other) * one).sum(axis=-1) / 2
    local = cv2.GaussianBlur(change, (0, 0), TEXTURE_SIGMAS[1])
    most = local >= np.quantile(local, 0.8)
    return float(gone[most].sum() / max(change[most].sum(), 1e-6))


def activity_colours(frames: NDArray[np.generic]) -> NDArray[np.float32]:
    """Return the frames in colour, `ACTIVITY_WIDTH` columns wide, shape (t, rows, columns, 3)."""
    return np.stack([shrunk(frame, ACTIVITY_WIDTH).astype(np.float32) for frame in frames])


def _leading_idle(grey: NDArray[np.float32]) -> int:
    """Return how many leading frames are idle; 0 when the clip does not start untouched."""
    reference, count = np.median(grey[:2], axis=0), len(grey)
    for _ in range(2):
        # The second round compares with frames just before the touch: cameras warm up and codecs
        # start sharp, which shifts the first frames by up to half of a faint imprint.
        change = _rms_from(reference, grey)
        threshold, gap = split_in_two(change)
        is_touched = change > threshold
        count = int(np.argmax(is_touched))
        if count < 2 or gap < CLEAR_CHANGE:
            return 0
        reference = np.median(grey[count // 2 : count], axis=0)
    return count if np.median(lost_share(reference, grey[is_touched])) < LOST_SHARE else 0


def lost_share(reference: NDArray[np.float32], later: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return which share of each image's change is structure of the reference that is gone.

    About 0 where something touches what was idle, 1 where what touched was lifted, 1/2 where it
    moved. All are of `activity_grey`.
    """
    before = _structure(reference[None])[0]
    added = _structure(later) - before
    change = np.maximum(np.square(added).sum(axis=(1, 2)), 1e-6)
    return -(added * before).sum(axis=(1, 2)) / change


CLEAR_CHANGE = 0.7
"""Grey levels (rms over the image) between touched and idle frames; idle ones differ by 0.2-0.9
among themselves, the faintest of 111 real touches by 0.5, the next by more than 0.8."""


def split_in_two(values: NDArray[np.float32]) -> tuple[float, float]:
    """Return the threshold between two groups of `values` (Otsu), and the gap of their means."""
    if len(values) < 2:
        return float("inf"), 0.0
    ordered = np.sort(values).astype(np.float64)
    below = np.arange(1, len(ordered))
    above = len(ordered) - below
    sums = np.cumsum(ordered)
    low, high = sums[:-1] / below, (sums[-1] - sums[:-1]) / above
    best = int(np.argmax(below * above * np.square(high - low)))
    return float(low[best] + high[best]) / 2, float(high[best] - low[best])


def _structure(grey: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.stack([frame - cv2.GaussianBlur(frame, (0, 0), STRUCTURE_SIGMA) for frame in grey])


STRUCTURE_SIGMA = 6.0
"""Pixels of the activity image: shading is smoother than this, imprints are not."""


BLOCK = 16
"""Frames looked at together: what they take stays in the processor's cache."""


def _rms_from(reference: NDArray[np.float32], grey: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return how far each image is from the reference but for its mean, grey levels (rms)."""
    blocks = (grey[start : start + BLOCK] - reference for start in range(0, len(grey), BLOCK))
    centred = (block - block.mean(axis=(1, 2), keepdims=True) for block in blocks)
    return np.concatenate([np.sqrt(np.square(block).mean(axis=(1, 2))) for block in centred])


def _powers(count: int) -> NDArray[np.float32]:
    """Return 1, s, s^2, ... for `count` points s in [-1, 1], shape (count, degree + 1)."""
    centres = (np.arange(count, dtype=np.float32) + 0.5) * 2 / count - 1
    return np.polynomial.legendre.legvander(centres, POLYNOMIAL_DEGREE).astype(np.float32)


NOISE_SIGMA, DOT_SIGMA, IMPRINT_SIGMA, SHADING_SIGMA = 1.0, 2.0, 8.0, 12.0
"""Pixels of the activity image (80 columns): finer is noise, coarser than 8 is a change of light,
and an imprint is finer than 12; a dot is as fine as 2."""

FAINT_IMPRINT = 0.75
"""Grey levels (rms) by which a touch changes the image, against a known background. Measured on
real recordings: 90 % of untouched frames are below 0.66, 95 % of those in contact above 0.8."""


GUESSED_IMPRINT = 1.6
"""The same against a gel that `estimate_background` guessed, and the least of which it tells that
something touches: the idle gel of 180 real recordings is 0.6 to 1.6 off its guess, in 171 of them
the touch, 1.5 in the median of the faintest quarter, 1.9 in the middle, 2.9 beyond the third."""


def shows_contact(grey: NDArray[np.float32], guess: Frames) -> bool:
    """Tell whether a guessed gel tells what touches it: of one with dots it never does.

    `grey` are the frames' `activity_grey`.
    """
    if is_marked(grey):
        return False
    return bool(np.median(strength_of(imprints_of(grey, guess))) >= GUESSED_IMPRINT)


def imprint_strength(clip: Clip) -> NDArray[np.float32]:
    """Return how strongly each frame is imprinted, in grey levels (rms), shape (t,)."""
    return strength_of(imprints_of(activity_grey(clip.frames), clip.background))


def touched_part(clip: Clip) -> Clip:
    """Return the part from the first touched frame to the last; all of it without a touch."""
    places = np.flatnonzero(imprint_strength(clip) >= FAINT_IMPRINT)
    if len(places) < 2:
        return clip
    return clip.select(list(range(int(places[0]), int(places[-1]) + 1)))


def imprints_of(grey: NDArray[np.float32], background: Frames | None) -> NDArray[np.float32]:
    """Return each grey frame's change against the gel, which is guessed where unknown."""
    if background is not None:
        gel = activity_grey(background[None])[0]
    else:
        gel = cv2.GaussianBlur(np.median(grey, axis=0), (0, 0), SHADING_SIGMA)
    return np.stack([band_pass(image - gel) for image in grey])


def band_pass(image: NDArray[np.float32], is_dotted: bool = False) -> NDArray[np.float32]:
    """Return an activity image without noise and without slow shading: what an imprint adds.

    Dots creep a little on a gel that nothing touches, and are smoothed away as well.
    """
    smooth = cv2.GaussianBlur(image, (0, 0), DOT_SIGMA if is_dotted else NOISE_SIGMA)
    return smooth - cv2.GaussianBlur(smooth, (0, 0), IMPRINT_SIGMA)


def strength_of(imprints: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return how strong each imprint is, in grey levels (rms), shape (t,)."""
    return np.sqrt(np.square(imprints).mean(axis=(1, 2)))
