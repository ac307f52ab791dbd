"""Whether pictures show a gel, and whether the camera moved: by what cannot move on a gel.

Lamps, rim and shading are fixed to the sensor, and what touches changes a part of the picture. So a
step of all of it is the camera's, and a scene whose pattern moves everywhere, is sharp everywhere,
or is there twice, is no gel. All is measured on pictures a few dozen pixels wide.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.numbers import quantile_by_rank
from geotlm_lm.recordings.legible import (
    DARK_GREY,
    DIM_GREY,
    MOST_BLACK,
    MOST_OFFSET_GREY,
    MOST_WHITE,
    WHITE_GREY,
)

Floats = NDArray[np.float32]
Shift = NDArray[np.float64]

STEP_SIZE = (40, 30)
"""Columns and rows that steps of the whole picture are measured at."""

STEP_SIGMA = 1.5
"""Blur there, pixels: markers, which gels move, vanish, and shading and rim stay."""

LEAST_STEP, MOST_SHIFT = 0.12, 4.0
"""Smallest step and largest shift that are taken out, pixels of 40: 2 and 64 of 640."""

LEAST_CHANGE = 0.6
"""Median squared change of a pixel, of all colours, below which nothing is fitted: a step of 2 px
of 640 makes 0.65 or more, nineteen in twenty steps of real recordings less than 0.7."""

EXPLAINED, EXPLAINED_QUARTER = 0.65, 0.4
"""Share of the change that one shift explains, of all of the picture as of its rim, and of each
quarter at the least. Of 9,594 sampled steps of real recordings none counts by these bounds, of all
steps of 434 recordings one does; of 540 pictures of two GelSight sets shifted by 2 to 30 px of 640
do 527, of 36 of a GelSlim 30."""

LEAST_LINEAR = 0.2
"""Share of the change that the first of four steps of the fit must explain, to save the others."""

RETURNED = 0.25
"""Share of a jump that may be left of it when the picture is back in its place."""

LOOKED_AT = ((8, 1), (40, 4), (1 << 62, 16))
"""Frames up to which, and how many of them apart, the scene is looked at: closely at first."""

SCENE_COLUMNS, BLOCK_PX = 80, 10
"""Width a scene is looked at, and side of a block whose pattern is followed there."""

MOST_STRUCTURE = 19.0
"""Grey levels (rms) of structure, markers closed, of a first picture of a gel at most: 12.3 on 434
real recordings, 17.8 if any of their frames were the first; photographs have 21 or more."""

PATTERN_GREY, LEAST_PATTERNED = 2.0, 0.25
"""Contrast of a block from which on its pattern is followed, and share of blocks that need it."""

LOST_CORRELATION, MOST_LOST, MOST_LOST_SHARE, FEWEST_LOOKS = 0.5, 0.7, 0.35, 8
"""A block's pattern is lost below this correlation with the first picture; a frame's is where so
many blocks' are, of the picture and of its rim. One real recording has 0.29 such frames, the next
0.10 (434); moving scenes and papers 0.19 to 0.97, 0.6 in the median."""

FEWEST_STEPS, MOST_STEPS = 8, 0.1
"""Steps of the whole picture, and their share of the frames, from which on it is a moving scene's:
one of 434 real recordings has one."""

TWICE, LEAST_TWICE_GREY, FEWEST_TWICE = 0.92, 0.7, 3
"""Correlation of two halves, of the first picture's structure as of its changes, markers closed,
from which on both show the same, grey levels (rms) of change that tell, and looks. On 434
recordings the structure's is 0.92 at most and never both; of doubled ones both are
0.93 or more."""

LONGEST_OFF = 15
"""First or last frames that are left out where they are exposed unlike all others."""

MOST_NOTES = 3
"""Jumps that are named one by one."""

NOT_A_GEL = "These pictures do not look like a gel's"
SHARP = f"{NOT_A_GEL}: sharp structure fills the untouched picture, as of a room or a screen."
MOVING = f"{NOT_A_GEL}: the pattern moves everywhere, up to the rim, as of a scene or a print."
DOUBLED = f"{NOT_A_GEL} seen once: two halves of the picture show the same, as through a mirror."


@dataclass(frozen=True)
class Jump:
    """Frames in which the whole picture lies elsewhere than in the first ones."""

    first: int  # frame numbers, both included
    last: int
    right_px: float  # of the frame as recorded
    down_px: float

    def note(self) -> str:
        """Return a sentence about it."""
        far = round(float(np.hypot(self.right_px, self.down_px)))
        return (
            f"The whole picture moves by {far} px in frames {self.first} to {self.last}, lights "
            f"and rim with it: the camera moved, not the object."
        )


@dataclass(frozen=True)
class SceneReport:
    """What was noticed about a recording as a picture of a gel."""

    jumps: tuple[Jump, ...] = ()
    suspicion: str = ""  # one sentence why it is no gel; "" of a gel
    blank: int = 0  # frames that show nothing of the gel

    @property
    def notes(self) -> tuple[str, ...]:
        """One sentence each; of many jumps the first ones."""
        if self.suspicion:
            return (self.suspicion,)
        more = len(self.jumps) - MOST_NOTES
        many = [f"It moves so {more} times more."] if more > 0 else []
        blank = (
            [f"{self.blank} frames show no picture of the gel and are left out."]
            if self.blank
            else []
        )
        return (*blank, *(jump.note() for jump in self.jumps[:MOST_NOTES]), *many)

    def steadied(self, clip: Clip) -> Clip:
        """Return a clip with its jumps taken out and without blank frames."""
        clip = without_blank(clip) if self.blank else clip
        if not self.jumps:
            return clip
        frames, gel = clip.frames.copy(), clip.background
        for place, number in enumerate(clip.frame_numbers):
            for jump in self.jumps:
                if jump.first <= number <= jump.last:
                    frames[place] = _moved_back(frames[place], jump, gel)
        return replace(clip, frames=frames)


class SceneChecker:
    """Looks at the frames of one recording in their order.

    Args:
        idle: The untouched gel as it was seen, uint8 RGB, where that is known: the first frame may
            then be moved too.
    """

    def __init__(self, idle: Frames | None = None) -> None:
        self._count = self._blank = self._steps = 0
        self._before = None if idle is None else blurred(small_frame(idle))
        self._shift: Shift = np.zeros(2)
        self._jumps: list[Jump] = []
        self._first: _Look | None = None
        self._lost: list[tuple[bool, int]] = []  # each with the frames that the look stands for
        self._waiting: list[tuple[Frames, int]] = []  # frames that nothing is told from yet
        self._twice: list[Floats] = []

    @property
    def report(self) -> SceneReport:
        """What was noticed so far."""
        return SceneReport(tuple(self._jumps), self._suspicion(), self._blank)

    def steadied(
        self, frame: Frames, number: int, idle_of: Callable[[], Frames | None] = lambda: None
    ) -> Frames | None:
        """Take in the next frame; return it where the first ones lie, or None where it is blank.

        What was out of the picture is filled in from the idle gel, which `idle_of` returns where it
        is known, else from the picture's edge.
        """
        few = small_frame(frame)
        if _is_blank(few):
            self._blank += 1
            return None
        self.take(frame, few, number)
        if not self._shift.any():
            return frame
        return _moved_back(frame, self._jumps[-1], idle_of())

    def take(self, frame: Frames, few: Frames, number: int) -> None:
        """Take in the next frame, which is not blank, and the same in `STEP_SIZE`."""
        few = blurred(few)
        step = None if self._before is None else whole_step(self._before, few)
        self._before = few
        if step is not None:
            self._jump(step, frame, number)
        apart = next(apart for end, apart in LOOKED_AT if self._count < end)
        if self._count % apart == 0:
            self._look(frame, apart)
        self._count += 1
        if self._shift.any():
            self._jumps[-1] = replace(self._jumps[-1], last=number)

    def _jump(self, step: Shift, frame: Frames, number: int) -> None:
        self._steps += 1
        shift, far = self._shift + step, max(np.hypot(*self._shift), np.hypot(*step))
        is_back = np.hypot(*shift) < RETURNED * far or np.hypot(*shift) > MOST_SHIFT
        is_back = is_back or self._is_panned
        self._shift = np.zeros(2) if is_back else shift
        if not is_back:
            scale = np.array(frame.shape[1::-1]) / STEP_SIZE
            self._jumps.append(Jump(number, number, *map(float, shift * scale)))

    @property
    def _is_panned(self) -> bool:
        return self._steps >= FEWEST_STEPS and self._steps > MOST_STEPS * self._count

    def _look(self, frame: Frames, apart: int) -> None:
        if self._first is not None and not self._first.tells:
            self._lost.append((False, apart))
            return
        if self._first is None:
            self._first = _Look(_scene_size(frame))
            return
        self._waiting.append((frame, apart))
        if len(self._lost) + len(self._waiting) >= FEWEST_LOOKS:
            self._lost += [
                (self._first.is_lost(_scene_size(seen)), stands) for seen, stands in self._waiting
            ]
            self._waiting.clear()
        if self._first.alike.max() > TWICE:
            change = _band(_unmarked(_scene_size(frame)), 0.8, 4.0) - self._first.plain
            if np.square(change).mean() > LEAST_TWICE_GREY**2:
                self._twice.append(_halves_alike(change))

    def _suspicion(self) -> str:
        if self._first is not None and self._first.structure_grey > MOST_STRUCTURE:
            return SHARP
        lost, stands_for = np.array([*self._lost, (0, 0)]).T
        is_lost = lost @ stands_for > MOST_LOST_SHARE * stands_for.sum()
        if self._is_panned or (len(self._lost) >= FEWEST_LOOKS and is_lost):
            return MOVING
        if len(self._twice) >= FEWEST_TWICE:
            alike = np.minimum(np.median(self._twice, axis=0), self._first.alike)
            return DOUBLED if alike.max() > TWICE else ""
        return ""


def scene_of(clip: Clip, idle: Frames | None = None) -> SceneReport:
    """Return what is noticed about a clip in memory; `idle` as of `SceneChecker`."""
    checker, few = SceneChecker(idle), [small_frame(frame) for frame in clip.frames]
    kept = _exposed_alike(few)
    for place in kept:
        checker.take(clip.frames[place], few[place], clip.frame_numbers[place])
    return replace(checker.report, blank=len(clip) - len(kept))


def without_blank(clip: Clip) -> Clip:
    """Return a clip without blank frames, nor the few first and last ones exposed unlike others.

    All of it where fewer than two frames are left.
    """
    kept = _exposed_alike([small_frame(frame) for frame in clip.frames])
    return clip if len(kept) == len(clip) else clip.select(kept)


def _exposed_alike(few: list[Frames]) -> list[int]:
    """Return the places of the frames that `without_blank` keeps, of all in `STEP_SIZE`."""
    every, blank = list(range(len(few))), np.array([_is_blank(frame) for frame in few])
    level = np.array([frame[..., 1].mean() for frame in few])
    if blank.all():
        return every
    usual = np.sort(level[~blank])[(~blank).sum() // 2]  # that of some frame
    is_off = np.abs(level - usual) > MOST_OFFSET_GREY
    alike = np.flatnonzero(~blank & ~is_off)
    # A longer run is an exposure that was locked late, and is followed.
    first = alike[0] if alike[0] <= LONGEST_OFF else 0
    last = alike[-1] if len(few) - 1 - alike[-1] <= LONGEST_OFF else len(few) - 1
    is_off[first : last + 1] = False
    kept = np.flatnonzero(~blank & ~is_off).tolist()
    return kept if len(kept) > 1 else every


def _is_blank(few: Frames) -> bool:
    """Tell whether a frame shows nothing: black, dim or white, as a capped or blinded lens does."""
    level = np.maximum(np.maximum(few[..., 0], few[..., 1]), few[..., 2])
    least, most = MOST_BLACK * level.size, MOST_WHITE * level.size
    is_dark = (level <= DARK_GREY).sum() > least or (level < DIM_GREY).sum() > level.size / 2
    return bool(is_dark or (level >= WHITE_GREY - 1).sum() > most)


def _moved_back(frame: Frames, jump: Jump, idle: Frames | None) -> Frames:
    shift = np.array([jump.right_px, jump.down_px])
    moved = warped(frame, shift)
    if idle is None:
        return moved
    rows, columns = frame.shape[:2]
    y, x = np.arange(rows)[:, None] + shift[1], np.arange(columns) + shift[0]
    is_out = (x < 0) | (x > columns - 1) | (y < 0) | (y > rows - 1)
    moved[is_out] = idle[is_out]
    return moved


@dataclass(frozen=True, eq=False)
class _Look:
    """The first picture, `SCENE_COLUMNS` wide, as later ones are compared with it."""

    small: Frames

    @cached_property
    def fine(self) -> Floats:
        """Pattern without noise and shading, the mean of all colours."""
        return _grey_band(self.small)

    @cached_property
    def plain(self) -> Floats:
        """All colours without markers, a grid of which is there as often as one likes."""
        return _band(self._unmarked, 0.8, 4.0)

    @cached_property
    def structure_grey(self) -> float:
        """Rms of what is coarser than markers and finer than shading."""
        return float(np.sqrt(np.square(_band(self._unmarked, 1.0, 8.0)).mean()))

    @cached_property
    def blocks(self) -> Floats:
        """Mean square of the grey pattern in each block."""
        return _in_blocks(np.square(self.fine))

    @cached_property
    def alike(self) -> Floats:
        """How one half of the pattern resembles the other, markers left out."""
        return _halves_alike(self.plain)

    @cached_property
    def _unmarked(self) -> Frames:
        return _unmarked(self.small)

    @cached_property
    def _rim(self) -> NDArray[np.bool_]:
        rim = np.ones(self.blocks.shape, bool)
        rim[1:-1, 1:-1] = False
        return rim

    @cached_property
    def is_patterned(self) -> bool:
        """Whether enough blocks, of the rim too, have a pattern to be followed."""
        strong = self.blocks > PATTERN_GREY**2
        return min(strong.mean(), strong[self._rim].mean()) >= LEAST_PATTERNED

    @cached_property
    def tells(self) -> bool:
        """Whether later looks can tell anything."""
        return self.is_patterned or bool(self.alike.max() > TWICE)

    def is_lost(self, later: Frames) -> bool:
        """Tell whether most of its pattern is gone from a later picture, at the rim too."""
        if not self.is_patterned:
            return False
        is_patterned, rim = self.blocks > PATTERN_GREY**2, self._rim
        grey = _grey_band(later)
        alike = _in_blocks(self.fine * grey)
        is_gone = alike / np.sqrt(self.blocks * _in_blocks(grey * grey) + 1e-6) < LOST_CORRELATION
        return min(is_gone[is_patterned].mean(), is_gone[is_patterned & rim].mean()) >= MOST_LOST


def _scene_size(frame: Frames) -> Frames:
    rows = max(round(frame.shape[0] * SCENE_COLUMNS / frame.shape[1]), 2 * BLOCK_PX)
    return cv2.resize(frame, (SCENE_COLUMNS, rows), interpolation=cv2.INTER_AREA)


def _unmarked(small: Frames) -> Frames:
    dots = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (7, 7))
    return cv2.morphologyEx(small, cv2.MORPH_CLOSE, dots)


def _band(picture: NDArray, fine: float, coarse: float) -> Floats:
    smooth = cv2.GaussianBlur(picture.astype(np.float32), (0, 0), fine)
    return smooth - cv2.GaussianBlur(smooth, (0, 0), coarse)


def _grey_band(picture: Frames) -> Floats:
    red, green, blue = cv2.split(picture.astype(np.float32))
    return _band((red + green + blue) / 3, 0.8, 4.0)


def _in_blocks(picture: Floats) -> Floats:
    rows, columns = (side // BLOCK_PX for side in picture.shape)
    whole = picture[: rows * BLOCK_PX, : columns * BLOCK_PX]
    return cv2.resize(whole, (columns, rows), interpolation=cv2.INTER_AREA)


def _halves_alike(pattern: Floats) -> Floats:
    """Return how one half resembles the other, mirrored and not, across and down, (4,)."""
    alike, edge = [], 2
    for picture in (pattern, pattern.transpose(1, 0, 2)):
        half = picture.shape[1] // 2
        part = np.ascontiguousarray(picture[edge:-edge, edge : half - edge])
        for other in (picture[:, ::-1][:, :half], picture[:, -half:]):
            score = cv2.matchTemplate(np.ascontiguousarray(other), part, cv2.TM_CCOEFF_NORMED)
            alike.append(float(score.max()))
    return np.array(alike, np.float32)


def whole_step(before: Floats, after: Floats) -> Shift | None:
    """Return by how much all of a picture moved, right and down, pixels; None if it did not.

    Both are `STEP_SIZE`, colours, blurred. Least squares, pixels that do not fit down-weighted.
    """
    change = (after - before)[::2, ::2]
    change = np.square(change - change.mean(axis=(0, 1))).sum(axis=-1)
    if min(map(quantile_by_rank, (change, change[:, [0, 1, -2, -1]]))) < LEAST_CHANGE:
        return None
    shift, inner = np.zeros(2), slice(3, -3)
    weight: NDArray = np.ones(1)
    for _ in range(4):
        moved = warped(after, shift)
        across, down = (cv2.Sobel(moved, -1, *way, scale=1 / 8) for way in ((1, 0), (0, 1)))
        slopes = np.stack([across, down], axis=-1)[inner, inner]
        off = _centred((before - moved)[inner, inner])
        weighted = slopes * weight[..., None, None]
        normal = np.einsum("rcki,rckj->ij", weighted, slopes) + 1e-3 * np.eye(2)
        pull = np.einsum("rcki,rck->i", weighted, off)
        step = np.linalg.solve(normal, pull)
        error = np.square(off).sum(axis=-1)
        if not shift.any() and step @ pull < LEAST_LINEAR * error.sum():
            return None
        shift += np.clip(step, -2, 2)
        weight = 1 / np.square(1 + error / max(2 * np.median(error), 0.5))
    far = float(np.hypot(*shift))
    if not LEAST_STEP <= far <= MOST_SHIFT:
        return None
    return shift if _is_explained(before, after, shift) else None


def _is_explained(before: Floats, after: Floats, shift: Shift) -> bool:
    """Tell whether a shift explains the change of the picture, of its rim and of each quarter."""
    edge = 3 + int(np.ceil(np.abs(shift).max()))
    inner = slice(edge, -edge)
    was, left = (
        np.square(_centred((before - picture)[inner, inner])).sum(axis=-1)
        for picture in (after, warped(after, shift))
    )
    rows, columns = (np.arange(side) * 2 // side for side in was.shape)
    quarters = [np.ix_(rows == r, columns == c) for r in (0, 1) for c in (0, 1)]
    rim = np.ones(was.shape, bool)
    rim[3:-3, 3:-3] = False
    if min(1 - left.sum() / was.sum(), _fell(was[rim], left[rim])) < EXPLAINED:
        return False
    return min(_fell(was[part], left[part]) for part in quarters) >= EXPLAINED_QUARTER


def _fell(was: Floats, left: Floats) -> float:
    return 1 - float(np.median(left)) / max(float(np.median(was)), 1e-3)


def _centred(change: Floats) -> Floats:
    """Return a change of colours without that of the exposure."""
    return change - np.median(change.reshape(-1, 3), axis=0)


def small_frame(frame: Frames) -> Frames:
    """Return a frame in `STEP_SIZE`."""
    # Every other row tells as much: four of them make one.
    frame = frame[:: max(frame.shape[0] // (4 * STEP_SIZE[1]), 1)]
    return cv2.resize(frame, STEP_SIZE, interpolation=cv2.INTER_AREA)


def blurred(few: Frames) -> Floats:
    """Return a small frame as steps are measured in it, float32."""
    return cv2.GaussianBlur(few.astype(np.float32), (0, 0), STEP_SIGMA)


def warped(picture: Floats, shift: Shift) -> Floats:
    """Return a picture moved back by a shift, its edge continued."""
    matrix = np.array([[1, 0, shift[0]], [0, 1, shift[1]]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = picture.shape[1::-1]
    return cv2.warpAffine(picture, matrix, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
