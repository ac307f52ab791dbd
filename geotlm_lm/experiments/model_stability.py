"""The model under stress: damaged clips, extreme recordings, stiff scenes, and its own numerics.

Every row says what became of it and with what probability; nothing is left out because it fails.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.record import RunRecord
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.experiments.cases import SimulatedCases
from geotlm_lm.experiments.compare import Case
from geotlm_lm.experiments.degradations import Degradation, degradations
from geotlm_lm.experiments.extreme_clips import extreme_clips
from geotlm_lm.experiments.judging import CRASHED, REFUSED, Verdict, judge, tally
from geotlm_lm.experiments.simulator_stability import CASES as STIFF
from geotlm_lm.experiments.simulator_stability import Case as StiffCase
from geotlm_lm.simulation.scene import Path, Scene
from geotlm_lm.simulation.simulate import SimulatedClip, simulate

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer

Progress = Callable[[str, int, int], None]

CLIPS = 60
"""Clips of every level of damage: six of each motion."""

NUMERICS_CLIPS = 20
"""Clips whose answers are compared across number formats and scales."""

TOUCH_SHARE = 0.005
"""Share of the view in contact from which a stiff scene counts as touched, as for labels."""

QUIET: Progress = lambda what, done, total: None  # noqa: E731


def model_stability(
    answerer: Answerer,
    *,
    seed: int = 0,
    clips: int = CLIPS,
    numerics_clips: int = NUMERICS_CLIPS,
    damage: Mapping[str, Degradation] | None = None,
    stiff: Mapping[str, StiffCase] = STIFF,
    command: str = "",
    progress: Progress = QUIET,
) -> RunRecord:
    """Run everything and write down what came of it.

    Args:
        answerer: The model.
        seed: Root of the clips and of the damage.
        clips: Simulated clips of objects kept from training, all ten motions.
        numerics_clips: How many of them the number formats are tried on.
        damage: Kinds of damage by name; all by default.
        stiff: The simulator's cases by name.
        command: The command line, for the record.
        progress: Told how far the run is.
    """
    from geotlm_lm.experiments import model_numerics as numerics

    started = time.perf_counter()
    cases = list(SimulatedCases("all", clips, seed))
    damage = degradations() if damage is None else damage
    rows = [
        *damage_rows(answerer, cases, damage, seed, progress),
        *extreme_rows(answerer, cases, progress),
        *stiff_rows(answerer, stiff, seed, progress),
    ]
    few = cases[:numerics_clips]
    prepared = numerics.prepared(few)
    tables: dict[str, list[dict[str, Any]]] = {
        "mass_floor": numerics.mass_floor_rows(),
        "gradients": numerics.gradient_rows(),
    }
    progress("number formats", 0, 2)
    tables["precision"] = numerics.precision_rows(answerer, prepared)
    progress("number formats", 1, 2)
    tables["scales"] = numerics.scale_rows(answerer, prepared)
    progress("number formats", 2, 2)
    return RunRecord(
        name="stability",
        command=command,
        seed=seed,
        seconds=time.perf_counter() - started,
        numbers={"rows": rows, **tables},
        config={"clips": clips, "numerics_clips": numerics_clips}
        | {"model_digest": answerer.bundle.digest()},
    )


def damage_rows(
    answerer: Answerer,
    cases: list[Case],
    damage: Mapping[str, Degradation],
    seed: int,
    progress: Progress = QUIET,
) -> list[dict[str, Any]]:
    """Return one row per kind of damage and level, over the clips."""
    rows = []
    for done, (name, kind) in enumerate(damage.items(), start=1):
        for level, degrade in kind.levels.items():
            verdicts: list[Verdict] = []
            for number, case in enumerate(cases[: kind.clips]):
                rng = generator_for(seed, "damage", name, level, number)

                def make(degrade=degrade, case=case, rng=rng) -> Clip:
                    return degrade(case.clip, rng)

                verdicts.append(judge(answerer, make, {case.motion}))
            own = {"group": "damage", "case": name, "level": level, "unit": kind.unit}
            rows.append(own | tally(verdicts))
        progress("damaged clips", done, len(damage))
    return rows


def extreme_rows(
    answerer: Answerer, cases: list[Case], progress: Progress = QUIET
) -> list[dict[str, Any]]:
    """Return one row per extreme recording, made of the first clip with a direction."""
    touch = next((case for case in cases if case.motion in _TURNS), cases[0])
    extremes = extreme_clips(touch.clip, touch.motion)
    rows = []
    for done, (name, extreme) in enumerate(extremes.items(), start=1):
        own = {"group": "extreme", "case": name, "level": "-", "unit": ""}
        rows.append(own | tally([judge(answerer, extreme.make, extreme.right)]))
        progress("extreme recordings", done, len(extremes))
    return rows


_TURNS = (Motion.CLOCKWISE, Motion.COUNTERCLOCKWISE)


def stiff_rows(
    answerer: Answerer, stiff: Mapping[str, StiffCase], seed: int, progress: Progress = QUIET
) -> list[dict[str, Any]]:
    """Return one row per stiff scene of the simulator: what it and what the model made of it."""
    rows = []
    for done, (name, case) in enumerate(stiff.items(), start=1):
        own = {"group": "stiff scene", "case": name, "level": "-", "unit": ""}
        verdict, solver = _judged_scene(answerer, case, seed)
        rows.append(own | tally([verdict]) | {"solver": solver})
        progress("stiff scenes", done, len(stiff))
    return rows


def _judged_scene(answerer: Answerer, case: StiffCase, seed: int) -> tuple[Verdict, str]:
    """Return what became of the question about a scene, and how its contact was solved."""
    try:
        made = simulate([_four_frames(case)], seed=seed, preset="good")[0]
    except ValueError as error:
        return Verdict(REFUSED, 0.0, str(error), 0.0), "refused"
    except Exception as error:  # a defect of the simulator is a row like any other
        return Verdict(CRASHED, 0.0, f"{type(error).__name__}: {error}", 0.0), "crashed"
    status = made.status
    solver = f"{status.preset}, {'' if status.is_converged else 'not '}converged"
    return judge(answerer, lambda: made.clip, _right(made)), solver


def _four_frames(case: StiffCase) -> Scene:
    """Return the case's scene in four frames in place of two, labelled by what it does.

    Raises:
        ValueError: If the simulator refuses it.
    """
    scene = case.scene()
    share = np.linspace(0, 1, 4)

    def evenly(ends: tuple[float, ...]) -> tuple[float, ...]:
        return tuple((ends[0] + (ends[-1] - ends[0]) * share).tolist())

    path = scene.path
    motion = Motion.CLOCKWISE if case.turn_deg else Motion.RIGHT
    names = ("depth_mm", "x_mm", "y_mm", "rotation_rad")
    four = Path(**{name: evenly(getattr(path, name)) for name in names})
    return replace(scene, path=four, motion=motion)


def _right(made: SimulatedClip) -> frozenset[Motion]:
    """Return the right answers: the motion; where the images do not show it, that nothing moves."""
    if made.contact.mean(axis=(1, 2)).max() < TOUCH_SHARE:
        return frozenset({Motion.NONE})
    motion = frozenset({made.label.motion})
    return motion if made.label.is_readable else motion | {Motion.STILL, Motion.NONE}
