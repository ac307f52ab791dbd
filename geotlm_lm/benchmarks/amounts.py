"""Components and amounts: turn, slide and press at once, and how far a single motion went.

Mixed motions are simulated and graded component by component; amounts are asked of clips whose
amounts are known.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from geotlm_lm.answering.encoded import recording_of
from geotlm_lm.benchmarks.candidates import twists_of
from geotlm_lm.benchmarks.cases import (
    MIXED_CLIPS,
    TASKS,
    by_half,
    recordings_by_half,
    rows_of_half,
    simulated_cases,
    simulated_mixtures,
    titled,
)
from geotlm_lm.benchmarks.harness import Listing, Pivot, Row, Run, Section, whole
from geotlm_lm.benchmarks.imprints import semi_real_slides
from geotlm_lm.benchmarks.judging import Case, Graded, share_row, share_rows
from geotlm_lm.benchmarks.rendering import right_with_interval
from geotlm_lm.benchmarks.variants import BELIEF, FITS, GENERATED, RIVALS, on_gel, question_for
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import IMAGE_SIDE, camera_size
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, MotionLabel, signed_amount
from geotlm_lm.core.tolerance import within_tolerance
from geotlm_lm.core.twist import (
    BARELY_MM,
    BARELY_PX,
    COMPONENT_OF,
    COMPONENTS,
    MOVING_MM,
    MOVING_PX,
    Component,
    Twist,
)
from geotlm_lm.data.labelled_recordings import LabelledRecordings, WindowRow
from geotlm_lm.data.touch_table import TABLE_NAME, read_touch_table
from geotlm_lm.probe.rigid_alignment import RigidAlignment
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.query.values import Measure, measure
from geotlm_lm.simulation.gels import HELD_OUT_GELS, TRAINING_GELS
from geotlm_lm.simulation.truth import components_of, twist_of

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer, Encoded
    from geotlm_lm.motion.belief import Belief

CLIPS = 300

UNITS = {Component.TURN: "deg", Component.SLIDE: "px", Component.PRESS: "mm"}

OPEN_QUESTIONS = {
    Component.TURN: question_for(ROTATIONS),
    Component.SLIDE: question_for(SLIDES),
}

CLAIMS = {Motion.PRESS: "Is it pressing in?", Motion.RELEASE: "Is it lifting off?"}
"""A press has two ways and no question of its own."""

LEAST_COSINE = math.cos(math.radians(45)) - 1e-9
"""Of the angle between a predicted way and the true one."""

NINE_IN_TEN = 1.6448536269514722
"""Deviations of a normal spread on either side that hold nine in ten."""

MIXTURE_GELS = {
    "simulated mixtures": None,
    "simulated mixtures, gels in training": TRAINING_GELS,
    "simulated mixtures, gels left out": HELD_OUT_GELS,
}
"""Mixtures on a GelSight Mini, and on the kinds of gel that training saw and did not see."""

COLUMNS: dict[str, tuple[tuple[str, ...], ...]] = {
    "rotation": (
        ("rotation_deg_cw",),
        ("rotation_deg_cw_search",),
        ("rotation_deg_cw_cumulative",),
    ),
    "sliding": (("dx_px", "dy_px"), ("dx_px_cumulative", "dy_px_cumulative")),
}
"""Columns of a table of windows that tell how far, and those of measurements beside the first."""


@dataclass(frozen=True)
class Prediction:
    """What a method says of each component of a clip; those it cannot tell of are left out.

    `ways` are vectors whose length means nothing, `amounts` in `UNITS`, and nine times in ten an
    amount lies in its span.
    """

    ways: Mapping[Component, tuple[float, ...]]
    amounts: Mapping[Component, float] = field(default_factory=dict)
    spans: Mapping[Component, tuple[float, float]] = field(default_factory=dict)
    counting: Mapping[Component, bool] = field(default_factory=dict)


def grades(label: MotionLabel, predicted: Prediction) -> Iterator[tuple[str, bool]]:
    """Yield what is graded of a clip, such as "turn: way", and whether it is right.

    What moves only barely is graded apart, as "turn: way, 0.3 to 1 px".
    """
    twist = twist_of(label)
    ways, both, sizes = _parts(twist), [], []
    for part, truth in components_of(label).items():
        is_counting = truth.moves
        if is_counting is None or (is_counting and not truth.is_visible):
            continue
        size = _size(part, twist.path(part, label.radius_px)) if is_counting else ""
        if part in predicted.counting:
            yield f"{part}: counts{size}", predicted.counting[part] == is_counting
        if is_counting and part in predicted.ways:
            is_right = _cosine(predicted.ways[part], ways[part]) >= LEAST_COSINE
            if part is not Component.PRESS:
                both.append(is_right and predicted.counting.get(part, True))
                sizes.append(size)
            yield f"{part}: way{size}", is_right
        amount = math.hypot(*ways[part])
        if is_counting and part in predicted.amounts:
            is_near = within_tolerance(predicted.amounts[part], amount, UNITS[part])
            yield f"{part}: how far{size}", is_near
        if is_counting and part in predicted.spans:
            low, high = predicted.spans[part]
            yield f"{part}: span{size}", low <= amount <= high
    if len(both) == 2:
        yield f"turn and slide: both ways{max(sizes)}", all(both)


def _size(part: Component, path: float) -> str:
    """Return what is added to the name of what is graded of a component that moves barely."""
    if part is Component.PRESS:
        return f", {MOVING_MM:g} to {BARELY_MM:g} mm" if path < BARELY_MM else ""
    return f", {MOVING_PX:g} to {BARELY_PX:g} px" if path < BARELY_PX else ""


def _parts(twist: Twist) -> dict[Component, tuple[float, ...]]:
    """Return a twist by its components: degrees, pixels right and down, mm."""
    slide = (twist.right_px, twist.down_px)
    parts = ((twist.turn_deg,), slide, (twist.inward_mm,))
    return dict(zip(COMPONENTS, parts, strict=True))


def _toward(way: Motion) -> tuple[float, ...]:
    """Return a way as a vector: a slide's right and down, of the others a sign."""
    axes = dict.fromkeys(("turn", "right", "down", "inward"), 0.0)
    along = [signed_amount(way, **axes | {axis: 1.0}) for axis in axes]
    return _parts(Twist(*along))[COMPONENT_OF[way]]


def _cosine(first: tuple[float, ...], second: tuple[float, ...]) -> float:
    """Return that of the angle between two vectors; -1 where either has no length."""
    lengths = math.hypot(*first) * math.hypot(*second)
    return sum(map(operator.mul, first, second)) / lengths if lengths > 0 else -1.0


def belief_prediction(belief: Belief) -> Prediction:
    """Return what a belief says: of turn and press the likelier way, of a slide its heading."""
    amounts = {part: belief.amount(part) for part in COMPONENTS}
    far = {part: NINE_IN_TEN * belief.deviation(part) for part in COMPONENTS}
    signs = {part: _toward(belief.way(part)) for part in (Component.TURN, Component.PRESS)}
    return Prediction(
        ways=_parts(belief.mean) | signs,
        amounts=amounts,
        spans={part: (amounts[part] - far[part], amounts[part] + far[part]) for part in COMPONENTS},
        counting={part: belief.moves(part) >= 0.5 for part in COMPONENTS},
    )


def words_prediction(answerer: Answerer, encoded: Encoded) -> Prediction:
    """Return what words say of each component when they are asked about it."""
    named = {part: answerer.ask(encoded, q).in_the_image for part, q in OPEN_QUESTIONS.items()}
    claims = (way for way, q in CLAIMS.items() if answerer.ask(encoded, q).decided == "yes")
    named[Component.PRESS] = next(claims, None)
    counting = {part: COMPONENT_OF.get(way) is part for part, way in named.items()}
    ways = {part: _toward(way) if counting[part] else (0.0,) for part, way in named.items()}
    return Prediction(ways, counting=counting)


def _rigid(twist: Twist) -> Prediction:
    """Return what a turn and a slide say, of which nobody tells whether they count."""
    ways = _parts(twist)
    del ways[Component.PRESS]
    return Prediction(ways, {part: math.hypot(*way) for part, way in ways.items()})


def fitted_twist(rival: RigidFlow | RigidAlignment, clip: Clip) -> Twist:
    """Return the rigid motion that a rival fits, in pixels of the 224-pixel image."""
    fit = rival.fit(on_gel(clip))
    rows, columns = camera_size(*clip.frames.shape[1:3])
    right, down = fit.slide_x_px * IMAGE_SIDE / columns, fit.slide_y_px * IMAGE_SIDE / rows
    return Twist(fit.rotation_deg, right, down)


def all_twists(encoded: Encoded, clip: Clip) -> dict[str, Twist]:
    """Return the motion of a clip by each measurement and each rival."""
    return twists_of(encoded) | {name: fitted_twist(fit, clip) for name, fit in FITS.items()}


def mixture_rows(run: Run) -> list[Row]:
    """Return one row for each thing graded, kinds of gel and method."""
    count = run.size(MIXED_CLIPS, 6)

    def graded(title: str, gels: Mapping[str, float] | None) -> Iterator[Graded]:
        for done, made in enumerate(simulated_mixtures(count, run.seed, gels), start=1):
            try:
                encoded = run.answerer.encode(made.clip)
            except UnreadableClip:  # a dark gel that is covered from rim to rim
                yield f"{title}, clips that are read", BELIEF, False, made.object_name
                continue
            yield f"{title}, clips that are read", BELIEF, True, made.object_name
            predictions = {
                BELIEF: belief_prediction(encoded.belief),
                GENERATED: words_prediction(run.answerer, encoded),
            }
            named = dict(zip(FITS, RIVALS, strict=True))
            for name, twist in all_twists(encoded, made.clip).items():
                predictions[named.get(name, name)] = _rigid(twist)
            for name, predicted in predictions.items():
                for what, is_right in grades(made.label, predicted):
                    yield f"{title}, {what}", name, is_right, made.object_name
            run.progress(title, done, count)

    rows = [row for case in MIXTURE_GELS.items() for row in share_rows(graded(*case), run.seed)]
    return sorted(rows, key=lambda row: row.case)


def amount_rows(run: Run) -> Iterator[Row]:
    """Yield a row of the belief, each candidate and each rival for each source of clips."""
    for title, cases in _sources(run):
        run.progress(f"how far, {title}", 0, 1)
        answers: dict[str, list[tuple[Case, Measure | float]]] = {}
        for case in cases:
            encoded, component = run.answerer.encode(case.clip), COMPONENT_OF[case.motion].value
            amount = measure(component, encoded.belief, FrameSpec(), recording_of(encoded))
            answers.setdefault(BELIEF, []).append((case, amount))
            for name, twist in all_twists(encoded, case.clip).items():
                answers.setdefault(name, []).append((case, amount_in(case, twist)))
        for method, pairs in answers.items():
            yield amount_row(title, method, pairs, run.seed)


def _sources(run: Run) -> Iterator[tuple[str, Iterator[Case]]]:
    """Yield titles and clips: simulated, real windows whose tables tell how far, semi-real."""
    few = slice(run.size(None, 2))
    for task in COLUMNS:
        yield f"simulated {task}", simulated_cases(task, run.size(CLIPS, 4), run.seed)
    for name, half, real in recordings_by_half(run.real):
        for task in COLUMNS:
            rows = tuple(row for row in real.rows if known_amount(row, task))[few]
            windows = _windows(replace(real, rows=rows), task)
            yield titled(f"real {name}, {task}", half), windows
        touched = rows_of_half(read_touch_table(real.folder / TABLE_NAME), half)[few]
        yield titled(f"semi-real {name}, sliding", half), semi_real_slides(touched, run.seed)


def _windows(recordings: LabelledRecordings, task: str) -> Iterator[Case]:
    for window in recordings.windows(frames=("four",), backwards=True):
        row = window.row
        amount = known_amount(row, task)
        yield Case(window.clip, window.motion, row.object_family, amount=amount)


def known_amount(row: WindowRow, task: str) -> float | None:
    """Return how far a labelled window goes; None where its table does not tell.

    Where a second measurement stands beside the first, the two have to agree within tolerance.
    """

    def length(columns: tuple[str, ...]) -> float | None:
        try:
            return math.hypot(*(float(row.values[name]) for name in columns))
        except (KeyError, ValueError):
            return None

    if row.motion not in TASKS[task]:
        return None
    first, *others = map(length, COLUMNS[task])
    unit = unit_of(row.motion)
    agree = first and all(x is None or within_tolerance(x, first, unit) for x in others)
    return first if agree else None


def unit_of(motion: Motion) -> str:
    """Return the unit of how far a turn or a slide goes."""
    return UNITS[COMPONENT_OF[motion]]


def is_near(case: Case, value: float) -> bool:
    """Whether an amount is within tolerance, pixels being those of a 224-pixel image."""
    rows, columns = case.clip.frames.shape[1:3]
    side = rows if case.motion in (Motion.UP, Motion.DOWN) else columns
    scale = side / IMAGE_SIDE if case.motion in SLIDES else 1.0
    return within_tolerance(value / scale, case.amount / scale, unit_of(case.motion))


def amount_in(case: Case, twist: Twist) -> float:
    """Return how far a motion in pixels of the 224-pixel image goes in a clip's own frames."""
    rows, columns = (side / IMAGE_SIDE for side in case.clip.frames.shape[1:3])
    slide = math.hypot(twist.right_px * columns, twist.down_px * rows)
    return abs(twist.turn_deg) if case.motion in ROTATIONS else slide


def amount_row(
    case: str, variant: str, pairs: Sequence[tuple[Case, Measure | float]], seed: int
) -> Row:
    """Return how near amounts are to the true ones; the belief's also say how sure."""
    values = [answer if isinstance(answer, float) else answer.value for _, answer in pairs]
    right = [is_near(own, value) for (own, _), value in zip(pairs, values, strict=True)]
    off_by = np.abs(np.array(values) / [own.amount for own, _ in pairs] - 1)
    detail = {"unit": unit_of(pairs[0][0].motion), "off_by": float(np.median(off_by))}
    sure = [(own.amount, answer) for own, answer in pairs if not isinstance(answer, float)]
    if sure:
        is_held = [low <= amount <= high for amount, m in sure for low, high in [m.span]]
        detail["in_span"] = float(np.mean(is_held))
        detail["mean_probability"] = float(np.mean([m.probability for _, m in sure]))
    families = [own.family for own, _ in pairs]
    return share_row(case, variant, right, families, seed, detail=detail)


_COLUMNS = {
    "clips": "case",
    "method": "variant",
    "n": "count",
    "unit": "unit",
    "right (95 %)": right_with_interval,
    "off by, median": "off_by:.0%",
    "span holds it": "in_span:.3f",
    "mean probability": "mean_probability:.3f",
}

MIXTURES = Section(
    name="mixtures",
    title="Turn, slide and press at once",
    about="""\
Everyday objects that turn, slide and press freely at once: on a GelSight Mini, and on gels of the
kinds in training and of those left out of it. Of each component that moves and shows,
the *way* is right with the sign of a turn or a press, and of a slide with a heading at most 45
degrees off; *how far* within 2 degrees, 2 pixels, 0.2 mm or a fifth; the *span*, nine in ten, holds
the truth. *Counts* is whether a component is told where it moves and not told where it does not;
what moves too little, or hardly shows, is left out; what moves barely is graded apart, by
its true path. *Both ways* needs a turn and a slide told, each the right way. Words are asked about
each component apart.""",
    shares=whole(mixture_rows),
    views={"": Pivot(right_with_interval, "clips, what is graded")},
)

AMOUNTS = Section(
    name="amounts",
    title="How far it goes",
    about="""\
The kind of motion is given; only how far it went from the first to the last frame is asked. An
amount is right if it is off by 2 degrees, 2 pixels of a 224-pixel image, or a fifth of the true
one, at most; *off by* is relative to the true one. The belief also tells a span meant to hold
nine tenths of the true amounts, and how probable its amount is right. Simulated and semi-real
amounts are exact. Those of real windows were measured from the images: where two measurements
differ by more than the tolerance the window is left out, and on gels with markers they are how far
the markers went, which lag behind the object. Intervals resample families of objects.""",
    shares=whole(amount_rows),
    views=by_half(Listing(_COLUMNS)),
)
