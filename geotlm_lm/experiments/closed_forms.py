"""The contact solver against every closed form and law it has; catches nothing, knows no pass mark.

Problems are solved at several sizes and give errors with their order of convergence; laws hold at
any size and are checked once.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import torch
from torch import Tensor

from geotlm_lm.core.record import RunRecord
from geotlm_lm.experiments.contact_cases import Problem, problems
from geotlm_lm.experiments.contact_problems import Solved, lopsided, marched, pad, turn

Progress = Callable[[str, int, int], None]

MIRROR = torch.tensor([-1.0, 1.0], dtype=torch.float64).view(1, 2, 1, 1)
"""What a mirror left to right does to a vector."""


def measured_order(sizes: Sequence[int], errors: Sequence[float]) -> float:
    """Return the slope, sign turned, of the line through log |error| over log size."""
    return -float(np.polyfit(np.log(sizes), np.log(np.abs(errors)), 1)[0])


def mirrored_twist(angle: float = 0.05) -> float:
    """Return how far the mirrored body, twisted the other way, misses the mirrored surface."""
    layer = pad()
    overlap = lopsided(layer)
    plain = marched(layer, overlap, turn(angle))
    mirrored = marched(layer, overlap.flip(2), turn(-angle))
    drift = _deviation(mirrored.end.drift_mm.flip(3) * MIRROR, plain.end.drift_mm)
    height = _deviation(mirrored.end.indentation_mm.flip(2), plain.end.indentation_mm)
    return max(drift, height)


def other_modulus() -> float:
    """Return how far gels softer and stiffer by orders of magnitude move unlike the gel with G = 1.

    Displacements are given, so that the modulus drops out of all but the tractions.
    """
    plain = _twisted(1.0, 1.0)
    return max(
        _deviation(_twisted(modulus, 1.0).end.drift_mm, plain.end.drift_mm)
        for modulus in (1e-6, 1e4)
    )


def other_length(scale: float = 2.5) -> float:
    """Return how far a problem `scale` times as large misses the displacements times `scale`."""
    large = _twisted(1.0, scale).end.drift_mm / scale
    return _deviation(large, _twisted(1.0, 1.0).end.drift_mm)


def gained_work(angle: float = 0.01, increments: int = 6) -> float:
    """Return the most work that comes from nothing in a step of a twist there and back.

    Relative to the most energy stored; work less stored energy is what slip dissipates.
    """
    layer = pad()
    there = [turn(angle)] * increments
    steps = marched(layer, lopsided(layer), *there, *[turn(-angle)] * increments).steps
    stored = np.array([float(step.energy) for step in steps])
    rubbed = np.cumsum([float(step.work) for step in steps]) - stored
    return max(0.0, -float(np.diff(rubbed).min() / stored.max()))


LAWS: dict[str, Callable[[], float]] = {
    "a mirrored twist leaves the mirrored surface": mirrored_twist,
    "the shear modulus drops out, 1e-6 to 1e4": other_modulus,
    "lengths scale with lengths": other_length,
    "no work comes from nothing": gained_work,
}
"""Laws by name -> largest relative deviation from each."""


def closed_forms(
    *,
    command: str = "",
    chosen: Mapping[str, Problem] | None = None,
    laws: Mapping[str, Callable[[], float]] = LAWS,
    progress: Progress = lambda what, done, total: None,
) -> RunRecord:
    """Solve every problem at all of its sizes, and check every law.

    Args:
        command: The command line, for the record.
        chosen: Problems by name; all by default.
        laws: Laws by name.
        progress: Told how far the run is.
    """
    started = time.perf_counter()
    chosen = problems() if chosen is None else chosen
    rows: list[dict[str, Any]] = []
    for done, (name, problem) in enumerate(chosen.items(), start=1):
        rows += [{"problem": name} | row for row in _rows(problem)]
        progress("closed forms", done, len(chosen))
    return RunRecord(
        name="closed_forms",
        command=command,
        seed=0,
        seconds=time.perf_counter() - started,
        numbers={"rows": rows, "laws": {name: law() for name, law in laws.items()}},
        config={"precision": "float64", "threads": torch.get_num_threads()},
    )


def _rows(problem: Problem) -> list[dict[str, Any]]:
    """Return one row per quantity; all are read off the same solutions."""
    solutions = [problem.solve(size) for size in problem.sizes]
    residuals = [solved.residuals() for solved in solutions]
    shared = {
        "source": problem.source,
        "unit": problem.unit,
        "sizes": list(problem.sizes),
        "residuals": {name: max(one[name] for one in residuals) for name in residuals[0]},
        "ms": [solved.milliseconds for solved in solutions],
    }
    rows = []
    for name, quantity in problem.quantities.items():
        errors = [quantity.error_of(solved) for solved in solutions]
        own = {
            "quantity": name,
            "errors": errors,
            "order": measured_order(problem.sizes, errors),
            "expected_order": quantity.order,
            "reading": quantity.reading,
        }
        rows.append(own | shared)
    return rows


def _twisted(modulus: float, scale: float) -> Solved:
    layer = pad(scale=scale, shear_modulus=modulus)
    return marched(layer, lopsided(layer, scale), turn(0.05))


def _deviation(found: Tensor, exact: Tensor) -> float:
    return float((found - exact).abs().max() / exact.abs().max())
