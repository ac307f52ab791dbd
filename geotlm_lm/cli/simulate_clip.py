"""A single simulated clip for `geotlm-lm simulate --clip`: object, movement, scene, file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from geotlm_lm.cli.options import path_option
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.files import replacing
from geotlm_lm.core.labels import Motion

if TYPE_CHECKING:
    from geotlm_lm.simulation.indenter import Indenter
    from geotlm_lm.simulation.presets import PresetName
    from geotlm_lm.simulation.simulate import SimulatedClip


@dataclass(frozen=True)
class OwnObject:
    """A height map of one's own, and how it is read."""

    height_map: Annotated[
        Path | None,
        path_option(
            help="With --clip: your own object, a .npy of heights in mm or a grey .png; what is "
            "highest touches first.",
        ),
    ] = None
    mm_per_px: Annotated[
        float | None, typer.Option(help="With --height-map: the size of one sample.")
    ] = None
    relief_mm: Annotated[
        float | None,
        typer.Option(help="With a .png height map: how far white is above black. [default: 1]"),
    ] = None

    def read(self, object_name: str | None) -> Indenter | None:
        """Return the object; None where none is given.

        Raises:
            UsageError: If what says how to read it is missing, or goes with something else.
        """
        if self.height_map is None:
            if self.mm_per_px is not None or self.relief_mm is not None:
                raise UsageError(
                    "--mm-per-px and --relief-mm say how to read a --height-map; give one."
                )
            return None
        if object_name is not None:
            raise UsageError(
                "--object and --height-map both name the object; leave out one of them."
            )
        if self.relief_mm is not None and self.height_map.suffix.lower() == ".npy":
            raise UsageError("--relief-mm is of a .png; the heights of a .npy are in mm already.")
        if self.mm_per_px is None:
            raise UsageError("--height-map needs --mm-per-px, the size of one sample in mm.")
        from geotlm_lm.simulation.height_map import read_height_map

        relief_mm = 1.0 if self.relief_mm is None else self.relief_mm
        return read_height_map(self.height_map, self.mm_per_px, relief_mm=relief_mm)


@dataclass(frozen=True)
class Move:
    """What the object is to do, exactly and all at once; options are told apart by `FIELDS`."""

    turn: Annotated[
        float | None,
        typer.Option(help="With --clip, instead of --motion: degrees turned, clockwise positive."),
    ] = None
    slide_right: Annotated[float | None, typer.Option(help="At once: mm slid to the right.")] = None
    slide_down: Annotated[float | None, typer.Option(help="At once: mm slid down the image.")] = (
        None
    )
    press: Annotated[float | None, typer.Option(help="At once: mm pressed in; negative lifts.")] = (
        None
    )
    pivot_right: Annotated[
        float | None,
        typer.Option(
            help="With --turn: its axis, mm to the right of where the contact's middle ends."
        ),
    ] = None
    pivot_down: Annotated[float | None, typer.Option(help="The same, mm below it.")] = None
    depth: Annotated[
        float | None,
        typer.Option(help="With these: mm beyond first touch, half-way. [default: 0.6]"),
    ] = None


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
    from geotlm_lm.core.numbers import generator_for
    from geotlm_lm.simulation.randomise import random_scene
    from geotlm_lm.simulation.simulate import simulate as simulate_scenes

    if indenter is None:
        require_shape(object_name)
    rng = generator_for(seed, "single clip", object_name, motion.value)
    told = {"object_name": object_name, "motion": motion, "indenter": indenter}
    scene = random_scene(rng, **told, marker_share=float(is_marked))
    return simulate_scenes([scene], seed=seed, preset=preset, with_drift=with_drift)[0]


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


def touch_fields(given: Mapping[str, float]) -> dict[str, float]:
    """Return what the options that were given ask the object to do, by the fields of a `Touch`.

    Raises:
        UsageError: If a number is outside its range, or says something of a turn there is not.
    """
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
