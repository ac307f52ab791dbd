"""Cases made of real recordings: untouched gels, and real imprints moved by a known slide.

A semi-real slide keeps the imprint, texture and optics of a real touch: its change against the idle
gel is carried over that gel by a known path, and fresh noise is added. What it lacks is the change
of lighting from place to place and the gel's creep. No table pools these clips with others.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.benchmarks.judging import Case
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import SLIDES, Motion, reverse
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.data.touch_table import TouchRow
from geotlm_lm.recordings.read import read_clip

TRAVEL_SHARE, SIDEWAYS_SHARE, TURN_DEG = (0.02, 0.12), 0.4, 2.0
"""Travel relative to the width of the view, 0.4 to 2.4 mm of a GelSight Mini's 20 mm; travel across
it at most, relative to it; and turn on the way at most: hands never slide quite straight."""

NOISE_GREY = 0.4
"""Fresh noise of each frame; the recordings' own, after their codec, is 0.25 to 0.4 grey levels."""

BORDER_SHARE, MOST_AT_BORDER = 0.05, 0.35
"""Width of the image's border relative to its width, and RMS change there relative to the whole
image's, above which an imprint is cut off: moved, its straight cut would be seen."""

LEAST_CHANGE_GREY, PRESS_FROM = 1.5, 0.25
"""RMS change over the image below which there is no imprint worth moving, and strength a press
begins at, relative to the recorded touch."""

_TOWARDS = {Motion.LEFT: (-1, 0), Motion.RIGHT: (1, 0), Motion.UP: (0, -1), Motion.DOWN: (0, 1)}


def untouched_cases(rows: Iterable[TouchRow]) -> Iterator[Case]:
    """Yield four of each recording's first frames, before anything touches."""
    for row in rows:
        yield touched_case(row, row.surely_idle, Motion.NONE)


def touched_case(row: TouchRow, numbers: Sequence[int], motion: Motion) -> Case:
    """Return four of some frames of a recording, evenly, beside its idle gel."""
    frames, idle = read_touched(row)
    shown = frames[evenly(numbers)]
    clip = Clip(shown, fps=row.fps, background=as_image(idle), name=row.path.name)
    return Case(clip, motion, row.object_id, row.object_family)


def evenly(numbers: Sequence[int]) -> list[int]:
    """Return four frame numbers from the first to the last of some."""
    return np.linspace(numbers[0], numbers[-1], FRAME_COUNT).round().astype(int).tolist()


@dataclass
class SemiRealSlides:
    """One slide of each imprint that lies within the view, forwards and backwards.

    The four ways come in turn; `seed` is the root of travels, turns and noise. Once all are given,
    `cut_off` counts recordings left out because the imprint is faint or reaches the border.
    """

    rows: Sequence[TouchRow]
    seed: int
    cut_off: int = field(default=0)

    def __len__(self) -> int:
        return 2 * len(self.rows)

    def __iter__(self) -> Iterator[Case]:
        return (case for case, _ in self.made())

    def made(self) -> Iterator[tuple[Case, float]]:
        """Yield the same clips and how far the imprint's middle goes, pixels of its frames."""
        given = 0
        for row, imprint, idle, rng in _imprints(self.rows, self.seed, "semi-real"):
            motion, given = SLIDES[given % len(SLIDES)], given + 1
            path_px, turn_deg = slide_path(motion, idle.shape[1], rng)
            clip = carried(imprint, idle, rng, row.path.name, path_px=path_px, turn_deg=turn_deg)
            for shown, truth in ((clip, motion), (clip.reversed(), reverse(motion))):
                case = Case(shown, truth, row.object_id, row.object_family)
                yield case, travel_of(imprint, path_px, turn_deg)
        self.cut_off = len(self.rows) - given


def semi_real_held(rows: Sequence[TouchRow], seed: int) -> Iterator[Case]:
    """Yield each imprint held still, pressed in and let go, in the place where it was recorded.

    Held, only fresh noise changes from frame to frame. Pressed in, the recorded change against the
    idle gel grows from `PRESS_FROM` of it to all of it: real contacts also widen, which lacks here.
    """
    for row, imprint, idle, rng in _imprints(rows, seed, "semi-real held"):
        still, pressed = (
            carried(imprint, idle, rng, row.path.name, growth=(begin, 1.0))
            for begin in (1.0, PRESS_FROM)
        )
        shown = (still, Motion.STILL), (pressed, Motion.PRESS)
        for clip, motion in (*shown, (pressed.reversed(), Motion.RELEASE)):
            tags = {"held": "held still" if motion is Motion.STILL else "pressed or let go"}
            yield Case(clip, motion, row.object_id, row.object_family, tags)


def slide_path(
    motion: Motion, columns: int, rng: np.random.Generator
) -> tuple[NDArray[np.float64], float]:
    """Draw the travel right and down of a slide in frames so wide, in pixels, and its turn, deg."""
    along = rng.uniform(*TRAVEL_SHARE) * columns
    aside = rng.uniform(-SIDEWAYS_SHARE, SIDEWAYS_SHARE) * along
    toward = np.array(_TOWARDS[motion], float)
    path_px = along * toward + aside * toward[::-1]
    return path_px, rng.uniform(-TURN_DEG, TURN_DEG)


def travel_of(imprint: NDArray[np.float32], path_px: Sequence[float], turn_deg: float) -> float:
    """Return how far the middle of an imprint goes when it is carried, in pixels.

    The turn is about the middle of the image, and takes an imprint beside it along.
    """
    rows, columns = imprint.shape[:2]
    weight = np.square(imprint).sum(axis=-1)
    weight /= weight.sum()
    arm_x = float(weight.sum(axis=0) @ np.arange(columns)) - columns / 2
    arm_y = float(weight.sum(axis=1) @ np.arange(rows)) - rows / 2
    cos, sin = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    x = path_px[0] + (cos - 1) * arm_x - sin * arm_y
    y = path_px[1] + sin * arm_x + (cos - 1) * arm_y
    return float(np.hypot(x, y))


def carried(
    imprint: NDArray[np.float32],
    idle: NDArray[np.float32],
    rng: np.random.Generator,
    name: str = "",
    *,
    path_px: Sequence[float] = (0.0, 0.0),
    turn_deg: float = 0.0,
    growth: tuple[float, float] = (1.0, 1.0),
) -> Clip:
    """Return four frames of an imprint on the idle gel, evenly from its own place to another.

    Args:
        imprint: Change of a touched frame against the idle gel, (rows, columns, 3), grey levels.
        idle: The idle gel, likewise.
        rng: Draws the noise.
        name: What the clip is called.
        path_px: Travel, right and down.
        turn_deg: Turn about the image's middle, positive clockwise.
        growth: Strength in the first frame and in the last, 1 as recorded.
    """
    rows, columns = idle.shape[:2]
    frames = []
    for share in np.linspace(0, 1, FRAME_COUNT):
        # OpenCV turns counterclockwise for positive angles; here clockwise is positive.
        matrix = cv2.getRotationMatrix2D((columns / 2, rows / 2), -turn_deg * share, 1.0)
        matrix[:, 2] += share * np.asarray(path_px)
        moved = cv2.warpAffine(imprint, matrix, (columns, rows), flags=cv2.INTER_CUBIC)
        strength = growth[0] + share * (growth[1] - growth[0])
        noise = rng.normal(0, NOISE_GREY, idle.shape)
        frames.append(as_image(idle + strength * moved + noise))
    return Clip(np.stack(frames), background=as_image(idle), name=name)


def _imprints(
    rows: Sequence[TouchRow], seed: int, purpose: str
) -> Iterator[tuple[TouchRow, NDArray[np.float32], NDArray[np.float32], np.random.Generator]]:
    """Yield each recording with its imprint, neither faint nor cut off, its idle gel and a draw."""
    for index, row in enumerate(rows):
        frames, idle = read_touched(row)
        touched = frames[row.contact_start : row.contact_end + 1]
        changes = [np.square(frame - idle).mean() for frame in touched]
        imprint = touched[int(np.argmax(changes))] - idle
        width = round(BORDER_SHARE * idle.shape[1])
        square = np.square(imprint).mean(axis=-1)
        inner, whole = square[width:-width, width:-width], square.mean()
        at_border = (square.sum() - inner.sum()) / (square.size - inner.size)
        if whole >= LEAST_CHANGE_GREY**2 and at_border <= MOST_AT_BORDER**2 * whole:
            yield row, imprint.astype(np.float32), idle, generator_for(seed, purpose, index)


def read_touched(row: TouchRow) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """Return a recording's frames, and its idle gel in grey levels."""
    frames = read_clip(row.path).frames
    row.check_length(len(frames))
    return frames, frames[row.surely_idle].mean(axis=0, dtype=np.float32)


def as_image(values: NDArray[np.floating]) -> NDArray[np.uint8]:
    """Return grey levels as 8 bit hold them."""
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
