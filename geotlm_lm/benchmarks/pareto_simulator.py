"""Every preset of the simulator, and two shortcuts, against the reference preset on nine scenes.

Times are of the whole surface at image resolution, without profile and rendering.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from statistics import median

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.benchmarks.pareto_answers import with_front
from geotlm_lm.benchmarks.pareto_processes import in_turn
from geotlm_lm.benchmarks.rows import Row, Run
from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.camera import idle_frame
from geotlm_lm.simulation.contact import PRESETS, Preset, dome_mm
from geotlm_lm.simulation.optics import lit
from geotlm_lm.simulation.profile import Profile, build_profile
from geotlm_lm.simulation.scene import Body, Gel, Path, Scene
from geotlm_lm.simulation.surface import pressed_surface

Fields = tuple[NDArray[np.float32], NDArray[np.float32] | None]
"""Indentation (frames, side, side) and drift (frames, 2, side, side), mm; no drift where untold."""

Solve = Callable[[Scene, Profile], Fields]

STEPS, DEPTH_MM = np.linspace(0, 1, 4), 0.6

HEIGHT, DRIFT, IMAGE = "height, um RMS", "drift, relative L2", "image, grey RMS"
"""What is held against the reference."""


def moving(
    body: str, *, slide_mm: float = 0.0, turn_deg: float = 0.0, from_mm: float = DEPTH_MM
) -> Scene:
    """Return a body that slides or turns 0.6 mm deep, or is pressed from `from_mm` on to there."""
    depths = tuple(from_mm + (DEPTH_MM - from_mm) * STEPS)
    still, turns = (0.0,) * len(STEPS), tuple(math.radians(turn_deg) * STEPS)
    path = Path(depths, tuple(slide_mm * STEPS), still, turns)
    gel = Gel(thickness_mm=4.0, poisson_ratio=0.48, friction=0.5)
    return Scene(Body(body), path, Motion.STILL, gel)


def scenes() -> dict[str, Scene]:
    """Return a ball, a ridged key and a nut: twisted by 9 degrees, slid by 0.9 mm, pressed."""
    moves = {"twist": {"turn_deg": 9.0}, "slide": {"slide_mm": 0.9}, "press": {"from_mm": 0.2}}
    return {
        f"{name}, {move}": moving(body, **amount)
        for name, body in (("ball", "ball_medium"), ("key", "key"), ("nut", "hex_nut"))
        for move, amount in moves.items()
    }


def solved(preset: Preset, scene: Scene, profile: Profile, *, with_drift: bool = True) -> Fields:
    """Return what a preset makes of a scene."""
    surface = pressed_surface(scene, profile, preset, with_drift=with_drift)
    return surface.indentation_mm, surface.drift_mm


def overlap(scene: Scene, profile: Profile) -> Fields:
    """Return the body's overlap with the gel at rest as its indentation, and no drift."""
    path, optics = scene.path, scene.optics
    mm_per_px = (optics.mm_per_px_x, optics.mm_per_px_y)
    dome = dome_mm(scene.gel, mm_per_px, IMAGE_SIDE, optics.mounting)
    poses = zip(path.depth_mm, path.x_mm, path.y_mm, path.rotation_rad, strict=True)
    reached = [d - dome - profile.sample(pose, mm_per_px, IMAGE_SIDE) for d, *pose in poses]
    return np.maximum(np.stack(reached), 0).astype(np.float32), None


VARIANTS: dict[str, Solve] = {
    **{name: partial(solved, PRESETS[name]) for name in ("accurate", "good", "fast", "draft")},
    "half-space, 64 cells": partial(solved, replace(PRESETS["good"], is_half_space=True)),
    "geometric overlap": overlap,
}


def simulator_rows(run: Run) -> Iterator[Row]:
    """Yield the error and time of every variant, by what is held against the reference."""
    chosen = scenes() if not run.is_quick else {"ball, slide": moving("ball_medium", slide_mm=0.9)}
    yield from error_rows(chosen, VARIANTS, run.size("reference", "good"), run.size(3, 1))


def error_rows(
    chosen: Mapping[str, Scene], variants: Mapping[str, Solve], reference: str, repeats: int
) -> Iterator[Row]:
    """Yield a row per measure and variant: medians over the scenes, their range in the detail.

    The preset `reference` counts as exact and runs once, the variants `repeats` times in turn.
    """
    errors: dict[str, dict[str, list[float]]] = {name: {} for name in (HEIGHT, DRIFT, IMAGE)}
    times: dict[str, list[float]] = {}
    for scene in chosen.values():
        profile = build_profile(scene.body)
        started = time.perf_counter()
        exact = solved(PRESETS[reference], scene, profile)
        once = {reference: [(exact, 1e3 * (time.perf_counter() - started))]}
        ways = {name: partial(way, scene, profile) for name, way in variants.items()}
        for name, runs in (once | in_turn(ways, repeats)).items():
            times.setdefault(name, []).append(median(ms for _, ms in runs))
            for measure, error in differences(scene, runs[0][0], exact).items():
                errors[measure].setdefault(name, []).append(error)
    for measure, found in errors.items():
        rows = []
        for name, own in found.items():
            detail, ms = {"range": [min(own), max(own)]}, median(times[name])
            rows.append(Row(measure, name, len(own), median(own), ms_p50=ms, detail=detail))
        yield from with_front(rows)


def differences(scene: Scene, fields: Fields, exact: Fields) -> dict[str, float]:
    """Return how far height, image and, where both tell it, drift are from what is exact."""
    idle = idle_frame(scene.optics.idle)
    seen, true = (
        np.stack([lit(frame, idle, scene.optics) for frame in indentation_mm])
        for indentation_mm, _ in (fields, exact)
    )
    found = {HEIGHT: 1e3 * _rms(fields[0] - exact[0]), IMAGE: _rms(seen - true)}
    if fields[1] is not None and exact[1] is not None:
        # From the first frame on: the spread of the first press is no one's shear.
        moved, asked = (drift[1:] - drift[:1] for _, drift in (fields, exact))
        found[DRIFT] = float(np.linalg.norm(moved - asked)) / float(np.linalg.norm(asked))
    return found


def _rms(values: NDArray[np.floating]) -> float:
    return float(np.sqrt(np.square(values).mean()))
