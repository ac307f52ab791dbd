"""How far: amounts the odometer tells against optical flow's, on clips whose amounts are known.

The kind of motion is given; only how far it went is asked.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from geotlm_lm.answering import Answerer, deciding_word
from geotlm_lm.answering.hearing import Heard
from geotlm_lm.answering.measuring import measured
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import IMAGE_SIDE, camera_size
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.core.record import RunRecord
from geotlm_lm.data.contents import amount_of
from geotlm_lm.data.labelled_recordings import WindowRow
from geotlm_lm.data.touch_table import TABLE_NAME, read_touch_table
from geotlm_lm.evaluation.answers import RELATIVE_TOLERANCE, TOLERANCES
from geotlm_lm.evaluation.uncertainty import clustered_interval
from geotlm_lm.experiments.cases import RealCases, SimulatedCases, real_cases
from geotlm_lm.experiments.semi_real import SemiRealSlides
from geotlm_lm.language.parse_answer import Slots
from geotlm_lm.probe.rigid_flow import RigidFlow

ODOMETER, FLOW = "odometer", "optical flow"

COLUMNS = {
    "deg": (("rotation_deg_cw",), ("rotation_deg_cw_search",), ("rotation_deg_cw_cumulative",)),
    "px": (("dx_px", "dy_px"), ("dx_px_cumulative", "dy_px_cumulative")),
}
"""Columns of a table of windows that tell how far, and those of measurements beside the first."""

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True, eq=False)
class Moved:
    """A clip and how far its imprint went.

    Args:
        clip: Four frames with a background.
        unit: "deg" of a turn, "px" of the clip's own frames of a slide.
        amount: How far, at least 0.
        motion: Which way, which is not asked.
        family: Objects that are not independent of each other.
    """

    clip: Clip
    unit: str
    amount: float
    motion: Motion
    family: str

    @property
    def least(self) -> float:
        """Error that counts as right however small the amount; pixels are of a 224-pixel image."""
        rows, columns = self.clip.frames.shape[1:3]
        side = rows if self.motion in (Motion.UP, Motion.DOWN) else columns
        return TOLERANCES[self.unit] * (side / IMAGE_SIDE if self.unit == "px" else 1.0)


@dataclass(frozen=True)
class Told:
    """What a method tells of one clip.

    Args:
        value: The amount.
        low: Lower end of the span it says the amount is in; None where it says none.
        high: Its upper end.
        probability: That the amount is within tolerance; None where it says none.
    """

    value: float
    low: float | None = None
    high: float | None = None
    probability: float | None = None


def how_far(
    answerer: Answerer,
    *,
    clips: int,
    seed: int,
    real_folder: Path | None = None,
    command: str = "",
    progress: Progress = lambda what, done, total: None,
) -> RunRecord:
    """Hold the odometer and optical flow against known amounts.

    Args:
        answerer: The model.
        clips: Simulated clips per task.
        seed: Root of the clips.
        real_folder: Folder of labelled recordings; see `evaluate`.
        command: The command line, for the record.
        progress: Told how many clips of how many sources are done.
    """
    started, numbers = time.perf_counter(), {}
    sources = simulated(clips, seed)
    if real_folder is not None:
        sources |= real(real_folder, seed)
    for place, (title, found) in enumerate(sources.items()):
        progress(title, place, len(sources))
        rows = [(one, tell(answerer, one), flow_tells(one)) for one in found()]
        if rows:
            numbers[title] = {
                "unit": rows[0][0].unit,
                ODOMETER: scores([one for one, *_ in rows], [said for _, said, _ in rows], seed),
                FLOW: scores([one for one, *_ in rows], [said for *_, said in rows], seed),
            }
    return RunRecord(
        name="odometry",
        command=command,
        seed=seed,
        seconds=round(time.perf_counter() - started, 1),
        numbers=numbers,
        config={
            "clips": clips,
            "real": real_folder is not None,
            "bundle": answerer.bundle.digest(),
        },
    )


def simulated(clips: int, seed: int) -> dict[str, Callable[[], Iterator[Moved]]]:
    """Return what simulated clips of everyday objects there are, by title."""

    def moved(cases: SimulatedCases) -> Iterator[Moved]:
        for made in cases.made():
            unit = "deg" if made.label.motion in ROTATIONS else "px"
            label = made.label
            yield Moved(made.clip, unit, amount_of(label), label.motion, made.object_name)

    return {
        cases.title: lambda cases=cases: moved(cases)
        for is_unsteady in (False, True)
        for task in ("rotation", "sliding")
        for cases in [SimulatedCases(task, clips, seed, is_unsteady)]
    }


def real(folder: Path, seed: int) -> dict[str, Callable[[], Iterator[Moved]]]:
    """Return the recordings whose tables tell how far, and semi-real slides, by title."""
    sources: dict[str, Callable[[], Iterator[Moved]]] = {}
    for name, cases in real_cases(folder).items():
        for unit, kind in (("deg", "rotation"), ("px", "sliding")):
            rows = tuple(row for row in cases.recordings.rows if known_amount(row, unit))
            if rows:
                known = RealCases(replace(cases.recordings, rows=rows))
                sources[f"real {name}, {kind}"] = lambda known=known, unit=unit: _windows(
                    known, unit
                )
        if touched := read_touch_table(cases.recordings.folder / TABLE_NAME):
            sources[f"semi-real {name}, sliding"] = lambda rows=touched: (
                Moved(case.clip, "px", travel_px, case.motion, case.family)
                for case, travel_px in SemiRealSlides(rows, seed).made()
            )
    return sources


def known_amount(row: WindowRow, unit: str) -> float | None:
    """Return how far a labelled window goes; None where its table does not tell.

    Amounts of recordings are measurements too. Where a second one stands beside the first, the two
    have to agree to within 2 degrees, 2 pixels of the recording, or a fifth.
    """
    if row.motion not in (ROTATIONS if unit == "deg" else SLIDES):
        return None
    first, *others = (_length(row.values, columns) for columns in COLUMNS[unit])
    if not first:
        return None
    allowed = max(TOLERANCES[unit], RELATIVE_TOLERANCE * first)
    return first if all(one is None or abs(one - first) <= allowed for one in others) else None


def tell(answerer: Answerer, moved: Moved) -> Told:
    """Return what the odometer tells of a clip whose kind of motion is given."""
    slots = Slots("magnitude", unit=moved.unit)
    heard = Heard(slots, "", {deciding_word(slots): 1.0})
    amount = measured(answerer.bundle, answerer.encode(moved.clip), heard, FrameSpec())
    return Told(amount.value, amount.low, amount.high, amount.probability)


def flow_tells(moved: Moved) -> Told:
    """Return what the rigid motion that fits optical flow best tells."""
    found = RigidFlow().fit(moved.clip)
    if moved.unit == "deg":
        return Told(abs(found.rotation_deg))
    rows, columns = moved.clip.frames.shape[1:3]
    camera_rows, camera_columns = camera_size(rows, columns)
    x, y = found.slide_x_px * columns / camera_columns, found.slide_y_px * rows / camera_rows
    return Told(float(np.hypot(x, y)))


def scores(clips: list[Moved], told: list[Told], seed: int) -> dict[str, Any]:
    """Return how near a method's amounts are to the true ones, intervals clustered by family."""
    pairs = list(zip(clips, told, strict=True))
    right = np.array([is_within_tolerance(one, said.value) for one, said in pairs])
    ratio = np.array([said.value / one.amount for one, said in pairs])
    spans = [said.low <= one.amount <= said.high for one, said in pairs if said.low is not None]
    odds = [said.probability for said in told if said.probability is not None]
    low, high = clustered_interval(right, [one.family for one in clips], seed=seed)
    return {
        "clips": len(clips),
        "in_tolerance": float(right.mean()),
        "interval": [low, high],
        "median_error": float(np.median(np.abs(ratio - 1))),
        "median_ratio": float(np.median(ratio)),
        "in_span": float(np.mean(spans)) if spans else None,
        "mean_probability": float(np.mean(odds)) if odds else None,
    }


def is_within_tolerance(moved: Moved, value: float) -> bool:
    """Tell whether an amount is right as an answer is."""
    allowed = max(moved.least, RELATIVE_TOLERANCE * moved.amount)
    return bool(abs(value - moved.amount) <= allowed)


def _windows(cases: RealCases, unit: str) -> Iterator[Moved]:
    for window in cases.recordings.windows(frames=("four",), backwards=True):
        amount = known_amount(window.row, unit)
        yield Moved(window.clip, unit, amount, window.motion, window.row.object_family)


def _length(values: Mapping[str, str], columns: tuple[str, ...]) -> float | None:
    """Return the length of a row's entries, None where one is missing or no number."""
    try:
        return math.hypot(*(float(values[name]) for name in columns))
    except (KeyError, ValueError):
        return None
