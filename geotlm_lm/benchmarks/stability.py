"""The stability bench: damaged, extreme and stiff inputs, and how firm the numbers are.

Failures are caught and counted, because a report of what goes wrong must not stop where it does.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import torch

from geotlm_lm.answering import Answerer
from geotlm_lm.benchmarks.cases import simulated_cases
from geotlm_lm.benchmarks.damaged import LONG_FRAMES, damage_kinds, extreme_clips
from geotlm_lm.benchmarks.harness import Listing, Pivot, Row, Run, Section, whole
from geotlm_lm.benchmarks.judging import Case, clustered_interval
from geotlm_lm.benchmarks.rendering import save_figure, text
from geotlm_lm.benchmarks.variants import GENERATED, QUESTION
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.core.geometry import GRID_SIDE, REGIONS
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, Motion
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.dgr.regions import MASS_FLOOR, pool_regions, region_mass
from geotlm_lm.simulation.contact import preset_named, solve_contact
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import Body, Gel, Scene
from geotlm_lm.simulation.scene import Path as BodyPath
from geotlm_lm.simulation.simulate import simulate

OUTCOMES_ABOUT = """\
Every clip is asked which way it moves, and a row counts what became of that. *False directions*
are wrong answers that name a turn or a slide; *wrong* is their share among the answers given, with
its 95 % interval, *probability* the mean stated with them. Quoted is the gravest case."""

RIGHT, WRONG, ABSTAINED, REFUSED, CRASHED = "right", "wrong", "abstained", "refused", "crashed"
OUTCOMES = (RIGHT, ABSTAINED, REFUSED, WRONG, CRASHED)
"""What may become of a question, the gravest last."""

CONFIDENT = 0.9
"""A wrong answer at or above this probability is called confident."""

CLIPS = 60
"""Clips of every level of damage: six of each motion."""

TOUCH_SHARE = 0.005
"""Share of the view in contact from which a stiff scene counts as touched, as for labels."""

MASKS = tuple(10.0**-power for power in range(13))
"""Contact masks from full contact to 1e-12."""

STIFF_CASES: dict[str, Mapping[str, Any]] = tomllib.loads(
    Path(__file__).with_name("stiff_scenes.toml").read_text()
)
"""Scenes by what is unlike the base scene, options of `scene_of`; the base scene first."""

RESIDUALS = ("penetration_um", "gradient_share", "cone_excess")
"""What the solver reports of how far it is from a solution."""


@dataclass(frozen=True)
class Verdict:
    """One of `OUTCOMES`, an answer's confidence, and the answer or the sentence of the refusal.

    `family` is what is resampled as a whole.
    """

    outcome: str
    confidence: float
    text: str
    motion: Motion | None = None
    family: str = ""


def damage_rows(run: Run) -> Iterator[Row]:
    """Yield one row per kind of damage and level, over simulated clips of all ten motions."""
    cases, kinds = first_cases(run, CLIPS, 2), damage_kinds()
    for done, (name, kind) in enumerate(kinds.items()):
        run.progress("damaged clips", done, len(kinds))
        for level, damage in kind.items():
            verdicts = []
            for index, case in enumerate(cases):
                rng = generator_for(run.seed, "damage", name, level.partition(" ")[0], index)
                make = partial(damage, case.clip, rng)
                verdicts.append(judge(run.answerer, make, {case.motion}, case.family))
            yield row_of(name, verdicts, level)


def _extreme_rows(run: Run) -> Iterator[Row]:
    touch = next(case for case in first_cases(run, CLIPS, CLIPS) if case.motion in ROTATIONS)
    long_frames = run.size(LONG_FRAMES, 1000)
    extremes = extreme_clips(touch.clip, touch.motion, long_frames=long_frames)
    for done, (name, extreme) in enumerate(extremes.items()):
        run.progress("extreme recordings", done, len(extremes))
        yield row_of(name, [judge(run.answerer, extreme.make, extreme.right)])


def _scene_rows(run: Run) -> Iterator[Row]:
    cases = dict(islice(STIFF_CASES.items(), run.size(len(STIFF_CASES), 4)))
    for done, (name, case) in enumerate(cases.items()):
        run.progress("stiff and extreme scenes", done, len(cases))
        yield contact_row(name, case)
        yield row_of(name, [judge_scene(run, case)])


def first_cases(run: Run, whole: int, quick: int) -> list[Case]:
    """Return the first of the same simulated clips, so that all sections ask about these."""
    return list(islice(simulated_cases("all", CLIPS, run.seed), run.size(whole, quick)))


def judge(
    answerer: Answerer, make: Callable[[], Clip], right: Set[Motion], family: str = ""
) -> Verdict:
    """Ask for the motion of a clip that `make` returns, or refuses as a reader would.

    With no motion that is `right`, only an abstention or a refusal is.
    """
    confidence, motion = 0.0, None
    try:
        answer = answerer.ask(answerer.encode(make()), QUESTION)
        outcome, text = ABSTAINED, answer.text
        if not answer.abstained:
            outcome = RIGHT if answer.direction in right else WRONG
            confidence, motion = answer.confidence, answer.direction
    except GeoTLMError as error:
        outcome, text = REFUSED, str(error)
    except Exception as error:
        outcome, text = CRASHED, f"{type(error).__name__}: {error}"
    return Verdict(outcome, confidence, text, motion, family)


def judge_scene(run: Run, case: Mapping[str, Any]) -> Verdict:
    """Return what became of the question about a scene in four frames."""
    try:
        made = simulate([scene_of(4, **case)], seed=run.seed, preset="good")[0]
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
    answered = [v for v in verdicts if v.outcome in (RIGHT, WRONG)]
    is_wrong = np.array([v.outcome == WRONG for v in answered])
    wrong = [v for v in answered if v.outcome == WRONG]
    sure = [v for v in wrong if v.confidence >= CONFIDENT]
    several = len(answered) > 1
    return Row(
        case,
        variant,
        count=len(verdicts),
        error=len(wrong) / len(answered) if answered else None,
        interval=clustered_interval(is_wrong, [v.family for v in answered]) if several else None,
        outcome=max(verdicts, key=lambda v: (OUTCOMES.index(v.outcome), v.confidence)).text,
        detail={name: sum(v.outcome == name for v in verdicts) for name in OUTCOMES}
        | {
            "probability": float(np.mean([v.confidence for v in answered])) if answered else None,
            "false_directions": sum(v.motion in DIRECTED for v in wrong),
            "confident_false_directions": sum(v.motion in DIRECTED for v in sure),
            "confident_oversights": sum(v.motion not in DIRECTED for v in sure),
        },
    )


def scene_of(
    frames: int,
    *,
    body: str = "key",
    size: float = 1.0,
    depth_mm: float = 0.6,
    from_mm: float | None = None,
    turn_deg: float = 9.0,
    x_mm: float = 0.0,
    start_mm: float = 0.0,
    **gel: float,
) -> Scene:
    """Return a body that is pressed in `depth_mm` and turns or travels along x, in some frames.

    It begins `start_mm` from the view's middle, and `from_mm` deep where that is less; `gel` is
    what is unlike GelSight Mini's. What the simulator refuses is a ValueError.
    """
    shares = np.linspace(0, 1, frames)
    first = depth_mm if from_mm is None else from_mm
    path = BodyPath(
        depth_mm=tuple((first + (depth_mm - first) * shares).tolist()),
        x_mm=tuple((start_mm + x_mm * shares).tolist()),
        y_mm=(0.0,) * frames,
        rotation_rad=tuple((math.radians(turn_deg) * shares).tolist()),
    )
    motion = Motion.CLOCKWISE if turn_deg else Motion.RIGHT
    return Scene(Body(body, size=size), path, motion, Gel(**gel))


def contact_row(name: str, case: Mapping[str, Any]) -> Row:
    """Return how a scene's contact was solved; catches nothing but a refusal."""
    preset = preset_named("good")
    try:
        scene = scene_of(2, **case)
    except ValueError as error:
        return Row(name, "contact", outcome=f"refused: {error}")
    contact = solve_contact(scene, build_profile(scene.body), preset, with_drift=True)
    height, drift, status = contact.indentation_mm, contact.drift_mm, contact.status
    outcome = "solved"
    if status.preset != preset.name:
        outcome = f"solved as {status.preset}, {str(height.dtype).removeprefix('torch.')}"
    if not bool(torch.isfinite(height).all() and torch.isfinite(drift).all()):
        outcome = "not finite"
    elif not status.is_converged:
        outcome = "not converged, and says so"
    residuals = {residual: getattr(status, residual) for residual in RESIDUALS}
    return Row(name, "contact", outcome=outcome, detail=residuals)


def mask_row(value: float) -> Row:
    """Return what Eq. 5 and its gradients come to under a mask of `value` everywhere.

    A unit field is pooled in float32; `recovered` undoes the floor by the exposed mass, and
    `empty_half` is the difference of the halves where only the lower is touched. The gradients of
    the descriptor's sum are by the mask, and by what that is the sigmoid of, in float64.
    """
    shape = (1, GRID_SIDE, GRID_SIDE)
    field = torch.randn(shape, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    whole, lower = torch.full(shape, value), torch.full(shape, value)
    lower[:, : GRID_SIDE // 2] = 0
    pooled, mass, half, half_mass = (
        dict(zip(REGIONS, values[0].tolist(), strict=True))
        for mask in (whole, lower)
        for values in (pool_regions(torch.ones_like(mask), mask), region_mass(mask))
    )
    mask = torch.full_like(field, value).requires_grad_(True)
    pool_regions(field, mask).sum().backward()
    numbers = {
        "pooled": pooled["global"],
        # The sum of the mask is its mass times the cells.
        "recovered": pooled["global"] * (1 + MASS_FLOOR / (mass["global"] * GRID_SIDE**2)),
        "empty_half": half["upper_minus_lower"],
        "its_mass": half_mass["upper_minus_lower"],
        "by_mask": float(mask.grad.norm()),
        "by_logit": float(mask.grad.norm()) * value * (1 - value),  # d sigmoid / d logit
    }
    return Row(f"contact {value:.0e}", "-", detail=numbers)


def failures_headline(rows: Sequence[Row]) -> str:
    """Return what fails, by name: crashes, and answers that are wrong at 0.9 or more."""
    return (
        f"- crashed: {_named(rows, CRASHED)}\n"
        f"- a wrong direction at 0.9 or more: {_named(rows, 'confident_false_directions')}\n"
        f"- a touch or motion overlooked at 0.9 or more: {_named(rows, 'confident_oversights')}"
    )


def _named(rows: Sequence[Row], count: str) -> str:
    """Name the 12 rows with most of what `count` counts, and of how many clips that is."""
    counted = [row for row in rows if row.detail.get(count)]
    counted.sort(key=lambda row: -row.detail[count] / row.count)
    names = [f"{row.case}, {row.variant} {row.detail[count]}/{row.count}" for row in counted]
    return ", ".join(names[:12]) or "none"


def _draw_damage(rows: Sequence[Row], path: Path) -> None:
    from matplotlib.figure import Figure

    kinds = {name: [row for row in rows if row.case == name] for name in (r.case for r in rows)}
    kinds = {name: own for name, own in kinds.items() if len(own) > 1}
    lines, nan = -(-len(kinds) // 4), float("nan")
    figure = Figure(figsize=(12.8, 2.4 * lines), layout="constrained")
    panels = list(figure.subplots(lines, 4, squeeze=False).flat)
    for (name, own), axes in zip(kinds.items(), panels, strict=False):
        levels, unit = zip(*(row.variant.partition(" ")[::2] for row in own), strict=True)
        right = [nan if row.right is None else row.right for row in own]
        silent = [(row.detail["refused"] + row.detail["abstained"]) / row.count for row in own]
        axes.plot(levels, right, "o-", label="right, of answers")
        axes.plot(levels, [row.detail["probability"] or nan for row in own], "s--", label="stated")
        axes.plot(levels, silent, "x:", label="refused or abstained")
        axes.set(title=name, xlabel=unit[0], ylim=(-0.05, 1.05))
        axes.grid(alpha=0.3)
    for axes in panels[len(kinds) :]:
        axes.set_axis_off()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    save_figure(figure, rows, path)


def _plain(row: Row) -> str:
    return " ".join(row.outcome.replace("|", "/").split())  # a bar would end the cell


def _wrong(row: Row) -> str:
    low_high = f" ({row.interval[0]:.2f}-{row.interval[1]:.2f})" if row.interval else ""
    return text("error:.2f", row) + low_high


def _details(form: str, *names: str) -> dict[str, str]:
    """Return columns of a row's detail, titled by their names."""
    return {name.replace("_", " "): f"{name}:{form}" for name in names}


_ASKED = Listing(
    {"clips": "case", "level": "variant", "n": "count"}
    | _details("d", *OUTCOMES, "false_directions")
    | {"wrong of answers": _wrong}
    | _details(".2f", "probability")
    | {"says": _plain}
)
_CONTACT = _details(".1e", "pooled", "recovered", "empty_half", "its_mass", "by_mask", "by_logit")

DAMAGE = Section(
    name="damage",
    title="Damaged clips",
    about=f"""\
Simulated objects kept from training, damaged more and more. A fifth of training's clips were
damaged as well: by JPEG, a dim or drifting camera, or a fainter touch. {OUTCOMES_ABOUT}""",
    shares=whole(damage_rows),
    views={"": _ASKED},
    figure=_draw_damage,
    headline=failures_headline,
)

EXTREME = Section(
    name="extreme",
    title="Extreme recordings",
    about=f"Where nothing can be told, only silence or a refusal is right. {OUTCOMES_ABOUT}",
    shares=whole(_extreme_rows),
    views={"": _ASKED},
    headline=failures_headline,
)

SCENES = Section(
    name="scenes",
    title="Stiff and extreme scenes",
    about="""\
What the contact solver makes of a scene, by the preset that data sets are made with or what that
escalates to, and what the model says of its four frames.""",
    shares=whole(_scene_rows),
    views={
        "": Pivot(_plain, "scene", with_count=False),
        "Residuals": Listing(
            {"scene": "case"} | _details(".1e", *RESIDUALS), lambda row: RESIDUALS[0] in row.detail
        ),
    },
    headline=failures_headline,
)

NUMERICS = Section(
    name="numerics",
    title="Contact that vanishes",
    about="""\
As written, Eq. 5 shrinks a unit field under a faint mask; the exposed mass undoes that
(*recovered*). A half without contact reads as a turn would, and *its mass*, 0, says so. By what the
mask is the sigmoid of, which training changes, gradients stay bounded.""",
    shares=whole(lambda run: map(mask_row, MASKS)),
    views={"": Listing({"mask": "case"} | _CONTACT)},
)
