"""What each thing that the model leaves out saves: with it and without, on the same clip, in turn.

What is left out changes no answer, or none needs it; tests hold that.
"""

from __future__ import annotations

import copy
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import torch

from geotlm_lm.backbone.stem import look
from geotlm_lm.core.clip import Clip
from geotlm_lm.experiments.judging import QUESTION

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer

QUESTIONS = (QUESTION, "Is it turning clockwise?", "Is anything touching the gel?")

FOREIGN = "In welche Richtung dreht es sich?"
"""Refused by a rule, before the model is asked."""

LEFT_OUT_PACKAGES = ("transformers", "matplotlib", "scipy.stats", "sklearn.linear_model", "gradio")
"""What an answer does without, where it is installed."""


@dataclass(frozen=True)
class Omission:
    """One thing that is left out.

    Args:
        full: Doing it.
        lean: Leaving it out.
        when: Where it is left out.
    """

    full: Callable[[], object]
    lean: Callable[[], object]
    when: str


def omission_rows(answerer: Answerer, clip: Clip, repeats: int) -> list[dict[str, Any]]:
    """Return milliseconds of doing and of leaving out, for everything that is left out.

    Args:
        answerer: The model.
        clip: Four frames with a background.
        repeats: Runs of each way that count, after one that does not.
    """
    return [
        {"omission": name, "when": one.when, "full_ms": full, "lean_ms": lean}
        for name, one in omissions(answerer, clip).items()
        for full, lean in [_in_turn((one.full, one.lean), repeats)]
    ]


def omissions(answerer: Answerer, clip: Clip) -> Mapping[str, Omission]:
    """Return everything that is left out on the way to an answer, by name."""
    bundle, encoded = answerer.bundle, answerer.encode(clip)
    token = encoded.perception.fused_token
    sentences = bundle.grammar.options_for("direction")
    graded = copy.deepcopy(bundle.model.backbone.vit).requires_grad_(True)
    inputs = torch.from_numpy(look(clip).inputs)[None]

    def encode_each() -> None:
        for question in QUESTIONS:
            answerer.ask(answerer.encode(clip), question)

    def encode_once() -> None:
        seen = answerer.encode(clip)
        for question in QUESTIONS:
            answerer.ask(seen, question)

    def with_gradient() -> object:
        with torch.inference_mode(False), torch.enable_grad():
            return graded(inputs)

    def scored_one_by_one() -> None:
        for sentence in sentences:
            bundle.speaker.score(token[0], QUESTION, [sentence])

    return {
        "encoding again": Omission(encode_each, encode_once, f"{len(QUESTIONS)} questions, 1 clip"),
        "the language model": Omission(
            lambda: answerer.ask(encoded, QUESTION),
            lambda: answerer.ask(encoded, FOREIGN),
            "a rule answers: another language, a fact, a doubt",
        ),
        "words, in a stream": Omission(
            lambda: answerer.ask(answerer.encode(clip), QUESTION),
            lambda: bundle.model.probe.predict(answerer.encode(clip).perception.fused_token),
            "every window of `watch` without --q",
        ),
        "motions of evened images": Omission(
            lambda: answerer.encode(clip).evened,
            lambda: answerer.encode(clip),
            "a question that does not ask how far",
        ),
        "reading the prompt again": Omission(
            scored_one_by_one,
            lambda: bundle.speaker.score(token[0], QUESTION, sentences),
            f"scoring {len(sentences)} answers",
        ),
        "gradients": Omission(
            with_gradient, lambda: bundle.model.backbone.encode_inputs(inputs), "always"
        ),
    }


def import_rows(runs: int, packages: Sequence[str] = LEFT_OUT_PACKAGES) -> list[dict[str, Any]]:
    """Return what importing each package that an answer does without would add to a cold start.

    A package that is not installed has no row. Each is imported by a fresh process after what an
    answer needs, in turn with one that does not import it.

    Args:
        runs: Starts of each that count, after one that does not.
        packages: Their dotted names.
    """
    base = "import geotlm_lm.answering"
    rows = []
    for package in packages:
        with_it = f"{base}; import {package}"
        if _started(f"import {package}")[0]:
            continue
        ways = [lambda code=code: _started(code) for code in (with_it, base)]
        full, lean = _in_turn(ways, runs)
        row = {"omission": f"import of {package.partition('.')[0]}", "when": "cold start"}
        rows.append(row | {"full_ms": full, "lean_ms": lean})
    return rows


def _started(code: str) -> tuple[int, str]:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    return done.returncode, done.stderr


def _in_turn(ways: Sequence[Callable[[], object]], repeats: int) -> list[list[float]]:
    times: list[list[float]] = [[] for _ in ways]
    for repeat in range(repeats + 1):
        for way, own in zip(ways, times, strict=True):
            started = time.perf_counter()
            way()
            if repeat:
                own.append(1e3 * (time.perf_counter() - started))
    return times
