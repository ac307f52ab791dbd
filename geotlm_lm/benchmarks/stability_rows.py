"""What becomes of damaged clips, extreme recordings and stiff scenes: one row each.

Everything is caught and counted, because a report of what goes wrong must not stop where it does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import partial
from itertools import islice
from typing import Any

import numpy as np

from geotlm_lm.answering import Answerer
from geotlm_lm.benchmarks.cases.damaged import LONG_FRAMES, damage_kinds, extreme_clips
from geotlm_lm.benchmarks.cases.simulated import SimulatedCases
from geotlm_lm.benchmarks.cases.stiff import STIFF_CASES, solver_rows, stiff_scene
from geotlm_lm.benchmarks.judging import Case
from geotlm_lm.benchmarks.rows import Row, Run
from geotlm_lm.benchmarks.statistics import clustered_interval
from geotlm_lm.benchmarks.variants import GENERATED, QUESTION
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, Motion
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.simulation.simulate import simulate

RIGHT, WRONG, ABSTAINED, REFUSED, CRASHED = "right", "wrong", "abstained", "refused", "crashed"
OUTCOMES = (RIGHT, ABSTAINED, REFUSED, WRONG, CRASHED)
"""What may become of a question, the gravest last."""

CONFIDENT = 0.9
"""A wrong answer at or above this probability is called confident."""

CLIPS = 60
"""Clips of every level of damage: six of each motion."""

TOUCH_SHARE = 0.005
"""Share of the view in contact from which a stiff scene counts as touched, as for labels."""


@dataclass(frozen=True)
class Verdict:
    """What became of one question.

    Args:
        outcome: One of `OUTCOMES`.
        confidence: Of an answer; 0 otherwise.
        says: The answer or the sentence of the refusal.
        motion: What an answer names.
        family: Objects that are not independent of each other.
    """

    outcome: str
    confidence: float
    says: str
    motion: Motion | None = None
    family: str = ""


def damage_rows(run: Run) -> Iterator[Row]:
    """Yield one row per kind of damage and level, over simulated clips of all ten motions."""
    cases, kinds = simulated_cases(run, CLIPS, 2), damage_kinds()
    for done, (name, kind) in enumerate(kinds.items()):
        run.progress("damaged clips", done, len(kinds))
        for level, damage in kind.items():
            verdicts = []
            for index, case in enumerate(cases):
                rng = generator_for(run.seed, "damage", name, level.partition(" ")[0], index)
                make = partial(damage, case.clip, rng)
                verdicts.append(judge(run.answerer, make, {case.motion}, case.family))
            yield row_of(name, verdicts, level)


def extreme_rows(run: Run) -> Iterator[Row]:
    """Yield one row per extreme recording, made of the first simulated clip that turns."""
    touch = next(case for case in simulated_cases(run, CLIPS, CLIPS) if case.motion in ROTATIONS)
    long_frames = run.size(LONG_FRAMES, 1000)
    extremes = extreme_clips(touch.clip, touch.motion, long_frames=long_frames)
    for done, (name, extreme) in enumerate(extremes.items()):
        run.progress("extreme recordings", done, len(extremes))
        yield row_of(name, [judge(run.answerer, extreme.make, extreme.right)])


def scene_rows(run: Run) -> Iterator[Row]:
    """Yield, per scene, what its contact came to in two number formats and what is said of it."""
    cases = dict(islice(STIFF_CASES.items(), run.size(len(STIFF_CASES), 4)))
    for done, (name, case) in enumerate(cases.items()):
        run.progress("stiff and extreme scenes", done, len(cases))
        yield from solver_rows(name, case)
        yield row_of(name, [judge_scene(run, case)])


def simulated_cases(run: Run, whole: int, quick: int) -> list[Case]:
    """Return the first of the same simulated clips, so that all sections ask about these."""
    return list(islice(SimulatedCases("all", CLIPS, run.seed), run.size(whole, quick)))


def judge(
    answerer: Answerer, make: Callable[[], Clip], right: Set[Motion], family: str = ""
) -> Verdict:
    """Ask for the motion of a clip that `make` returns, or refuses as a reader would.

    With no motion that is `right`, only an abstention or a refusal is.
    """
    confidence, motion = 0.0, None
    try:
        answer = answerer.ask(answerer.encode(make()), QUESTION)
        outcome, says = ABSTAINED, answer.text
        if not answer.abstained:
            outcome = RIGHT if answer.direction in right else WRONG
            confidence, motion = answer.confidence, answer.direction
    except GeoTLMError as error:
        outcome, says = REFUSED, str(error)
    except Exception as error:
        outcome, says = CRASHED, f"{type(error).__name__}: {error}"
    return Verdict(outcome, confidence, says, motion, family)


def judge_scene(run: Run, case: Mapping[str, Any]) -> Verdict:
    """Return what became of the question about a scene in four frames."""
    try:
        made = simulate([stiff_scene(4, **case)], seed=run.seed, preset="good")[0]
    except ValueError as error:
        return Verdict(REFUSED, 0.0, str(error))
    except Exception as error:  # a defect of the simulator is a row like any other
        return Verdict(CRASHED, 0.0, f"{type(error).__name__}: {error}")
    right = {made.label.motion}
    if made.contact.mean(axis=(1, 2)).max() < TOUCH_SHARE:
        right = {Motion.NONE}
    elif not made.label.is_readable:  # nothing moves, as far as the images show
        right |= {Motion.STILL, Motion.NONE}
    return judge(run.answerer, lambda: made.clip, right)


def row_of(case: str, verdicts: Sequence[Verdict], variant: str = GENERATED) -> Row:
    """Return how often each outcome came up, how surely, and the words of the gravest case.

    The row's error is the share of wrong answers among those given; None where none was.
    """
    answered = [one for one in verdicts if one.outcome in (RIGHT, WRONG)]
    is_wrong = np.array([one.outcome == WRONG for one in answered])
    wrong = [one for one in answered if one.outcome == WRONG]
    sure = [one for one in wrong if one.confidence >= CONFIDENT]
    several = len(answered) > 1
    return Row(
        case,
        variant,
        count=len(verdicts),
        error=len(wrong) / len(answered) if answered else None,
        interval=clustered_interval(is_wrong, [a.family for a in answered]) if several else None,
        outcome=max(verdicts, key=lambda one: (OUTCOMES.index(one.outcome), one.confidence)).says,
        detail={name: sum(one.outcome == name for one in verdicts) for name in OUTCOMES}
        | {
            "probability": float(np.mean([a.confidence for a in answered])) if answered else None,
            "false_directions": sum(one.motion in DIRECTED for one in wrong),
            "confident_false_directions": sum(one.motion in DIRECTED for one in sure),
            "confident_oversights": sum(one.motion not in DIRECTED for one in sure),
        },
    )
