"""What each thing left out of a scene saves and costs, against doing it in full on the same scenes.

Both ways are run in turn, repeat by repeat, so that a busy machine slows both. Errors are of the
lean way against the full one; what the lean way does not give at all counts as zero.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.labels import Motion
from geotlm_lm.experiments.simulator_error import GEL, images
from geotlm_lm.simulation.presets import FAST, Preset
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import Body, Path, Scene
from geotlm_lm.simulation.simulate import simulate
from geotlm_lm.simulation.stopwatch import Stopwatch
from geotlm_lm.simulation.surface import pressed_surface

REPEATS = 7

FINER_STEPS = 0.25
"""Length of the increments that small steps are held against."""

STEPS = (0.0, 1 / 3, 2 / 3, 1.0)
STILL = (0.0,) * len(STEPS)

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Outcome:
    """What one way gives.

    Args:
        height_mm: Indentation, (frames, side, side).
        drift: Tangential displacement of the gel, any layout; None where it is not given.
        pictures: Noise-free frames; None where none are made.
        stages: What ran.
    """

    height_mm: NDArray[np.float32]
    drift: NDArray[np.float32] | None
    pictures: Callable[[], NDArray[np.float32]] | None
    stages: tuple[str, ...]


Way = Callable[[Scene], Outcome]


@dataclass(frozen=True)
class Omission:
    """One thing that is left out where a scene does not need it.

    Args:
        full: Doing it.
        lean: Leaving it out.
        scenes: Where it is left out, by name.
        timed: What the milliseconds are of.
    """

    full: Way
    lean: Way
    scenes: Mapping[str, Scene]
    timed: str = "surface"


def omissions(preset: Preset = FAST) -> dict[str, Omission]:
    """Return everything that `simulate` leaves out of some scenes, by name."""
    finer = replace(preset, step_share=FINER_STEPS)
    thorough = replace(preset, skips_fine_profile=False)
    slippery = replace(GEL, friction=0.0)

    def without_friction(scene: Scene) -> Outcome:
        return _surface(preset, with_drift=True)(replace(scene, gel=slippery))

    moved = {
        "key, twist": _scene("key", turn=math.radians(9)),
        "nut, slide": _scene("hex_nut", 0.9),
    }
    pressed = {name: _scene(body, depth=0.2) for name, body in (("key", "key"), ("nut", "hex_nut"))}
    smooth = {
        "large ball, press": _scene("ball_large", depth=0.2),
        "ball, slide": _scene("ball_medium", 0.9),
    }
    crept = {
        "key, steps of 0.28 mm": _scene("key", 0.84),
        "nut, steps of 2.8 degrees": _scene("hex_nut", turn=math.radians(8.4)),
    }
    dragged = _surface(preset, with_drift=True)
    return {
        "friction, where no shear is asked for": Omission(dragged, _surface(preset), moved),
        "friction, in a press": Omission(dragged, without_friction, pressed),
        "substeps of small steps": Omission(_surface(finer, with_drift=True), dragged, crept),
        "fine profile of smooth bodies": Omission(_surface(thorough), _surface(preset), smooth),
        "pictures, for labels only": Omission(
            _clip(preset, with_frames=True), _clip(preset, with_frames=False), moved, "clip"
        ),
    }


def omission_rows(
    asked: Mapping[str, Omission] | None = None,
    *,
    repeats: int = REPEATS,
    progress: Progress = lambda what, done, total: None,
) -> list[dict[str, Any]]:
    """Return one row per omission and scene.

    Args:
        asked: Omissions by name; all by default.
        repeats: Timed runs of each way, after one that is not.
        progress: Told how far the run is.
    """
    asked = omissions() if asked is None else asked
    rows = []
    for done, (name, omission) in enumerate(asked.items(), start=1):
        for title, scene in omission.scenes.items():
            full, lean = omission.full(scene), omission.lean(scene)
            times = _in_turn((omission.full, omission.lean), scene, repeats)
            own = {"omission": name, "scene": title, "timed": omission.timed}
            own |= {"full_ms": times[0], "lean_ms": times[1]}
            rows.append(own | _cost(full, lean))
        progress("omissions", done, len(asked))
    return rows


def _scene(body: str, slide_mm: float = 0.0, *, turn: float = 0.0, depth: float = 0.6) -> Scene:
    """Return a body at 0.6 mm that slides or turns, or one pressed from `depth` on to there."""
    depths = tuple(depth + (0.6 - depth) * step for step in STEPS)
    x, angles = (tuple(size * step for step in STEPS) for size in (slide_mm, turn))
    return Scene(Body(body), Path(depths, x, STILL, angles), Motion.STILL, GEL)


def _surface(preset: Preset, *, with_drift: bool = False) -> Way:
    def way(scene: Scene) -> Outcome:
        watch = Stopwatch()
        profile = build_profile(scene.body)
        made = pressed_surface(scene, profile, preset, with_drift=with_drift, watch=watch)
        return Outcome(
            made.indentation_mm,
            made.drift_mm,
            lambda: images(scene, made.indentation_mm),
            tuple(watch.milliseconds),
        )

    return way


def _clip(preset: Preset, *, with_frames: bool) -> Way:
    def way(scene: Scene) -> Outcome:
        made = simulate([scene], seed=0, preset=preset.name, with_frames=with_frames)[0]
        # The label is part of what is timed: without pictures it rests on an estimate.
        stages = (*made.stages, "readable" if made.label.is_readable else "unreadable")
        return Outcome(made.depth_mm, made.drift_px, None, stages)

    return way


def _in_turn(ways: Sequence[Way], scene: Scene, repeats: int) -> list[list[float]]:
    times: list[list[float]] = [[] for _ in ways]
    for _ in range(repeats):
        for way, own in zip(ways, times, strict=True):
            begun = time.perf_counter()
            way(scene)
            own.append(1e3 * (time.perf_counter() - begun))
    return times


def _cost(full: Outcome, lean: Outcome) -> dict[str, Any]:
    shear = picture = None
    if full.drift is not None:
        # From the first frame on, as shear is told.
        true, told = (
            0.0 if drift is None else drift[1:] - drift[:1] for drift in (full.drift, lean.drift)
        )
        shear = 1e3 * _rms(true - told)
    if full.pictures is not None and lean.pictures is not None:
        picture = _rms(full.pictures() - lean.pictures())
    return {
        "height_um": 1e3 * _rms(full.height_mm - lean.height_mm),
        "shear_um": shear,
        "image_grey": picture,
        "full_stages": list(full.stages),
        "lean_stages": list(lean.stages),
    }


def _rms(values: NDArray[np.floating]) -> float:
    return float(np.sqrt(np.square(values).mean()))
