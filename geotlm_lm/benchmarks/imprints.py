"""Real imprints, held, pressed in and moved by known amounts over real idle frames.

An imprint is a touched frame's change against the mean idle gel. Carried, it lies over the idle
frames of its own recording in turn, with their noise, codec and flicker; it lacks the change of
lighting from place to place and the gel's creep, and the touched frame's own noise goes along.

Dots move with what touches them. On a gel that has them the touched frame itself is moved, by all
of the motion about the contact and by less and less towards the rim, which stays; each frame adds
what a real idle frame deviates from their mean by.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.benchmarks.cases import HALVES, Half, half_of, rows_of_half
from geotlm_lm.benchmarks.judging import Case
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.edit import opposite
from geotlm_lm.core.geometry import FRAME_COUNT, IMAGE_SIDE, camera_size
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.core.twist import COMPONENT_OF, Component
from geotlm_lm.data.labelled_recordings import csv_lines
from geotlm_lm.data.touch_table import TABLE_NAME, TouchRow, read_touch_table
from geotlm_lm.recordings.read import read_clip

Floats = NDArray[np.float32]

MOVING_SHARE = 0.7
"""Share of the way from the contact's middle to the rim in which a gel with dots moves as a whole:
contacts reach over most of it, 60 to 90 of 224 pixels in radius."""

_READ = np.linspace(0, 1, 513)
_SHIFTED = _READ + _READ * (1 - _READ) * (1 - 2 * _READ) / 2
"""Where OpenCV's cubic kernel (a = -0.75) is asked to read between two pixels, and how far it then
shifts what is smooth: by 0.136 of a pixel when asked for 0.1. Asked the other way about, it shifts
as far as it should."""

SIZES_PX = (0.1, 0.2, 0.3, 0.5, 1.0)
"""Paths that imprints are moved by, pixels of the 224-pixel image; of turns at the radius."""

CUTS = {"four": (0, 1, 2, 3), "pair": (0, 0, 3, 3)}
"""How frames are chosen -> which of four."""

HELD_DRAWS = 4
"""Held clips of each imprint and cut, each over other idle frames."""

TRAVEL_SHARE, SIDEWAYS_SHARE, TURN_DEG = (0.02, 0.12), 0.4, 2.0
"""Travel relative to the width of the view, 0.4 to 2.4 mm of a GelSight Mini's 20 mm; travel across
it at most, relative to it; and turn on the way at most: hands never slide quite straight."""

NOISE_GREY = 0.4
"""Fresh noise where one idle picture is all there is; the recordings' own, after their codec, is
0.25 to 0.4 grey levels."""

BORDER_SHARE, MOST_AT_BORDER = 0.05, 0.35
"""Width of the image's border relative to its width, and RMS change there relative to the whole
image's, above which an imprint is cut off: moved, its straight cut would be seen."""

LEAST_CHANGE_GREY, PRESS_FROM = 1.5, 0.25
"""RMS change over the image below which there is no imprint worth moving, and strength a press
begins at, relative to the recorded touch."""

SETTLED_FRAMES = 7
"""Last frames of a recording whose mean is its imprint where noise is as strong as that."""

BEFORE_LABEL = 4
"""Frames before a labelled touch that are left out."""

GRIPS, RELEASES = Path("marked", "gelslim4"), Path("marked", "letac_release")
"""Folders of gels with dots: of grips that close, and of closed ones that open."""

TOWARDS = {Motion.LEFT: (-1, 0), Motion.RIGHT: (1, 0), Motion.UP: (0, -1), Motion.DOWN: (0, 1)}


@dataclass(frozen=True, eq=False)
class Imprint:
    """What a real touch changes, and real frames of the gel untouched."""

    change: Floats  # a touched frame less the mean idle gel, grey levels, (rows, columns, 3)
    idle: Floats  # untouched frames in order, (frames, rows, columns, 3)
    kind: str  # of gel: the set that it is of
    object_id: str
    family: str
    is_round: bool = False  # whether a turn cannot be seen
    has_dots: bool = False

    def middle_and_radius(self) -> tuple[NDArray[np.float64], float]:
        """Return the middle of the contact, x before y in its frames' pixels, and its radius.

        The radius is in pixels of the 224-pixel image.
        """
        rows, columns = self.change.shape[:2]
        noise = self.idle.var(axis=0).mean() * len(self.idle) / max(len(self.idle) - 1, 1)
        square = np.square(self.change).mean(axis=-1)
        energy = cv2.GaussianBlur(square, (0, 0), columns / 50) - 2 * noise
        weight = np.sqrt(energy.clip(min=0.05 * energy.max()) - 0.05 * energy.max())
        weight /= weight.sum()
        y, x = np.indices(weight.shape)
        middle = np.array([(weight * x).sum(), (weight * y).sum()])
        off_x, off_y = (x - middle[0]) / columns, (y - middle[1]) / rows
        spread = (weight * (np.square(off_x) + np.square(off_y))).sum()
        return middle, IMAGE_SIDE * float(np.sqrt(spread))


@dataclass(frozen=True, eq=False)
class MovedImprint:
    """A clip of a real imprint, or of the untouched gel, and what is true of it."""

    clip: Clip
    way: Motion
    path_px: float  # pixels of the 224-pixel image; of a turn at the radius, 0 of a press
    kind: str
    object_id: str
    family: str
    frames: str  # of CUTS

    @property
    def component(self) -> Component | None:
        """Component that moves; None where it is held, or nothing touches."""
        return COMPONENT_OF.get(self.way)


def moved_imprints(
    folder: Path,
    half: Half | None = None,
    *,
    seed: int = 0,
    kinds: Sequence[str] | None = None,
    sizes_px: Sequence[float] = SIZES_PX,
    held: int = HELD_DRAWS,
    most: int | None = None,
) -> Iterator[MovedImprint]:
    """Yield each real imprint below `folder` as four frames and as pairs, in turn.

    It slides to and fro along one axis and turns both ways by each of `sizes_px`, is held `held`
    times, pressed in and let go; the gel is also shown untouched. The axes come in turn.

    Args:
        folder: Holds the sets of real recordings.
        half: To keep to.
        seed: Root of the draws of idle frames.
        kinds: Of gel to keep to, of `SOURCES`.
        sizes_px: Paths to move by.
        held: Held clips of each imprint and cut; half as many, rounded up, are untouched.
        most: Imprints of each kind and half at most.
    """
    for kind in SOURCES if kinds is None else kinds:
        for own in HALVES if half is None else (half,):
            for index, imprint in enumerate(islice(SOURCES[kind](folder, own), most)):
                rng = generator_for(seed, "moved imprints", kind, own, index)
                axis = SLIDES[:2] if index % 2 else SLIDES[2:]
                ways = axis if imprint.is_round else (*ROTATIONS, *axis)
                yield from _moved(imprint, rng, ways, sizes_px, held)


def _moved(
    imprint: Imprint,
    rng: np.random.Generator,
    ways: Sequence[Motion],
    sizes_px: Sequence[float],
    held: int,
) -> Iterator[MovedImprint]:
    middle, radius = imprint.middle_and_radius()
    rows, columns = imprint.change.shape[:2]
    scale = np.array([columns, rows]) / IMAGE_SIDE
    made = partial(carried, imprint.change, about=middle, has_dots=imprint.has_dots)

    def both(clip: Clip, way: Motion, path_px: float = 0.0) -> Iterator[MovedImprint]:
        about = (imprint.kind, imprint.object_id, imprint.family)
        for frames, places in CUTS.items():
            yield MovedImprint(clip.select(places), way, path_px, *about, frames)

    for size in sizes_px:
        for way in ways:
            path, turn = np.zeros(2), 0.0
            if way in TOWARDS:
                path = size * scale * TOWARDS[way]
            else:
                turn = np.degrees(size / radius) * (1 if way is Motion.CLOCKWISE else -1)
            yield from both(made(_draw(imprint.idle, rng), path_px=path, turn_deg=turn), way, size)
    for _ in range(held):
        yield from both(made(_draw(imprint.idle, rng)), Motion.STILL)
    pressed = made(_draw(imprint.idle, rng), growth=(PRESS_FROM, 1.0))
    for clip, way in ((pressed, Motion.PRESS), (pressed.reversed(), Motion.RELEASE)):
        yield from both(clip, way)
    for _ in range((held + 1) // 2):
        yield from both(made(_draw(imprint.idle, rng), growth=(0.0, 0.0)), Motion.NONE)


def _draw(idle: Floats, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return four of the idle frames, in order or backwards, and the mean of all.

    One idle frame alone gets fresh noise.
    """
    if len(idle) == 1:
        return idle + rng.normal(0, NOISE_GREY, (FRAME_COUNT, *idle.shape[1:])), idle[0]
    places = np.sort(rng.choice(len(idle), FRAME_COUNT, replace=len(idle) < FRAME_COUNT))
    return idle[places[:: rng.choice([-1, 1])]], idle.mean(axis=0)


def touched_imprints(
    rows: Sequence[TouchRow], kind: str, left_out: Counter[str] | None = None
) -> Iterator[Imprint]:
    """Yield the imprint of each recording that is neither faint nor cut off.

    In the end `left_out["cut_off_left_out"]` counts those that are.
    """
    count = 0
    for row in rows:
        frames = read_clip(row.path).frames
        row.check_length(len(frames))
        idle = frames[row.surely_idle].astype(np.float32)
        mean = idle.mean(axis=0)
        touched = frames[row.contact_start : row.contact_end + 1]
        changes = [np.square(frame - mean).mean() for frame in touched]
        imprint = touched[int(np.argmax(changes))] - mean
        if is_whole(imprint):
            count += 1
            yield Imprint(imprint, idle, kind, row.object_id, row.object_family)
    if left_out is not None:
        left_out["cut_off_left_out"] = len(rows) - count


def is_whole(change: Floats) -> bool:
    """Tell whether an imprint is neither faint nor cut off by the border."""
    width = round(BORDER_SHARE * change.shape[1])
    square = np.square(change).mean(axis=-1)
    inner, whole = square[width:-width, width:-width], square.mean()
    at_border = (square.sum() - inner.sum()) / (square.size - inner.size)
    return whole >= LEAST_CHANGE_GREY**2 and at_border <= MOST_AT_BORDER**2 * whole


def _of_table(name: str, folder: Path, half: Half) -> Iterator[Imprint]:
    rows = rows_of_half(read_touch_table(folder / name / TABLE_NAME), half)
    return touched_imprints(rows, name)


def _of_pictures(folder: Path, half: Half) -> Iterator[Imprint]:
    """Yield imprints of single pictures with one idle picture beside them."""
    for own in sorted(path.parent for path in folder.glob("calibration/*/background.png")):
        idle = picture(own / "background.png").astype(np.float32)
        for path in sorted(own.glob("*.png")):
            family = path.stem.split("_")[0]
            if path.stem == "background" or half_of(family) != half:
                continue
            change = picture(path) - idle
            if is_whole(change):
                about = ("calibration", path.stem, family)
                yield Imprint(change, idle[None], *about, is_round=own.name == "ball_press")


def _of_grips(folder: Path, half: Half) -> Iterator[Imprint]:
    """Yield imprints of a gel with dots that begin untouched, of low resolution and much noise."""
    own = folder / GRIPS
    for row in table_rows(own / "labels.csv"):
        family = row["clip"].rpartition("_")[0]
        if half_of(family) == half:
            frames = read_clip(own / row["clip"]).frames.astype(np.float32)
            idle = frames[1 : int(row["contact_from"]) - BEFORE_LABEL]
            change = frames[-SETTLED_FRAMES:].mean(axis=0) - idle.mean(axis=0)
            yield Imprint(change, idle, "gelslim4", row["clip"], family, has_dots=True)


def _of_releases(folder: Path, half: Half) -> Iterator[Imprint]:
    """Yield imprints of a gel with dots over frames of other recordings in which nothing touches.

    Those are one sensor's, a few hours apart: their means differ by less than their noise.
    """
    own = folder / RELEASES
    names = [row["name"] for row in table_rows(own / "labels.csv")]
    empty = [name for name in names if name.startswith("empty")]
    for index, name in enumerate(name for name in names if name not in empty):
        family = name.partition("_tr_")[0]
        if half_of(family) == half:
            idle = read_clip(own / empty[index % len(empty)]).frames.astype(np.float32)
            change = read_clip(own / name).frames[0] - idle.mean(axis=0)
            yield Imprint(change, idle, "letac", name, family, has_dots=True)


SOURCES: dict[str, Callable[[Path, Half], Iterator[Imprint]]] = {
    "physiclear": partial(_of_table, "physiclear"),
    "calibration": _of_pictures,
    "gelslim4": _of_grips,
    "letac": _of_releases,
}
"""Kinds of gel, the last two with dots -> what yields the imprints of a half of them."""


def table_rows(path: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV table, none where there is no such file."""
    if not path.is_file():
        return []
    return [values for _, values in csv_lines(path, "save it as CSV again")[1]]


def semi_real_slides(
    rows: Sequence[TouchRow], seed: int, left_out: Counter[str] | None = None
) -> Iterator[Case]:
    """Yield a slide of each imprint, forwards and backwards.

    The four ways come in turn; `seed` is the root of travels, turns and idle frames. In the end
    `left_out["cut_off_left_out"]` counts imprints that are faint or reach the border.
    """
    for index, imprint in enumerate(touched_imprints(rows, "", left_out)):
        motion, rng = SLIDES[index % len(SLIDES)], generator_for(seed, "semi-real", index)
        path_px, turn_deg = slide_path(motion, imprint.change.shape[1], rng)
        gel = _draw(imprint.idle, rng)
        clip = carried(imprint.change, gel, path_px=path_px, turn_deg=turn_deg)
        clip = replace(clip, name=imprint.object_id)
        amount = travel_of(imprint.change, path_px, turn_deg)
        for shown, truth in ((clip, motion), (clip.reversed(), opposite(motion))):
            yield Case(shown, truth, imprint.family, amount=amount)


def slide_path(
    motion: Motion, columns: int, rng: np.random.Generator
) -> tuple[NDArray[np.float64], float]:
    """Draw the travel right and down of a slide in frames so wide, in pixels, and its turn, deg."""
    along = rng.uniform(*TRAVEL_SHARE) * columns
    aside = rng.uniform(-SIDEWAYS_SHARE, SIDEWAYS_SHARE) * along
    toward = np.array(TOWARDS[motion], float)
    path_px = along * toward + aside * toward[::-1]
    return path_px, rng.uniform(-TURN_DEG, TURN_DEG)


def travel_of(imprint: Floats, path_px: Sequence[float], turn_deg: float) -> float:
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


def picture(path: Path) -> NDArray[np.uint8]:
    """Return an image file as RGB."""
    return np.ascontiguousarray(cv2.imread(str(path))[..., ::-1])


def carried(
    change: Floats,
    gel: tuple[Floats, Floats],
    *,
    path_px: Sequence[float] = (0.0, 0.0),
    turn_deg: float = 0.0,
    growth: tuple[float, float] = (1.0, 1.0),
    about: Sequence[float] | None = None,
    has_dots: bool = False,
) -> Clip:
    """Return four frames of an imprint over the gel, evenly from its own place to another.

    Args:
        change: A touched frame's change against the idle gel, (rows, columns, 3), grey levels.
        gel: Four frames of it, and what it looks like on the mean.
        path_px: Travel right and down, pixels of the frames.
        turn_deg: Turn, clockwise positive.
        growth: First strength and last, 1 as recorded.
        about: What it turns about, x before y in pixels; None for the middle of the image.
        has_dots: Whether the gel has dots, which go along about the contact and stay at the rim.
    """
    grounds, idle = gel
    rows, columns = idle.shape[:2]
    middle = np.array((columns / 2, rows / 2) if about is None else about)
    camera_rows, camera_columns = camera_size(rows, columns)
    # A turn is rigid on the gel, whose pixels are not square in a squashed picture.
    stretch, frames = np.array([camera_columns / columns, camera_rows / rows]), []
    window = window_about(middle, (rows, columns)) if has_dots else None
    for share, ground in zip(np.linspace(0, 1, FRAME_COUNT), grounds, strict=True):
        angle = np.radians(turn_deg * share)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        turn = turn * stretch / stretch[:, None]
        way = middle - turn @ middle + share * np.asarray(path_px)
        strength = float(growth[0] + share * (growth[1] - growth[0]))
        touched = strength * change + (idle if has_dots else 0)
        rest = ground - idle if has_dots else ground
        frames.append(as_image(rest + warped(touched, np.column_stack([turn, way]), window)))
    return Clip(np.stack(frames), background=as_image(idle))


def window_about(middle: Sequence[float], size: tuple[int, int]) -> Floats:
    """Return the share of a motion that each pixel makes, (rows, columns).

    It is 1 about a contact's middle, x before y in pixels, and falls smoothly to 0 at the rim.
    """
    sides = []
    for place, length in zip(middle, size[::-1], strict=True):
        off = np.arange(length) - place
        out = np.abs(off) / np.maximum(np.where(off < 0, place, length - 1 - place), 1.0)
        down = np.clip((1 - out) / (1 - MOVING_SHARE), 0, 1)
        sides.append(down * down * (3 - 2 * down))
    return np.outer(sides[1], sides[0]).astype(np.float32)


def warped(picture: Floats, forth: NDArray[np.float64], window: Floats | None = None) -> Floats:
    """Return a picture (rows, columns, 3) moved by an affine motion (2, 3), where a window lets it.

    It is read once, by cubic interpolation.
    """
    if np.array_equal(forth, np.eye(2, 3)):
        return picture
    rows, columns = picture.shape[:2]
    back = cv2.invertAffineTransform(forth)
    at = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1)
    source = at @ back[:, :2].T + back[:, 2]
    if window is not None:
        source = at + window[..., None] * (source - at)
    whole = np.floor(source)
    read = (whole + np.interp(source - whole, _SHIFTED, _READ)).astype(np.float32)
    reflect = cv2.BORDER_REFLECT_101
    return cv2.remap(picture, read, None, cv2.INTER_CUBIC, borderMode=reflect)


def as_image(values: NDArray[np.floating]) -> NDArray[np.uint8]:
    """Return grey levels as a picture."""
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
