"""Turn, slide and press at once: what is told of each component of simulated mixed motions."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from geotlm_lm.benchmarks.rendering import right_with_interval
from geotlm_lm.benchmarks.rows import Pivot, Row, Run, Section, every
from geotlm_lm.benchmarks.statistics import Tally
from geotlm_lm.benchmarks.variants import ALIGNMENT, FLOW, GENERATED, question_for
from geotlm_lm.core.geometry import IMAGE_SIDE, camera_size
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, MotionLabel, signed_amount
from geotlm_lm.core.numbers import seed_for
from geotlm_lm.core.tolerance import within_tolerance
from geotlm_lm.core.twist import COMPONENT_OF, COMPONENTS, Component, Twist
from geotlm_lm.probe.rigid_alignment import RigidAlignment
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS
from geotlm_lm.simulation.simulate import simulate_series
from geotlm_lm.simulation.truth import components_of, twist_of

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer, Encoded
    from geotlm_lm.core.clip import Clip
    from geotlm_lm.motion.belief import Belief

ABOUT = """\
Everyday objects that turn, slide and press freely at once. Of each component that counts and shows,
the *way* is right with the sign of a turn or a press, and of a slide with a heading at most 45
degrees off; *how far* within 2 degrees, 2 pixels, 0.2 mm or a fifth; the *span*, nine in ten, holds
the truth. *Counts* is whether a component is told where it counts and not told where it does not;
what is ambiguous, or counts and hardly shows, is left out. *Both ways* needs a turn and a slide
told, each the right way. Words are asked about each component apart."""

CLIPS, BELIEF = 600, "belief"

UNITS = {Component.TURN: "deg", Component.SLIDE: "px", Component.PRESS: "mm"}

QUESTIONS = {
    Component.TURN: question_for(ROTATIONS),
    Component.SLIDE: question_for(SLIDES),
}

CLAIMS = {Motion.PRESS: "Is it pressing in?", Motion.RELEASE: "Is it lifting off?"}
"""A press has two ways and no question of its own."""

LEAST_COSINE = math.cos(math.radians(45)) - 1e-9
"""Of the angle between a way that is told and the true one."""

NINE_IN_TEN = 1.6448536269514722
"""Deviations of a normal spread on either side that hold nine in ten."""


@dataclass(frozen=True)
class Told:
    """What a method tells of a clip; a component it cannot tell of is in none of these.

    Args:
        ways: Where each component goes, as a vector whose length means nothing.
        amounts: How far, in `UNITS`.
        spans: From where to where each amount lies nine times in ten.
        counting: Whether each component counts.
    """

    ways: Mapping[Component, tuple[float, ...]]
    amounts: Mapping[Component, float] = field(default_factory=dict)
    spans: Mapping[Component, tuple[float, float]] = field(default_factory=dict)
    counting: Mapping[Component, bool] = field(default_factory=dict)


def grades(label: MotionLabel, told: Told) -> Iterator[tuple[str, bool]]:
    """Yield what is graded of a clip, such as "turn: way", and whether it is right."""
    ways, both = _parts(twist_of(label)), []
    for one, truth in components_of(label).items():
        is_counting = truth.counts
        if is_counting is None or (is_counting and not truth.is_visible):
            continue
        if one in told.counting:
            yield f"{one}: counts", told.counting[one] == is_counting
        if is_counting and one in told.ways:
            is_right = _cosine(told.ways[one], ways[one]) >= LEAST_COSINE
            both += [is_right and told.counting.get(one, True)] * (one is not Component.PRESS)
            yield f"{one}: way", is_right
        amount = math.hypot(*ways[one])
        if is_counting and one in told.amounts:
            yield f"{one}: how far", within_tolerance(told.amounts[one], amount, UNITS[one])
        if is_counting and one in told.spans:
            low, high = told.spans[one]
            yield f"{one}: span", low <= amount <= high
    if len(both) == 2:
        yield "turn and slide: both ways", all(both)


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


def _cosine(told: tuple[float, ...], true: tuple[float, ...]) -> float:
    """Return that of the angle between two vectors; -1 where one has no length."""
    lengths = math.hypot(*told) * math.hypot(*true)
    return sum(map(operator.mul, told, true)) / lengths if lengths > 0 else -1.0


def belief_tells(belief: Belief) -> Told:
    """Return what a belief tells: of turn and press the likelier way, of a slide its heading."""
    amounts = {one: belief.amount(one) for one in COMPONENTS}
    far = {one: NINE_IN_TEN * belief.deviation(one) for one in COMPONENTS}
    signs = {one: _toward(belief.way(one)) for one in (Component.TURN, Component.PRESS)}
    return Told(
        ways=_parts(belief.mean) | signs,
        amounts=amounts,
        spans={one: (amounts[one] - far[one], amounts[one] + far[one]) for one in COMPONENTS},
        counting={one: belief.counts(one) >= 0.5 for one in COMPONENTS},
    )


def words_tell(answerer: Answerer, encoded: Encoded) -> Told:
    """Return what words say of each component when they are asked about it."""
    told = {one: answerer.ask(encoded, asked).in_the_image for one, asked in QUESTIONS.items()}
    claims = (way for way, said in CLAIMS.items() if answerer.ask(encoded, said).decided == "yes")
    told[Component.PRESS] = next(claims, None)
    counting = {one: COMPONENT_OF.get(way) is one for one, way in told.items()}
    ways = {one: _toward(way) if counting[one] else (0.0,) for one, way in told.items()}
    return Told(ways, counting=counting)


def rival_tells(rival: RigidFlow | RigidAlignment, clip: Clip) -> Told:
    """Return what a rigid fit tells of turn and slide; it has no opinion on what counts."""
    found = rival.fit(clip)
    rows, columns = camera_size(*clip.frames.shape[1:3])
    right, down = found.slide_x_px * IMAGE_SIDE / columns, found.slide_y_px * IMAGE_SIDE / rows
    ways = _parts(Twist(found.rotation_deg, right, down))
    del ways[Component.PRESS]
    return Told(ways, {one: math.hypot(*way) for one, way in ways.items()})


def all_told(answerer: Answerer, clip: Clip) -> dict[str, Told]:
    """Return what every method tells of a clip."""
    encoded = answerer.encode(clip)
    return {
        BELIEF: belief_tells(encoded.belief),
        GENERATED: words_tell(answerer, encoded),
        FLOW: rival_tells(RigidFlow(), clip),
        ALIGNMENT: rival_tells(RigidAlignment(), clip),
    }


def mixture_rows(run: Run) -> list[Row]:
    """Return one row for each thing graded and method."""
    count, tally = run.size(CLIPS, 6), Tally()
    series = simulate_series(
        seed_for(run.seed, "evaluation", "mixtures"),
        count,
        objects=EVERYDAY_OBJECTS,
        motions=[motion for motion in Motion if motion is not Motion.NONE],
        mixed_share=1.0,
    )
    for done, made in enumerate(series, start=1):
        for name, told in all_told(run.answerer, made.clip).items():
            for graded, is_right in grades(made.label, told):
                tally.add(f"simulated mixtures, {graded}", name, is_right, made.object_name)
        run.progress("simulated mixtures", done, count)
    return sorted(tally.rows(run.seed), key=lambda row: row.case)


MIXTURES = Section(
    name="mixtures",
    title="Turn, slide and press at once",
    about=ABOUT,
    run=mixture_rows,
    views={"": (Pivot(right_with_interval, "clips, what is graded"), every)},
)
