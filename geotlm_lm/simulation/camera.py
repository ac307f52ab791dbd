"""What a camera records: the untouched gel's light, noise, and what storing frames loses.

An idle frame is smooth coloured light, specks and a fixed pattern. Noise of unit strength, a
camera's or a video codec's, is cropped from large banks. Everything random comes from generators.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.simulation.scene import CENTRED, GELSIGHT_MINI, Lamps, Mounting, Optics

Planar = NDArray[np.float32]

FIXED_PATTERN_GREY = (0.85, 0.7, 1.0)
"""Standard deviation of the pixel-fine pattern that two sessions share, measured (R, G, B)."""

CHANNEL_GAIN = ((0.75, 1.12), (0.87, 1.15), (0.87, 1.15))
"""Brightness of each channel relative to the measured unit, R, G, B: mean levels of four real units
and sessions are 56 to 83, 95 to 104 and 105 to 119."""

OFFSET_GREY = ((-6.5, 3.5), (-5.0, 5.0), (-3.5, 6.5))
"""Offset of each channel, R, G, B; corners are 20 to 28, 61 to 71 and 47 to 52 % of the middle."""

USUAL_TILT = ((0.0, 0.0, 0.01), (0.0, 0.02, 0.04))
"""Relative growth of R, G, B per half view to the right and downwards, from the unit whose levels
are tabled to the usual one: the blue of four sources falls by 17 to 21 % from the upper to the
lower half and by 0 to 5 % from left to right."""

WHITE_BALANCE = (0.94, 1.06)
"""Brightness of each channel where all are the same light. Assumed: a camera's is set by hand."""

SMOOTH_CHANGE = 0.08
"""Spread of the coefficients of the relative change of each channel, a quadratic over the view;
real units and sessions differ by less."""

PATTERN_SHARE = (0.3, 0.8)
"""Strength of the fixed pattern relative to `FIXED_PATTERN_GREY`; resizing wears it down."""

CROP = (0.93, 1.0)
"""Share of the lit field that is in view, along each axis; readers of one sensor crop differently.

It does not follow the pixel size: lights stand at the rim of a sensor's own view."""

VIGNETTE = (0.0, 0.4)
"""Share of the light that the lens loses in the corners, all channels alike."""

FINER_FIELD_GREY = ((1.0, 5.5), (0.6, 2.0), (0.7, 3.0))
"""RMS of the field of degrees 5 and 6 of each channel, R, G, B; measured on 30 recordings and two
sets of stills: 2.5 to 6.1, 1.0 to 1.5 and 1.9 to 4.3."""

FINEST_FIELD_SHARE = (0.3, 0.6)
"""RMS of the field of degrees 7 and 8 relative to degrees 5 and 6: measured 0.4 to 1."""

_NODES = np.linspace(-1, 1, 5)

_NODE_TERMS = np.linalg.inv(np.vander(_NODES))
"""Coefficients of the polynomials that are 1 at one of the even points, 0 at the others."""

_CHANGE_X, _CHANGE_Y = np.meshgrid(_NODES, _NODES)
_CHANGE_TERMS = np.stack(
    [_CHANGE_X, _CHANGE_Y, _CHANGE_X * _CHANGE_Y, _CHANGE_X**2 - 0.5, _CHANGE_Y**2 - 0.5]
)
"""The quadratic of `SMOOTH_CHANGE`, term by term on the even points, (5, 5, 5)."""

_FIELD_NODES = np.cos(np.pi * (np.arange(13) + 0.5) / 13)
"""Points per axis that carry exactly a field of degree 8 times a vignette of degree 4."""

_VIGNETTE = (_FIELD_NODES[:, None] ** 2 + _FIELD_NODES**2) ** 2 / 4

_HALF_VIEW_MM = (10.15, 7.6)
"""Half the view (x, y) that the idle frame was measured on."""

DARK_SHARE = 0.75
"""Share of specks that are dark."""

_SPECK_REACH_PX = 16
"""Farthest a speck changes the image from its middle: its radius and the reach of its blur."""

BANK_PIXELS = 1024**2
"""Numbers in the bank, in one line; a crop begins at one of 998,400 places and lies in one piece:
a window of a square bank, a page of memory per row, takes two and a half times as long to read."""

BANK_SEED = 20260101

CODED_ROWS = 1200
"""Rows of the codec's bank, as wide as an image; its crops begin at one of 218,624 places."""

CODED_BLUR_PX = 1.7
"""Blotches of a codec's noise, standard deviation of a Gaussian: neighbours correlate to 0.92, and
to the measured 0.56 once only what exceeds half a grey level is left."""

CODED_SHARED = 0.87
"""Share of that noise's variance that all channels have in common; the measured correlation of R
and B is 0.48 once rounded."""

BACKGROUND_NOISE = 0.45
"""Noise of an idle frame averaged over about five frames, relative to one frame's."""

WHOLE_EVERY = 12
"""Frames of a video from one stored whole to the next (measured on MPEG-4 recordings)."""

DRIFT_LIMIT_GREY = 1.0
"""Largest change of white balance between frames, per channel."""


def idle_frame(seed: int, mounting: Mounting = CENTRED, lamps: Lamps = GELSIGHT_MINI) -> Planar:
    """Return an idle frame, float32 planar (3, 224, 224) RGB grey levels, without temporal noise.

    Randomly changed measured levels, a polynomial of degree 4 per axis, and a random field of
    degrees 5 to 8; never mirrored, since which colour lights which side tells directions apart.
    """
    rng = np.random.default_rng(seed)
    gain = np.array([rng.uniform(*span) for span in CHANNEL_GAIN])[:, None, None]
    offset = np.array([rng.uniform(*span) for span in OFFSET_GREY])[:, None, None]
    change = rng.normal(0, SMOOTH_CHANGE, (3, 5))
    change[:, :2] += np.transpose(USUAL_TILT)
    table = (lamps.levels * gain + offset) * np.exp(np.einsum("ck,kij->cij", change, _CHANGE_TERMS))
    crop = rng.uniform(*CROP)
    nodes = _lit_at_nodes(table, mounting, crop) + _finer_field(rng)
    if lamps.is_white:
        nodes = nodes[:1] * rng.uniform(*WHITE_BALANCE, (3, 1, 1))
    nodes *= 1 - rng.uniform(*VIGNETTE) * _VIGNETTE
    frame = _at_pixels(nodes)
    frame *= _specks(rng)
    for channel, sigma in enumerate(FIXED_PATTERN_GREY):
        strength = sigma * rng.uniform(*PATTERN_SHARE)
        cv2.scaleAdd(unit_noise(rng), strength, frame[channel], dst=frame[channel])
    return np.clip(frame, 2, 250, out=frame)


def _lit_at_nodes(table, mounting: Mounting, crop: float) -> NDArray[np.float64]:
    """Return the lit field where the field's nodes see the pad, (3, 13, 13)."""
    half_x, half_y = _HALF_VIEW_MM
    x = _FIELD_NODES[None, :] * half_x * crop - mounting.x_mm
    y = _FIELD_NODES[:, None] * half_y * crop - mounting.y_mm
    cos, sin = np.cos(mounting.turn_rad), np.sin(mounting.turn_rad)
    across, down = (cos * x + sin * y) / half_x, (cos * y - sin * x) / half_y
    weights = [np.vander(points.ravel(), 5) @ _NODE_TERMS for points in (down, across)]
    lit = np.einsum("pi,cij,pj->cp", weights[0], table, weights[1])
    return lit.reshape(3, *across.shape)


def _finer_field(rng: np.random.Generator) -> NDArray[np.float64]:
    """Return a random field of degrees 5 to 8 in grey levels at the field's nodes, (3, 13, 13)."""
    finer = np.array([rng.uniform(*span) for span in FINER_FIELD_GREY])
    sizes = finer[:, None] * np.array([1.0, rng.uniform(*FINEST_FIELD_SHARE)])
    field = np.zeros((3, *_VIGNETTE.shape))
    for band, terms in enumerate(_finer_terms()):
        share = rng.normal(0, 1 / np.sqrt(len(terms)), (3, len(terms)))
        field += sizes[:, band, None, None] * np.einsum("ct,tij->cij", share, terms)
    return field


@cache
def _finer_terms() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return Legendre products of total degree 5 and 6, and 7 and 8, RMS 1, at the nodes."""
    legendre = np.polynomial.legendre.legvander(_FIELD_NODES, 8).T
    legendre *= np.sqrt(2 * np.arange(9) + 1)[:, None]
    bands = []
    for degrees in ((5, 6), (7, 8)):
        pairs = [(i, d - i) for d in degrees for i in range(d + 1)]
        bands.append(np.stack([np.outer(legendre[i], legendre[j]) for i, j in pairs]))
    return bands[0], bands[1]


def _at_pixels(nodes: NDArray[np.float64]) -> Planar:
    """Return the images (3, 224, 224) of fields at the nodes."""
    upsample = _upsample()
    # One matrix at a time: a batch of small products costs twice as much.
    frame = torch.empty(len(nodes), IMAGE_SIDE, IMAGE_SIDE)
    for field, out in zip(torch.from_numpy(nodes.astype(np.float32)), frame, strict=True):
        torch.mm(upsample @ field, upsample.T, out=out)
    return frame.numpy()


@cache
def _upsample() -> torch.Tensor:
    """Return the weights (224, 13) of polynomial interpolation from the field's nodes to pixels."""
    pixels = (np.arange(IMAGE_SIDE) + 0.5) / (IMAGE_SIDE / 2) - 1
    count = len(_FIELD_NODES)
    weights = np.vander(pixels, count) @ np.linalg.inv(np.vander(_FIELD_NODES))
    return torch.from_numpy(weights.astype(np.float32))


def _specks(rng: np.random.Generator) -> Planar:
    """Return the factor of 0 to 6 dark or bright specks: dust, bubbles, scratches in the paint."""
    factor = np.ones((IMAGE_SIDE, IMAGE_SIDE), np.float32)
    for _ in range(int(rng.integers(0, 7))):
        column, row = (int(v) for v in rng.integers(4, IMAGE_SIDE - 4, 2))
        sign = -1 if rng.random() < DARK_SHARE else 1
        strength = sign * rng.uniform(0.1, 0.6)
        # Blurred alone: the whole image costs twenty times as much.
        left, top = max(column - _SPECK_REACH_PX, 0), max(row - _SPECK_REACH_PX, 0)
        around = factor[top : row + _SPECK_REACH_PX + 1, left : column + _SPECK_REACH_PX + 1]
        spot = np.zeros(around.shape, np.float32)
        radii = tuple(int(v) for v in rng.integers(0, 4, 2))
        angle = float(rng.uniform(0, 180))
        cv2.ellipse(spot, (column - left, row - top), radii, angle, 0, 360, strength, -1)
        around += cv2.GaussianBlur(spot, (0, 0), float(rng.uniform(0.5, 1.2)))
    return cv2.max(factor, 0.2, dst=factor)


def unit_noise(rng: np.random.Generator) -> Planar:
    """Return white noise of standard deviation 1, float32 (224, 224), read-only."""
    return _crop(_bank(), rng)[0]


def coded_noise(rng: np.random.Generator) -> Planar:
    """Return noise as a video codec leaves it, float32 (3, 224, 224), read-only.

    Standard deviation 1; neighbouring pixels and the channels are alike.
    """
    return _crop(_coded_bank(), rng)


def _crop(bank: Planar, rng: np.random.Generator) -> Planar:
    """Return images (planes, 224, 224) from a random place of a bank of lines (planes, numbers)."""
    start = int(rng.integers(bank.shape[1] - IMAGE_SIDE**2))
    return bank[:, start : start + IMAGE_SIDE**2].reshape(-1, IMAGE_SIDE, IMAGE_SIDE)


@cache
def _coded_bank() -> Planar:
    rng = np.random.default_rng(BANK_SEED + 1)
    sigma, soft = {"sigmaX": CODED_BLUR_PX, "sigmaY": CODED_BLUR_PX}, []
    for white in rng.standard_normal((4, CODED_ROWS, IMAGE_SIDE), dtype=np.float32):
        columns = cv2.GaussianBlur(white, (1, 0), **sigma)
        # In one line, a row goes on in the next: an image begins anywhere.
        soft.append(cv2.GaussianBlur(columns.reshape(1, -1), (0, 1), **sigma)[0])
    soft = np.stack(soft)
    soft /= soft.std(axis=1, keepdims=True)
    bank = np.sqrt(CODED_SHARED) * soft[:1] + np.sqrt(1 - CODED_SHARED) * soft[1:]
    bank = bank.astype(np.float32)
    bank.setflags(write=False)
    return bank


@cache
def _bank() -> Planar:
    bank = np.random.default_rng(BANK_SEED).standard_normal((1, BANK_PIXELS), dtype=np.float32)
    bank.setflags(write=False)
    return bank


class Recorder:
    """Records the frames of one clip in order; everything random comes from one generator."""

    def __init__(self, optics: Optics, rng: np.random.Generator) -> None:
        self.optics, self.rng = optics, rng
        self._still: Planar | None = None

    def background(self, idle: Planar) -> NDArray[np.uint8]:
        """Return the idle frame as recorded before the touch; averaging wears its noise down."""
        if self.optics.video is None:
            return self._recorded(idle, noise_share=BACKGROUND_NOISE)
        # Noise that stands still does not average out.
        return self._recorded(idle, still=coded_noise(self.rng))

    def next(self, frame: Planar) -> NDArray[np.uint8]:
        """Return the clip's next frame as recorded, uint8 (224, 224, 3)."""
        rng, video = self.rng, self.optics.video
        drift = rng.normal(0, self.optics.drift_grey, 3).clip(-DRIFT_LIMIT_GREY, DRIFT_LIMIT_GREY)
        if video is not None:
            is_whole = rng.random() < video.frames_apart / WHOLE_EVERY
            if is_whole or self._still is None:
                self._still = coded_noise(rng)
        return self._recorded(frame, drift_grey=drift.tolist(), still=self._still)

    def _recorded(
        self,
        frame: Planar,
        *,
        noise_share: float = 1.0,
        drift_grey: Sequence[float] = (0.0, 0.0, 0.0),
        still: Planar | None = None,
    ) -> NDArray[np.uint8]:
        """Return what the recording holds of a planar frame, 8 bit, perhaps lossy.

        The noise is `noise_share` of one frame's. In a video, `still` is planar noise of unit
        strength that the last frame stored whole has left.
        """
        rng, video = self.rng, self.optics.video
        fresh = None if video is None else coded_noise(rng)
        planes = []
        for channel, plane in enumerate(frame):
            if video is None:
                noise, sign = unit_noise(rng), 1 if rng.random() < 0.5 else -1
                share = sign * noise_share * self.optics.noise_grey[channel]
            else:
                noise, share = fresh[channel], video.predicted_grey[channel]
                plane = cv2.addWeighted(still[channel], video.whole_grey[channel], plane, 1.0, 0.0)
                # A block that changes too little is copied: whole levels are added to whole ones.
                np.rint(plane, out=plane)
            # One pass for sum, rounding and clipping: a third of the time of five.
            level = drift_grey[channel]
            planes.append(cv2.addWeighted(noise, share, plane, 1.0, level, dtype=cv2.CV_8U))
        if self.optics.jpeg_quality is None:
            return cv2.merge(planes)
        bgr = cv2.merge(planes[::-1])
        code = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, self.optics.jpeg_quality])
        return cv2.imdecode(code[1], cv2.IMREAD_COLOR_RGB)
