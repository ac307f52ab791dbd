"""Stiff and extreme scenes, and what the contact solver makes of each in a number format.

Catches nothing but a refusal. Knows no model and no pass mark.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import torch

from geotlm_lm.benchmarks.rows import Row
from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.contact import preset_named, solve_contact
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import Body, Gel, Path, Scene


def stiff_scene(
    frames: int,
    *,
    body: str = "key",
    size: float = 1.0,
    depth_mm: float = 0.6,
    turn_deg: float = 9.0,
    x_mm: float = 0.0,
    start_mm: float = 0.0,
    **gel: float,
) -> Scene:
    """Return a body that is pressed in `depth_mm` and turns or travels along x, in some frames.

    It begins `start_mm` from the view's middle; `gel` is what is unlike GelSight Mini's.

    Raises:
        ValueError: If the simulator refuses it.
    """
    share = np.linspace(0, 1, frames).tolist()
    path = Path(
        depth_mm=(depth_mm,) * frames,
        x_mm=tuple(start_mm + x_mm * one for one in share),
        y_mm=(0.0,) * frames,
        rotation_rad=tuple(math.radians(turn_deg) * one for one in share),
    )
    motion = Motion.CLOCKWISE if turn_deg else Motion.RIGHT
    return Scene(Body(body, size=size), path, motion, Gel(**gel))


STIFF_CASES: dict[str, Mapping[str, Any]] = tomllib.loads(
    FilePath(__file__).with_name("stiff_scenes.toml").read_text()
)
"""Scenes by what is unlike the base one, options of `stiff_scene`; the base scene first."""

RESIDUALS = ("penetration_um", "gradient_share", "cone_excess")
"""What the solver reports of how far it is from a solution."""


def solver_rows(name: str, case: Mapping[str, Any]) -> Iterator[Row]:
    """Yield how a scene's contact was solved in double and in single precision.

    By the preset that data sets are made with, or what that escalates to. The error of the single
    one is how far its surface was dragged elsewhere, at most; None where the grids differ.
    """
    exact = None
    for precision in ("float64", "float32"):
        preset = replace(preset_named("good"), dtype=getattr(torch, precision))
        row = Row(name, f"contact, {precision}", unit="um")
        try:
            scene = stiff_scene(2, **case)
        except ValueError as error:
            yield replace(row, outcome=f"refused: {error}")
            continue
        contact = solve_contact(scene, build_profile(scene.body), preset, with_drift=True)
        height, drift, status = contact.indentation_mm, contact.drift_mm.double(), contact.status
        outcome, error = "solved", None
        if status.preset != preset.name:
            outcome = f"solved as {status.preset}, {str(height.dtype).removeprefix('torch.')}"
        if not bool(torch.isfinite(height).all() and torch.isfinite(drift).all()):
            outcome = "not finite"
        elif not status.is_converged:
            outcome = "not converged, and says so"
        if exact is not None and exact.shape == drift.shape:
            error = 1e3 * float((drift - exact).abs().max())
        exact = drift
        residuals = {one: getattr(status, one) for one in RESIDUALS}
        yield replace(row, error=error, outcome=outcome, detail=residuals)
