"""Stiff and extreme scenes: what the contact solver makes of each, in single and double precision.

Knows no pass mark: it runs every case, catches nothing but a refusal, and writes down what came.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.record import RunRecord
from geotlm_lm.simulation.contact import solve_contact
from geotlm_lm.simulation.presets import Preset, preset_named
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import Body, Gel, Path, Scene

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Case:
    """One scene, by the numbers that are unlike the base scene's.

    Args:
        body: Name of the indenter.
        size: Its scale.
        depth_mm: Approach in both frames.
        turn_deg: Turn between the frames.
        x_mm: Travel between the frames.
        start_mm: Where the object begins, from the view's middle.
        gel: What is unlike GelSight Mini's gel.
    """

    body: str = "key"
    size: float = 1.0
    depth_mm: float = 0.6
    turn_deg: float = 9.0
    x_mm: float = 0.0
    start_mm: float = 0.0
    gel: Mapping[str, float] = ()

    def scene(self) -> Scene:
        """Return the scene.

        Raises:
            ValueError: If the simulator refuses it.
        """
        path = Path(
            depth_mm=(self.depth_mm, self.depth_mm),
            x_mm=(self.start_mm, self.start_mm + self.x_mm),
            y_mm=(0.0, 0.0),
            rotation_rad=(0.0, math.radians(self.turn_deg)),
        )
        return Scene(Body(self.body, size=self.size), path, Motion.CLOCKWISE, Gel(**dict(self.gel)))


CASES: dict[str, Case] = {
    "key, 9 degree turn": Case(),
    "nu 0": Case(gel={"poisson_ratio": 0.0}),
    "nu 0.3": Case(gel={"poisson_ratio": 0.3}),
    "nu 0.499": Case(gel={"poisson_ratio": 0.499}),
    "nu 0.5, incompressible": Case(gel={"poisson_ratio": 0.5}),
    "layer 1 mm": Case(gel={"thickness_mm": 1.0}),
    "layer 0.3 mm": Case(gel={"thickness_mm": 0.3}),
    "layer 0.3 mm, incompressible": Case(gel={"thickness_mm": 0.3, "poisson_ratio": 0.5}),
    "layer 40 mm": Case(gel={"thickness_mm": 40.0}),
    "friction 0": Case(gel={"friction": 0.0}),
    "friction 0.001": Case(gel={"friction": 1e-3}),
    "friction 5": Case(gel={"friction": 5.0}),
    "friction 1e6": Case(gel={"friction": 1e6}),
    "depth 1e-6 mm": Case(depth_mm=1e-6),
    "depth 0": Case(depth_mm=0.0),
    "depth -0.5 mm": Case(depth_mm=-0.5),
    "depth 3.5 mm": Case(depth_mm=3.5),
    "turn 90 degrees": Case(turn_deg=90.0),
    "turn 179 degrees": Case(turn_deg=179.0),
    "slide 8 mm": Case(turn_deg=0.0, x_mm=8.0),
    "tip narrower than a cell": Case(body="cone_blunt", size=0.05),
    "flat-edged block": Case(body="block"),
    "rough stone": Case(body="plaster", depth_mm=1.0),
    "contact at the border": Case(start_mm=11.0),
    "contact everywhere": Case(body="plaster", depth_mm=3.0),
    "beyond the pad": Case(start_mm=40.0),
    "depth NaN": Case(depth_mm=math.nan),
    "turn infinite": Case(turn_deg=math.inf),
    "layer 0 mm": Case(gel={"thickness_mm": 0.0}),
    "nu 0.6": Case(gel={"poisson_ratio": 0.6}),
    "friction -1": Case(gel={"friction": -1.0}),
    "friction NaN": Case(gel={"friction": math.nan}),
}
"""The list of stiff and extreme cases, the base case first."""


def simulator_stability(
    *,
    preset: str = "good",
    command: str = "",
    cases: Mapping[str, Case] = CASES,
    progress: Progress = lambda what, done, total: None,
) -> RunRecord:
    """Run every case in both precisions and write down what came of it.

    Args:
        preset: Where each case begins; hard ones escalate from there.
        command: The command line, for the record.
        cases: What to run, by name.
        progress: Told how far the run is.
    """
    started = time.perf_counter()
    asked, rows = preset_named(preset), []
    for done, (name, case) in enumerate(cases.items(), start=1):
        for precision in (torch.float32, torch.float64):
            rows.append({"case": name, **_outcome(case, replace(asked, dtype=precision))})
        progress("stability", done, len(cases))
    return RunRecord(
        name="simulator_stability",
        command=command,
        seed=0,
        seconds=time.perf_counter() - started,
        numbers={"rows": rows},
        config={"preset": preset, "threads": torch.get_num_threads()},
    )


def _outcome(case: Case, preset: Preset) -> dict[str, Any]:
    row: dict[str, Any] = {"precision": _name(preset.dtype)}
    try:
        scene = case.scene()
    except ValueError as error:
        return row | {"outcome": "refused", "says": str(error)}
    profile = build_profile(scene.body)
    begun = time.perf_counter()
    contact = solve_contact(scene, profile, preset, with_drift=True)
    milliseconds = 1e3 * (time.perf_counter() - begun)
    fields = (contact.indentation_mm, contact.drift_mm)
    status = contact.status
    outcome = (
        "solved"
        if status.preset == preset.name
        else f"solved as {status.preset}, {_name(fields[0].dtype)}"
    )
    if not all(bool(torch.isfinite(field).all()) for field in fields):
        outcome = "not finite"
    elif not status.is_converged:
        outcome = "not converged, and says so"
    return row | {
        "outcome": outcome,
        "penetration_um": status.penetration_um,
        "gradient_share": status.gradient_share,
        "cone_excess": status.cone_excess,
        "dissipated_share": status.dissipated_share,
        "normal_iterations": status.iterations,
        "friction_iterations": status.friction_iterations,
        "deepest_mm": float(fields[0].max()),
        "farthest_drift_mm": float(np.hypot(*fields[1].numpy().transpose(1, 0, 2, 3)).max()),
        "milliseconds": milliseconds,
    }


def _name(precision: torch.dtype) -> str:
    return str(precision).removeprefix("torch.")
