"""Idle and touched images to measure: of real sensors, and of the simulator's random scenes."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.data.touch_table import TABLE_NAME, TouchRow, read_touch_table
from geotlm_lm.recordings.images import IMAGE_SUFFIXES, read_still_image
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.simulation.indenter import HeightMap, Indenter, where_solid
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.optics import NOMINAL_VIEW_MM
from geotlm_lm.simulation.presets import PresetName
from geotlm_lm.simulation.randomise import random_scene, random_scenes
from geotlm_lm.simulation.scene import Scene
from geotlm_lm.simulation.simulate import simulate

Floats = NDArray[np.float32]

SIMULATED = "simulated"

CALIBRATION, PHYSICLEAR = "calibration", "physiclear"
"""Folders of real images: stills beside a `background.png`; video clips beside a `clips.csv`."""

IDLE_FRAMES = 30
"""Idle frames used at most, the last ones before the touch."""

CODEC_GROUP = 12
"""Frames between two that a codec stores whole; between these the noise stands still (measured)."""

REAL_MM_PER_PX = (NOMINAL_VIEW_MM / IMAGE_SIDE, 0.75 * NOMINAL_VIEW_MM / IMAGE_SIDE)
"""A view of 320 x 240 square pixels made square (gs_sdk: 0.0634 mm each)."""

BALL_NAME = re.compile(r"(\d+\.\d+)mm_\d+")
"""Name of a still that shows a ball: its diameter."""


@dataclass(frozen=True, eq=False)
class Touches:
    """One sensor and session: the gel idle, and touched once or more.

    Args:
        source: Sensor or setting it comes from.
        name: Recording, folder or scene.
        idle: What touched frames are compared with, (224, 224, 3).
        series: Successive idle frames, (t, 224, 224, 3); t = 0 where none were recorded.
        halves: Two means of idle frames whose noise is independent; None where there are none.
        touched: Touched frames, (n, 224, 224, 3).
        mm_per_px: Size of a pixel (x, y); real ones are a GelSight Mini's nominal size.
        balls_mm: Diameter of the ball in each touched frame; empty where it is no ball.
        is_video: Whether the series comes out of a lossy video, as every real one does.
    """

    source: str
    name: str
    idle: Floats
    series: Floats
    halves: tuple[Floats, Floats] | None
    touched: Floats
    mm_per_px: tuple[float, float] = REAL_MM_PER_PX
    balls_mm: tuple[float, ...] = ()
    is_video: bool = True


def find_real(folder: Path) -> list[Path]:
    """Return the still folders and the recordings below `folder`, the stills first.

    Raises:
        UnreadableClip: If the folder holds neither, or a table without its columns.
    """
    stills = [one.parent for one in sorted(folder.glob(f"{CALIBRATION}/*/background.png"))]
    clips = [row.path for row in read_touch_table(folder / PHYSICLEAR / TABLE_NAME)]
    if not stills or not clips:
        raise UnreadableClip(
            f"{folder}: found {len(stills)} folders of stills with a background.png in "
            f"{CALIBRATION}/ and {len(clips)} touched recordings in {PHYSICLEAR}/clips.csv; "
            f"expected both."
        )
    return stills + clips


def real_touches(folder: Path) -> Iterator[Touches]:
    """Yield what `find_real` found, in its order, one folder or recording at a time.

    Raises:
        UnreadableClip: If one of them cannot be read.
    """
    for background in sorted(folder.glob(f"{CALIBRATION}/*/background.png")):
        yield _stills(background)
    for row in read_touch_table(folder / PHYSICLEAR / TABLE_NAME):
        yield _recording(row)


def simulated_touches(
    seed: int,
    count: int,
    *,
    objects: Sequence[str] = TRAINING_OBJECTS,
    preset: PresetName = "fast",
) -> Iterator[Touches]:
    """Yield `count` random scenes, each idle and touched.

    Args:
        seed: Root of scenes and noise.
        count: How many scenes.
        objects: Bodies to draw from.
        preset: How finely the contact is solved.
    """
    motions = [motion for motion in Motion if motion != Motion.NONE]
    for index in range(count):
        scenes = random_scenes(seed, 1, objects=objects, first_index=index, motions=motions)
        yield simulated_touch(scenes[0], seed, index, preset)


def simulated_balls(
    seed: int, count: int, diameters_mm: Sequence[float], *, preset: PresetName = "fast"
) -> Iterator[Touches]:
    """Yield `count` random presses of smooth balls, each diameter in turn.

    Args:
        seed: Root of scenes and noise.
        count: How many presses.
        diameters_mm: Of the balls.
        preset: How finely the contact is solved.
    """
    balls = [
        (diameter, Indenter(partial(_ball, radius_mm=diameter / 2), is_axisymmetric=True))
        for diameter in diameters_mm
    ]
    for index in range(count):
        diameter, ball = balls[index % len(balls)]
        rng = generator_for(seed, "ball", index)
        scene = random_scene(rng, object_name="ball", motion=Motion.STILL, indenter=ball)
        scene = replace(scene, body=replace(scene.body, texture_um=0.0))
        yield replace(simulated_touch(scene, seed, index, preset), balls_mm=(diameter,))


def _ball(x: HeightMap, y: HeightMap, rng: np.random.Generator, *, radius_mm: float) -> HeightMap:
    square = radius_mm**2 - x * x - y * y
    return where_solid(radius_mm - np.sqrt(np.maximum(square, 0)), square > 0.02 * radius_mm**2)


def simulated_touch(
    scene: Scene, seed: int, index: int = 0, preset: PresetName = "fast"
) -> Touches:
    """Return one scene, touched and with its object lifted off.

    Args:
        scene: What to simulate.
        seed: Root of the noise.
        index: Number of the scene in the seed's series.
        preset: How finely the contact is solved.
    """
    made = simulate([scene], seed=seed, first_index=index, preset=preset)[0]
    away, optics = replace(scene.path, depth_mm=(0.0,) * len(scene.path)), scene.optics
    if optics.video is not None:
        # Successive frames, like those that are measured of a real video.
        optics = replace(optics, video=replace(optics.video, frames_apart=1))
    lifted = [replace(scene, path=away, motion=Motion.NONE, optics=optics)]
    # Another seed: the two clips' noise would be the same crops.
    series = simulate(lifted, seed=seed + 1, first_index=index)[0].clip.frames.astype(np.float32)
    idle = made.clip.background.astype(np.float32)
    return Touches(
        source=SIMULATED,
        name=made.clip.name,
        idle=idle,
        series=series,
        # A video's noise stands still over the series: the idle frame has noise of its own.
        halves=(idle, series.mean(axis=0)),
        touched=strongest(made.clip.frames.astype(np.float32), idle)[None],
        mm_per_px=made.mm_per_px,
        is_video=optics.video is not None,
    )


def strongest(frames: Floats, idle: Floats) -> Floats:
    """Return the frame that differs most from the idle gel, RMS, of (t, 224, 224, 3)."""
    return frames[int(np.argmax([np.square(frame - idle).mean() for frame in frames]))]


def squared(frames: NDArray[np.uint8]) -> Floats:
    """Return frames at the model's size, float32 (t, 224, 224, 3), from (t, rows, columns, 3).

    Unlike the stem's, they are not rounded to whole levels: the noise to be measured is a third of
    one.
    """
    side = (IMAGE_SIDE, IMAGE_SIDE)
    is_small = frames.shape[1] < IMAGE_SIDE or frames.shape[2] < IMAGE_SIDE
    how = cv2.INTER_LINEAR if is_small else cv2.INTER_AREA
    resized = [cv2.resize(frame.astype(np.float32), side, interpolation=how) for frame in frames]
    return np.stack(resized)


def _stills(background: Path) -> Touches:
    folder = background.parent
    paths = [
        path
        for path in sorted(folder.iterdir())
        if path.suffix.lower() in IMAGE_SUFFIXES and path != background
    ]
    if not paths:
        raise UnreadableClip(
            f"{folder}: holds no image beside {background.name}; add touched ones."
        )
    balls = [BALL_NAME.fullmatch(path.stem) for path in paths]
    return Touches(
        source=f"{CALIBRATION}/{folder.name}",
        name=folder.name,
        idle=squared(read_still_image(background)[None])[0],
        series=np.empty((0, IMAGE_SIDE, IMAGE_SIDE, 3), np.float32),
        halves=None,
        touched=np.concatenate([squared(read_still_image(path)[None]) for path in paths]),
        balls_mm=tuple(float(ball[1]) for ball in balls if ball) if all(balls) else (),
    )


def _recording(row: TouchRow) -> Touches:
    frames = read_clip(row.path).frames
    row.check_length(len(frames))
    series = squared(frames[row.idle[-IDLE_FRAMES:]])
    idle, halves = series.mean(axis=0), None
    if len(series) > CODEC_GROUP:
        # Half a group at either end, more than a group apart: no frame is a copy of another.
        end = (len(series) - CODEC_GROUP + 1) // 2
        halves = (series[:end].mean(axis=0), series[-end:].mean(axis=0))
    return Touches(
        source=f"{PHYSICLEAR} {row.fps:g} fps",
        name=row.path.name,
        idle=idle,
        series=series,
        halves=halves,
        touched=strongest(squared(frames[row.contact_start : row.contact_end + 1]), idle)[None],
    )
