"""How far: amounts that are believed beside two rivals', on clips whose amounts are known."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from geotlm_lm.answering import Answerer
from geotlm_lm.answering.evidence_of import recording_of
from geotlm_lm.benchmarks.cases.semi_real import SemiRealSlides
from geotlm_lm.benchmarks.cases.simulated import SimulatedCases
from geotlm_lm.benchmarks.halves import by_half, recordings_by_half, rows_of_half, titled
from geotlm_lm.benchmarks.rendering import number, right_with_interval
from geotlm_lm.benchmarks.rows import Listing, Row, Run, Section
from geotlm_lm.benchmarks.statistics import share_row
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import IMAGE_SIDE, camera_size
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.core.tolerance import within_tolerance
from geotlm_lm.core.twist import Component
from geotlm_lm.data.labelled_recordings import LabelledRecordings, WindowRow
from geotlm_lm.data.question_contents import amount_of
from geotlm_lm.data.touch_table import TABLE_NAME, read_touch_table
from geotlm_lm.probe.rigid_alignment import RigidAlignment
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.query.amounts import Measure, measure

ABOUT = """\
The kind of motion is given; only how far it went from the first to the last frame is asked. An
amount is right if it is off by 2 degrees, 2 pixels of a 224-pixel image, or a fifth of the true
one, at most; *off by* is relative to the true one. The belief also tells a span meant to hold
nine tenths of the true amounts, and how probable its amount is right. Simulated and semi-real
amounts are exact. Those of real windows were measured from the images: where two measurements
differ by more than the tolerance the window is left out, and on gels with markers they are how far
the markers went, which lag behind the object. Intervals resample families of objects."""

CLIPS, BELIEF = 300, "belief"

RIVALS = {"optical flow": RigidFlow(), "direct alignment": RigidAlignment()}

Unit = Literal["deg", "px"]
UNITS: dict[str, Unit] = {"rotation": "deg", "sliding": "px"}

COLUMNS: dict[Unit, tuple[tuple[str, ...], ...]] = {
    "deg": (("rotation_deg_cw",), ("rotation_deg_cw_search",), ("rotation_deg_cw_cumulative",)),
    "px": (("dx_px", "dy_px"), ("dx_px_cumulative", "dy_px_cumulative")),
}
"""Columns of a table of windows that tell how far, and those of measurements beside the first."""


@dataclass(frozen=True, eq=False)
class Moved:
    """A clip of four frames whose imprint goes `amount` degrees, or pixels of its own frames."""

    clip: Clip
    unit: Unit
    amount: float
    motion: Motion
    family: str

    def is_right(self, told: float) -> bool:
        """Tell whether an amount is within tolerance, pixels being those of a 224-pixel image."""
        rows, columns = self.clip.frames.shape[1:3]
        side = rows if self.motion in (Motion.UP, Motion.DOWN) else columns
        scale = side / IMAGE_SIDE if self.unit == "px" else 1.0
        return within_tolerance(told / scale, self.amount / scale, self.unit)


def amount_rows(run: Run) -> Iterator[Row]:
    """Yield a row of the belief and of each rival for each source of clips."""
    for title, clips in sources(run):
        run.progress(f"how far, {title}", 0, 1)
        told: dict[str, list[tuple[Moved, Measure | float]]] = {}
        for one in clips:
            told.setdefault(BELIEF, []).append((one, belief_tells(run.answerer, one)))
            for name, rival in RIVALS.items():
                told.setdefault(name, []).append((one, rival_tells(rival, one)))
        for method, pairs in told.items():
            yield scored(title, method, pairs, run.seed)


def sources(run: Run) -> Iterator[tuple[str, Iterator[Moved]]]:
    """Yield titles and clips: simulated, real windows whose tables tell how far, semi-real."""
    few = slice(run.size(None, 2))
    for task, unit in UNITS.items():
        cases = SimulatedCases(task, run.size(CLIPS, 4), run.seed)
        yield f"simulated {task}", _simulated(cases, unit)
    for name, half, real in recordings_by_half(run.real):
        for task, unit in UNITS.items():
            rows = tuple(row for row in real.rows if known_amount(row, unit))[few]
            windows = _windows(replace(real, rows=rows), unit)
            yield titled(f"real {name}, {task}", half), windows
        touched = read_touch_table(real.folder / TABLE_NAME)
        slides = SemiRealSlides(rows_of_half(touched, half)[few], run.seed).made()
        moved = (Moved(one.clip, "px", way, one.motion, one.family) for one, way in slides)
        yield titled(f"semi-real {name}, sliding", half), moved


def _simulated(cases: SimulatedCases, unit: Unit) -> Iterator[Moved]:
    for made in cases.made():
        yield Moved(made.clip, unit, amount_of(made.label), made.label.motion, made.object_name)


def _windows(recordings: LabelledRecordings, unit: Unit) -> Iterator[Moved]:
    for one in recordings.windows(frames=("four",), backwards=True):
        amount = known_amount(one.row, unit)
        yield Moved(one.clip, unit, amount, one.motion, one.row.object_family)


def known_amount(row: WindowRow, unit: Unit) -> float | None:
    """Return how far a labelled window goes; None where its table does not tell.

    Where a second measurement stands beside the first, the two have to agree within tolerance.
    """

    def length(columns: tuple[str, ...]) -> float | None:
        try:
            return math.hypot(*(float(row.values[name]) for name in columns))
        except (KeyError, ValueError):
            return None

    if row.motion not in (ROTATIONS if unit == "deg" else SLIDES):
        return None
    first, *others = map(length, COLUMNS[unit])
    agree = first and all(one is None or within_tolerance(one, first, unit) for one in others)
    return first if agree else None


def belief_tells(answerer: Answerer, moved: Moved) -> Measure:
    """Return what is believed of a clip whose kind of motion is given."""
    component = Component.TURN if moved.unit == "deg" else Component.SLIDE
    encoded = answerer.encode(moved.clip)
    return measure(component.value, encoded.belief, FrameSpec(), recording_of(encoded))


def rival_tells(rival: RigidFlow | RigidAlignment, moved: Moved) -> float:
    """Return what the rigid motion that a rival fits tells."""
    found = rival.fit(moved.clip)
    if moved.unit == "deg":
        return abs(found.rotation_deg)
    rows, columns = moved.clip.frames.shape[1:3]
    camera_rows, camera_columns = camera_size(rows, columns)
    x, y = found.slide_x_px * columns / camera_columns, found.slide_y_px * rows / camera_rows
    return float(np.hypot(x, y))


def scored(
    case: str, variant: str, pairs: Sequence[tuple[Moved, Measure | float]], seed: int
) -> Row:
    """Return how near told amounts are to the true ones; the belief's also say how sure."""
    values = [told if isinstance(told, float) else told.value for _, told in pairs]
    right = [one.is_right(value) for (one, _), value in zip(pairs, values, strict=True)]
    off_by = np.abs(np.array(values) / [one.amount for one, _ in pairs] - 1)
    detail = {"unit": pairs[0][0].unit, "off_by": float(np.median(off_by))}
    sure = [(one.amount, told) for one, told in pairs if not isinstance(told, float)]
    if sure:
        detail["in_span"] = float(np.mean([_holds(told, true) for true, told in sure]))
        detail["mean_probability"] = float(np.mean([told.probability for _, told in sure]))
    families = [one.family for one, _ in pairs]
    return share_row(case, variant, right, families, seed, detail=detail)


def _holds(told: Measure, true: float) -> bool:
    low, high = told.span
    return low <= true <= high


_COLUMNS = {
    "clips": lambda row: row.case,
    "method": lambda row: row.variant,
    "n": lambda row: str(row.count),
    "unit": lambda row: row.detail["unit"],
    "right (95 %)": right_with_interval,
    "off by, median": lambda row: f"{row.detail['off_by']:.0%}",
    "span holds it": lambda row: number(row.detail.get("in_span")),
    "mean probability": lambda row: number(row.detail.get("mean_probability")),
}

AMOUNTS = Section(
    name="amounts",
    title="How far it goes",
    about=ABOUT,
    run=amount_rows,
    views=by_half(Listing(_COLUMNS)),
)
