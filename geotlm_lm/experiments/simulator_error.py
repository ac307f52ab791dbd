"""Error against run time of the simulator: every preset, and what a user might take instead.

Height, drift and image of each variant are held against the reference preset's, on the same scenes
and pixels; times are of the whole surface at image resolution, profile and rendering apart. The
reference is timed once.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.record import RunRecord
from geotlm_lm.simulation.contact import dome_mm
from geotlm_lm.simulation.idle import idle_frame
from geotlm_lm.simulation.normal_contact import SolverStatus
from geotlm_lm.simulation.optics import lit
from geotlm_lm.simulation.presets import PRESETS
from geotlm_lm.simulation.profile import Profile, build_profile
from geotlm_lm.simulation.scene import Body, Gel, Path, Scene
from geotlm_lm.simulation.surface import Surface, pressed_surface

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Variant:
    """One way to get a surface.

    Args:
        surface_of: (scene, profile) -> surface.
        asked: The preset it asks for; a result of another one was escalated.
    """

    surface_of: Callable[[Scene, Profile], Surface]
    asked: str


FRAMES = 4
REPEATS = 5
OVERLAP = "overlap"

GEL = Gel(thickness_mm=4.0, poisson_ratio=0.48, friction=0.5)


def scenes() -> dict[str, Scene]:
    """Return a ball, a ridged key and a nut: twisted by 9 degrees, slid by 0.9 mm, pressed."""
    steps = np.linspace(0, 1, FRAMES)
    still = (0.0,) * FRAMES
    paths = {
        "twist": Path((0.6,) * FRAMES, still, still, tuple(math.radians(9) * steps)),
        "slide": Path((0.6,) * FRAMES, tuple(0.9 * steps), still, still),
        "press": Path(tuple(0.2 + 0.4 * steps), still, still, still),
    }
    bodies = {"ball": Body("ball_medium"), "key": Body("key"), "nut": Body("hex_nut")}
    return {
        f"{name}, {motion}": Scene(body, path, Motion.STILL, GEL)
        for name, body in bodies.items()
        for motion, path in paths.items()
    }


def variants() -> dict[str, Variant]:
    """Return every way to get a surface, cheapest last; the reference is not among them."""

    def solved(preset, **options) -> Variant:
        def surface_of(scene: Scene, profile: Profile) -> Surface:
            return pressed_surface(scene, profile, preset, **options)

        return Variant(surface_of, preset.name)

    half_space = replace(PRESETS["good"], is_half_space=True)
    own = {
        name: solved(PRESETS[name], with_drift=True)
        for name in ("accurate", "good", "fast", "draft")
    }
    return own | {
        "fast, no friction": solved(PRESETS["fast"]),
        "draft, no friction": solved(PRESETS["draft"]),
        "half-space, 64 cells": solved(half_space, with_drift=True),
        "geometric overlap": Variant(overlap_surface, OVERLAP),
    }


def overlap_surface(scene: Scene, profile: Profile) -> Surface:
    """Return the surface of a kinematic simulator: the gel is where the object is, and goes along.

    No elasticity: nothing sinks in around the contact, and everything under the object sticks.
    """
    path, optics = scene.path, scene.optics
    size = (optics.mm_per_px_x, optics.mm_per_px_y)
    dome = dome_mm(scene.gel, size, IMAGE_SIDE, optics.mounting)
    axis = np.arange(IMAGE_SIDE) - (IMAGE_SIDE - 1) / 2
    x, y = np.meshgrid(axis * size[0], axis * size[1])
    depth = np.zeros((len(path), IMAGE_SIDE, IMAGE_SIDE), np.float32)
    drift = np.zeros((len(path), 2, IMAGE_SIDE, IMAGE_SIDE), np.float32)
    for frame in range(len(path)):
        pose = (path.x_mm[frame], path.y_mm[frame], path.rotation_rad[frame])
        rigid = np.float32(path.depth_mm[frame]) - dome - profile.sample(pose, size, IMAGE_SIDE)
        depth[frame] = np.maximum(rigid, 0)
        turn = path.rotation_rad[frame] - path.rotation_rad[0]
        arm_x, arm_y = x - path.x_mm[0], y - path.y_mm[0]
        moved_x = (math.cos(turn) - 1) * arm_x - math.sin(turn) * arm_y
        moved_y = math.sin(turn) * arm_x + (math.cos(turn) - 1) * arm_y
        drift[frame, 0] = (moved_x + path.x_mm[frame] - path.x_mm[0]) * (rigid > 0)
        drift[frame, 1] = (moved_y + path.y_mm[frame] - path.y_mm[0]) * (rigid > 0)
    return Surface(depth, depth > 0, drift, SolverStatus(0.0, 0, True, preset=OVERLAP))


def simulator_error(
    *,
    command: str = "",
    chosen: Mapping[str, Scene] | None = None,
    asked: Mapping[str, Variant] | None = None,
    reference: str = "reference",
    repeats: int = REPEATS,
    progress: Progress = lambda what, done, total: None,
) -> RunRecord:
    """Hold every variant against the reference on every scene.

    Args:
        command: The command line, for the record.
        chosen: Scenes by name; all by default.
        asked: Variants by name; all by default.
        reference: The preset that counts as exact.
        repeats: Timed runs of each variant, after one that is not.
        progress: Told how far the run is.
    """
    started = time.perf_counter()
    chosen, asked = chosen or scenes(), asked or variants()
    rows: list[dict[str, Any]] = []
    for done, (name, scene) in enumerate(chosen.items(), start=1):
        profile = build_profile(scene.body)
        begun = time.perf_counter()
        exact = pressed_surface(scene, profile, PRESETS[reference], with_drift=True)
        seconds = time.perf_counter() - begun
        own = {"scene": name, "variant": reference, "asked": reference, "ms": [1e3 * seconds]}
        rows.append(own | _errors(scene, exact, exact))
        for title, variant in asked.items():
            surface, milliseconds = _timed(variant, scene, profile, repeats)
            own = {"scene": name, "variant": title, "asked": variant.asked, "ms": milliseconds}
            rows.append(own | _errors(scene, surface, exact))
        progress("simulator", done, len(chosen))
    return RunRecord(
        name="simulator",
        command=command,
        seed=0,
        seconds=time.perf_counter() - started,
        numbers={"rows": rows},
        config={"reference": reference, "frames": FRAMES, "threads": torch.get_num_threads()},
    )


def _timed(
    variant: Variant, scene: Scene, profile: Profile, repeats: int
) -> tuple[Surface, list[float]]:
    surface = variant.surface_of(scene, profile)
    took = []
    for _ in range(repeats):
        begun = time.perf_counter()
        variant.surface_of(scene, profile)
        took.append(1e3 * (time.perf_counter() - begun))
    return surface, sorted(took)


def _errors(scene: Scene, surface: Surface, exact: Surface) -> dict[str, Any]:
    """Return the height's, the drift's and the image's error; the drift's is None where unasked."""
    height = surface.indentation_mm - exact.indentation_mm
    drift = None
    if surface.drift_mm is not None:
        # From the first frame on: the spread of the first press is no one's shear.
        moved, true = (one.drift_mm[1:] - one.drift_mm[:1] for one in (surface, exact))
        size = float(np.linalg.norm(true))
        drift = float(np.linalg.norm(moved - true)) / size if size > 1e-6 else None
    seen, true_seen = (images(scene, one.indentation_mm) for one in (surface, exact))
    return {
        "height_um": 1e3 * float(np.sqrt(np.square(height).mean())),
        "drift_share": drift,
        "image_grey": float(np.sqrt(np.square(seen - true_seen).mean())),
        "penetration_um": surface.status.penetration_um,
        "preset": surface.status.preset,
        "is_converged": surface.status.is_converged,
    }


def images(scene: Scene, indentation_mm: Sequence[NDArray[np.float32]]) -> NDArray[np.float32]:
    """Return noise-free frames (frames, 3, 224, 224) of indentations (frames, 224, 224)."""
    idle = idle_frame(scene.optics.idle)
    return np.stack([lit(frame, idle, scene.optics) for frame in indentation_mm])
