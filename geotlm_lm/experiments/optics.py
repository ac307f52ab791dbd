"""The simulator's images beside real ones: the same statistics of both, and how far they are apart.

Knows no pass mark: a statistic that lies outside the real spread is written down as such.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from geotlm_lm.core.record import RunRecord
from geotlm_lm.experiments.optics_imprint import contact_statistics, depth_statistics
from geotlm_lm.experiments.optics_recordings import (
    SIMULATED,
    Touches,
    find_real,
    real_touches,
    simulated_balls,
    simulated_touches,
)
from geotlm_lm.experiments.optics_statistics import (
    STATISTICS,
    camera_statistics,
    idle_statistics,
    pattern_statistics,
)
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.presets import PresetName
from geotlm_lm.simulation.series import SERIES_VERSION

Progress = Callable[[str, int, int], None]

Values = dict[str, list[float]]
"""Key of a statistic -> its values over recordings or, of a contact, over touched frames."""

SPREAD = (0.1, 0.9)
"""Quantiles that bound a spread."""


def compare_optics(
    real_folder: Path,
    *,
    clips: int,
    seed: int,
    objects: Sequence[str] = TRAINING_OBJECTS,
    preset: PresetName = "fast",
    command: str = "",
    progress: Progress = lambda what, done, total: None,
) -> RunRecord:
    """Measure real and simulated images and hold one against the other.

    Args:
        real_folder: Holds calibration/ and physiclear/.
        clips: Simulated scenes.
        seed: Root of scenes and noise.
        objects: Bodies to simulate.
        preset: How finely the contact is solved.
        command: The command line, for the record.
        progress: Told how far the run is.

    Raises:
        UnreadableClip: If the real images are missing or cannot be read.
    """
    started = time.perf_counter()
    total = len(find_real(real_folder))
    real = measured(real_touches(real_folder), lambda n: progress("real", n, total))
    scenes = simulated_touches(seed, clips, objects=objects, preset=preset)
    simulated = measured(scenes, lambda n: progress(SIMULATED, n, clips))[SIMULATED]
    numbers: dict[str, Any] = {
        "rows": _rows(real, simulated, ("camera", "idle gel", "contact")),
        "touches": _touches(real | {SIMULATED: simulated}),
        "balls": [],
    }
    diameters = sorted({size for values in real.values() for size in values.get(BALL, ())})
    if diameters:
        presses = simulated_balls(seed, clips, diameters, preset=preset)
        pressed = measured(presses, lambda n: progress("simulated balls", n, clips))[SIMULATED]
        real_balls = {name: values for name, values in real.items() if BALL in values}
        numbers["balls"] = _rows(real_balls, pressed, ("contact", "ball"))
    return RunRecord(
        name="optics",
        command=command,
        seed=seed,
        seconds=time.perf_counter() - started,
        numbers=numbers,
        config={
            "clips": clips,
            "objects": len(objects),
            "preset": preset,
            "balls_mm": diameters,
            "series": SERIES_VERSION,
            "spread": list(SPREAD),
            "threads": torch.get_num_threads(),
        },
    )


def measured(
    recordings: Iterable[Touches], tell: Callable[[int], None] = lambda done: None
) -> dict[str, Values]:
    """Return the values of every statistic by source.

    Args:
        recordings: What to measure.
        tell: Called with the number of recordings done.
    """
    found: dict[str, Values] = {}
    for done, one in enumerate(recordings, start=1):
        values = found.setdefault(one.source, {"area": [], UNTOUCHED: []})
        parts = [idle_statistics(one.idle)]
        if one.is_video:
            parts.append(camera_statistics(one.series))
        if one.halves is not None:
            parts.append(pattern_statistics(*one.halves))
        for number, frame in enumerate(one.touched):
            contact = contact_statistics(frame, one.idle)
            parts.append(contact or {UNTOUCHED: 1.0})
            if one.balls_mm:
                size = one.balls_mm[number]
                parts += [{BALL: size}, depth_statistics(contact, size, one.mm_per_px)]
        for part in parts:
            for key, value in part.items():
                values.setdefault(key, []).append(value)
        tell(done)
    return found


UNTOUCHED = "untouched"
"""Key under which touched frames are counted whose imprint is too small to be measured."""

BALL = "ball"
"""Key under which the diameters of balls are kept, mm."""

LEAST_VALUES = 3
"""A source with fewer values of a statistic is left out, unless it has no more recordings."""


def compare_values(
    real: Mapping[str, Sequence[float]], simulated: Sequence[float]
) -> dict[str, Any]:
    """Return the medians and spreads of both, and how far the simulated median is outside.

    Each real source weighs the same, however many recordings it has: sensors differ more than the
    recordings of one.

    Args:
        real: Values by source; empty where nothing was measured.
        simulated: Values.

    Returns:
        Summaries "real" and "simulated", None where there are no values; "sources", a summary of
        each; and where both are there "outside" (signed distance of the simulated median from the
        real spread, 0 inside), "share_inside" (of simulated values inside the real spread) and
        "share_covered" (of real values, each source weighing the same, inside the simulated one).
    """
    values = np.concatenate([np.asarray(one, float) for one in real.values()] or [np.empty(0)])
    weights = np.repeat([1 / len(one) for one in real.values()], [len(v) for v in real.values()])
    own = np.asarray(simulated, float)
    row: dict[str, Any] = {
        "real": _summary(values, weights),
        "simulated": _summary(own, np.ones(len(own))),
        "sources": {name: _summary(np.asarray(one, float), np.ones(len(one)))
                    for name, one in real.items()},
    }  # fmt: skip
    if row["real"] is None or row["simulated"] is None:
        return row
    low, high, median = row["real"]["low"], row["real"]["high"], row["simulated"]["median"]
    covers = (values >= row["simulated"]["low"]) & (values <= row["simulated"]["high"])
    return row | {
        "outside": min(median - low, 0.0) + max(median - high, 0.0),
        "share_inside": float(np.mean((own >= low) & (own <= high))),
        "share_covered": float(np.average(covers, weights=weights)),
    }


def _rows(
    real: Mapping[str, Values], simulated: Values, groups: Sequence[str]
) -> list[dict[str, Any]]:
    rows = []
    for key, what in STATISTICS.items():
        if what.group not in groups:
            continue
        by_source = {
            name: values[key]
            for name, values in real.items()
            if len(values.get(key, ())) >= min(LEAST_VALUES, len(values["level R"]))
        }
        row = {"key": key, "group": what.group, "title": what.title, "unit": what.unit}
        rows.append(row | compare_values(by_source, simulated.get(key, [])))
    return rows


def _summary(values: NDArray[np.float64], weights: NDArray[np.float64]) -> dict[str, Any] | None:
    if not len(values):
        return None
    quantiles = (SPREAD[0], 0.5, SPREAD[1])
    low, median, high = np.quantile(values, quantiles, weights=weights, method="inverted_cdf")
    return {"median": float(median), "low": float(low), "high": float(high), "count": len(values)}


def _touches(sources: Mapping[str, Values]) -> dict[str, dict[str, int]]:
    """Return how many recordings and touches each source has, and how many were too faint."""
    return {
        name: {
            "recordings": len(values["level R"]),
            "touches": len(values["area"]) + len(values[UNTOUCHED]),
            "faint": len(values[UNTOUCHED]),
        }
        for name, values in sources.items()
    }
