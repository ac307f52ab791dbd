"""A single simulated clip for `geotlm-lm simulate --clip`: object, movement, scene, file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from geotlm_lm.core.atomic import replacing
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion

if TYPE_CHECKING:
    from geotlm_lm.simulation.indenter import Indenter
    from geotlm_lm.simulation.presets import PresetName
    from geotlm_lm.simulation.simulate import SimulatedClip


def own_body(
    height_map: Path | None,
    mm_per_px: float | None,
    relief_mm: float | None,
    object_name: str | None,
) -> Indenter | None:
    """Return the object of a height map of one's own; None where none is given.

    Raises:
        UsageError: If what says how to read it is missing, or goes with something else.
    """
    if height_map is None:
        if mm_per_px is not None or relief_mm is not None:
            raise UsageError(
                "--mm-per-px and --relief-mm say how to read a --height-map; give one."
            )
        return None
    if object_name is not None:
        raise UsageError("--object and --height-map both name the object; leave out one of them.")
    if relief_mm is not None and height_map.suffix.lower() == ".npy":
        raise UsageError("--relief-mm is of a .png; the heights of a .npy are in mm already.")
    if mm_per_px is None:
        raise UsageError("--height-map needs --mm-per-px, the size of one sample in mm.")
    from geotlm_lm.simulation.height_map import read_height_map

    return read_height_map(height_map, mm_per_px, relief_mm=1.0 if relief_mm is None else relief_mm)


def require_shape(name: str) -> None:
    """Refuse a name that no built-in shape has.

    Raises:
        UsageError: If there is none.
    """
    from geotlm_lm.simulation.indenters import INDENTERS

    if name not in INDENTERS:
        raise UsageError(
            f"There is no shape '{name}', expected one of {', '.join(sorted(INDENTERS))}."
        )


def simulate_one(
    object_name: str,
    motion: Motion,
    seed: int,
    *,
    preset: PresetName = "fast",
    with_drift: bool = False,
    indenter: Indenter | None = None,
    is_marked: bool = False,
) -> SimulatedClip:
    """Return one simulated clip of a built-in shape or of an `indenter` of one's own.

    Options are those of `simulation.simulate.simulate` and `simulation.randomise.random_scene`.

    Raises:
        UsageError: If there is no such shape.
    """
    from geotlm_lm.core.seeding import generator_for
    from geotlm_lm.simulation.randomise import random_scene
    from geotlm_lm.simulation.simulate import simulate as simulate_scenes

    if indenter is None:
        require_shape(object_name)
    rng = generator_for(seed, "single clip", object_name, motion.value)
    scene = random_scene(
        rng,
        object_name=object_name,
        motion=motion,
        indenter=indenter,
        marker_share=float(is_marked),
    )
    made = simulate_scenes([scene], seed=seed, preset=preset, with_drift=with_drift)
    return made[0]


FIELDS = {
    "--turn": "twist_deg",
    "--slide-right": "slide_x_mm",
    "--slide-down": "slide_y_mm",
    "--press": "press_mm",
    "--pivot-right": "pivot_x_mm",
    "--pivot-down": "pivot_y_mm",
    "--depth": "depth_mm",
}
"""Option -> the field of a `Touch` that it gives."""


def move_of(options: Mapping[str, float | None]) -> dict[str, float]:
    """Return what the options ask the object to do, by the fields of a `Touch`.

    Args:
        options: The names in `FIELDS` -> what was given; None for nothing.

    Raises:
        UsageError: If a number is outside its range, or says something of a turn there is not.
    """
    given = {name: value for name, value in options.items() if value is not None}
    if not given:
        return {}
    from geotlm_lm.simulation.touch import require_in_range

    for name, value in given.items():
        require_in_range(FIELDS[name], value, name)
    if not given.get("--turn") and (given.get("--pivot-right") or given.get("--pivot-down")):
        raise UsageError(
            "--pivot-right and --pivot-down say where the axis of a --turn lies; give one."
        )
    return {FIELDS[name]: value for name, value in given.items()}


def simulate_move(
    object_name: str,
    move: Mapping[str, float],
    seed: int,
    *,
    preset: PresetName = "fast",
    with_drift: bool = False,
    indenter: Indenter | None = None,
    is_marked: bool = False,
) -> SimulatedClip:
    """Return one simulated clip of exactly this movement, seen by the measured GelSight Mini.

    Args:
        object_name: A built-in shape, or any name beside an `indenter`.
        move: What `move_of` returned.
        seed: Of the noise and of the idle gel.
        preset: How finely and tightly the contact is solved.
        with_drift: Whether the gel's drift is solved too.
        indenter: A shape of one's own.
        is_marked: Whether dots are printed on the gel.

    Raises:
        UsageError: If the press goes deeper than the gel takes, or there is no such shape.
    """
    from geotlm_lm.simulation.touch import Touch, simulate_touch

    touch = Touch(object_name, **move, seed=seed, indenter=indenter, is_marked=is_marked)
    return simulate_touch(touch, preset=preset, with_drift=with_drift)


def write_clip(path: Path, made: SimulatedClip) -> None:
    """Write frames, idle gel, rate, shape of pixels, label (JSON) and drift, if solved, as .npz."""
    import numpy as np

    label = json.dumps(made.label.to_dict() | {"object": made.object_name})
    arrays = {"frames": made.clip.frames, "label": np.array(label)}
    # The simulated camera's picture is of four to three: no reader need assume it.
    arrays["square_pixels"] = np.array(False)
    if made.clip.background is not None:
        arrays["background"] = made.clip.background
    if made.drift_px is not None:
        arrays["drift_px"] = made.drift_px
    if made.clip.fps is not None:
        arrays["fps"] = np.array(made.clip.fps)
    with replacing(path) as stream:
        np.savez_compressed(stream, **arrays)
