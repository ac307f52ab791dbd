"""What each thing that is left out saves, and what leaving it out costs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import repeat
from statistics import median
from typing import Any, NamedTuple

import numpy as np

from geotlm_lm.answering import Encoded
from geotlm_lm.benchmarks.harness import Listing, Row, Run, Section, whole
from geotlm_lm.benchmarks.judging import milliseconds
from geotlm_lm.benchmarks.pareto import Way, differences, in_turn, moving, runtime_clip, solved
from geotlm_lm.benchmarks.variants import QUESTION
from geotlm_lm.simulation.contact import PRESETS, Preset
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import Scene

QUESTIONS = (QUESTION, "Is it turning clockwise?", "Is anything touching the gel?")

BY_RULE = "Which way is it moving, seen from the object's side?"
"""Answered by rule: the language model's own sentences are about the camera image."""


class Omission(NamedTuple):
    """Something that is left out: where, doing it, leaving it out, and what that costs.

    The cost is of both results: errors of the lean one by their units.
    """

    name: str
    when: str
    full: Way
    lean: Way
    cost: Callable[[Any, Any], Mapping[str, float]] | None = None


def omission_rows(omissions: Iterable[Omission], repeats: int) -> Iterator[Row]:
    """Yield what leaving out each thing saves and costs; both ways run in turn, `repeats` times."""
    for name, when, full, lean, cost in omissions:
        done, left = in_turn({"full": full, "lean": lean}, repeats).values()
        saved = [much - little for (_, much), (_, little) in zip(done, left, strict=True)]
        detail = {
            "when": when,
            "full_ms": median(ms for _, ms in done),
            "saved_ms": [min(saved), median(saved), max(saved)],
            "costs": cost(done[0][0], left[0][0]) if cost else {},
        }
        yield Row(name, "lean", repeats, detail=detail, **milliseconds([ms for _, ms in left]))


def model_omissions(run: Run) -> list[Omission]:
    """Return what is left out on the way to an answer about a simulated turn of four frames."""
    encode, ask = partial(run.answerer.encode, runtime_clip(run)), run.answerer.ask
    encoded = encode()
    words, by_rule = partial(ask, encoded, QUESTION), partial(ask, encoded, BY_RULE)

    def answers(views: Iterable[Encoded]) -> list[str]:
        return [ask(view, question).text for view, question in zip(views, QUESTIONS, strict=False)]

    def changed(full: list[str], lean: list[str]) -> dict[str, float]:
        return {"of answers changed": float(np.mean(np.not_equal(full, lean)))}

    encodings = (lambda: answers(encode() for _ in QUESTIONS), lambda: answers(repeat(encode())))
    return [
        Omission("encoding again", "three questions about one clip", *encodings, changed),
        Omission("the language model", "told in another frame", words, by_rule),
        Omission("the belief", "not asked how it moves", lambda: encode().belief, encode),
    ]


def scene_omissions(preset: Preset) -> Iterator[Omission]:
    """Yield what the simulator leaves out of a key's scenes that do not need it."""

    def solve(preset: Preset, scene: Scene, with_drift: bool = True) -> Way:
        return lambda: solved(preset, scene, build_profile(scene.body), with_drift=with_drift)

    twist, press = moving("key", turn_deg=9.0), moving("key", from_mm=0.2)
    slide, finer = moving("key", x_mm=0.84), replace(preset, step_share=0.25)
    slippery = replace(press, gel=replace(press.gel, friction=0.0))
    for name, scene, full, lean in (
        ("friction, no shear asked", twist, solve(preset, twist), solve(preset, twist, False)),
        ("friction, in a press", press, solve(preset, press), solve(preset, slippery)),
        ("substeps of steps of 0.28 mm", slide, solve(finer, slide), solve(preset, slide)),
    ):
        yield Omission(name, "a key", full, lean, partial(differences, scene))


def _saved_rows(run: Run) -> Iterator[Row]:
    yield from omission_rows(model_omissions(run), run.size(30, 1))
    yield from omission_rows(scene_omissions(PRESETS[run.size("fast", "draft")]), run.size(7, 1))


_COLUMNS = {
    "left out": "case",
    "when": "when",
    "ms with it": "full_ms:.1f",
    "ms without": "ms_p50:.1f",
    "ms saved (range)": lambda row: "{1:.1f} ({0:.1f} to {2:.1f})".format(*row.detail["saved_ms"]),
    "costs": lambda row: "; ".join(f"{much:.2g} {x}" for x, much in row.detail["costs"].items()),
}

SAVED = Section(
    name="saved",
    title="Saved and lost",
    about="""\
Both ways run in turn, medians, one thread, on one simulated clip or scene. *Costs* is the error of
leaving it out against doing it; none where the two do not tell the same.""",
    shares=whole(_saved_rows),
    views={"": Listing(_COLUMNS)},
)
