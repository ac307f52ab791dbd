"""Every question type asked about simulated and real clips.

Answers come from `Answerer.ask`, as a user gets them, and are graded by truths
that `question_truths` works out apart from the rules that answer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geotlm_lm.answering import Answer, Answerer, Encoded
from geotlm_lm.answering.evidence_of import recording_of
from geotlm_lm.benchmarks.cases.simulated import SimulatedCases
from geotlm_lm.benchmarks.halves import by_half, recordings_by_half, titled
from geotlm_lm.benchmarks.question_truths import is_right, truth_of
from geotlm_lm.benchmarks.rendering import right_with_interval
from geotlm_lm.benchmarks.rows import Listing, Pivot, Row, Run, Section
from geotlm_lm.benchmarks.statistics import share_row
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.data.labelled_recordings import LabelledRecordings
from geotlm_lm.data.questions import QuestionAnswer, askable_types, questions_for
from geotlm_lm.data.templates import load_templates
from geotlm_lm.training.calibration import expected_calibration_error

ABOUT = """\
Each clip is asked one question of every type through the same door a user takes. *Words* are graded
by what they decide and claim, in the frame they are told in; refusals of what can be answered are
wrong. *Unseen wordings* were kept from training. Intervals resample whole objects."""

CLIPS, WINDOWS = 120, 25
WORDS, UNSEEN = "words", "unseen wordings"
METHODS = (WORDS, UNSEEN)

DIRECTIONS = ("T1", "T2", "T3", "T4", "T11", "T12", "T14", "T15", "T18", "T21")
"""Types whose answer names a direction."""

AMOUNTS, THREAD = ("T7", "T8"), "T13"

SIDES, THREADS = ("head", "shank", "side", None), ("right", "left", None)
"""What is known of a thread."""


@dataclass(frozen=True)
class Asked:
    """A question's type, whether each method that could was right, and its unit of resampling.

    `stated` is the probability that the words state; None of what is to be declined, or undecided.
    """

    type_id: str
    right: Mapping[str, bool]
    stated: float | None
    family: str = ""


def question_rows(run: Run) -> Iterator[Row]:
    """Yield the rows of every set of clips, simulated and real apart.

    Raises:
        UnreadableClip: If the recordings cannot be read.
    """
    simulated = SimulatedCases("all", run.size(CLIPS, 3), run.seed).made()
    sets = {"simulated": ((made.clip, made.label, made.object_name) for made in simulated)}
    for name, half, real in recordings_by_half(run.real):
        sets[titled(f"real {name}", half)] = _windows(real, run.size(WINDOWS, 2))
    for title, clips in sets.items():
        run.progress(f"questions, {title}", 0, 1)
        asked: list[Asked] = []
        for index, (clip, label, family) in enumerate(clips):
            rng = generator_for(run.seed, "language", index)
            found = ask_every_type(run.answerer, run.answerer.encode(clip), label, rng)
            asked += [replace(one, family=family) for one in found]
        yield from type_rows(title, asked, run.seed)


def _windows(recordings: LabelledRecordings, count: int) -> Iterator[tuple[Clip, MotionLabel, str]]:
    """Yield `count` four-frame windows at most, spread over the table, forwards and backwards."""
    rows = recordings.rows
    at = np.unique(np.linspace(0, len(rows) - 1, min(count, len(rows))).round().astype(int))
    chosen = replace(recordings, rows=tuple(rows[i] for i in at))
    for window in chosen.windows(frames=("four",), backwards=True):
        yield window.clip, MotionLabel(window.motion), window.row.object_family


def ask_every_type(
    answerer: Answerer, encoded: Encoded, label: MotionLabel, rng: np.random.Generator
) -> Iterator[Asked]:
    """Yield one question of every type about a clip, in seen and in unseen wordings."""
    for type_id in askable_types(label):
        if type_id not in AMOUNTS or label.mm_per_px is not None:
            yield _ask_type(answerer, encoded, label, type_id, rng)


def _ask_type(
    answerer: Answerer, encoded: Encoded, label: MotionLabel, type_id: str, rng: np.random.Generator
) -> Asked:
    """Return what became of one type."""
    frame = FrameSpec()
    if type_id == THREAD:
        side = SIDES[int(rng.integers(len(SIDES)))]
        frame = FrameSpec(contact_side=side, thread=THREADS[int(rng.integers(len(THREADS)))])
    asked, unseen = (
        questions_for(label, rng, types=[type_id], wordings=wordings)[0]
        for wordings in ("seen", "held_out")
    )
    motion, seconds = label.motion, recording_of(encoded).seconds

    def graded(question: QuestionAnswer) -> tuple[Answer, bool]:
        answer = answerer.ask(encoded, question.question, frame=frame)
        return answer, is_right(answer, truth_of(question, motion, frame, seconds=seconds))

    truth = truth_of(asked, motion, frame, seconds=seconds)
    answer, is_answer_right = graded(asked)
    right = {WORDS: is_answer_right, UNSEEN: graded(unseen)[1]}
    stated = None if truth.abstains or answer.decided is None else answer.confidence
    return Asked(type_id, right, stated)


def type_rows(title: str, asked: Sequence[Asked], seed: int) -> Iterator[Row]:
    """Yield, of each type and of types pooled, one row for each method that has an answer."""
    kinds = {one: type_.kind for one, type_ in load_templates().types.items()}
    types = sorted({one.type_id for one in asked}, key=lambda one: int(one.removeprefix("T")))
    pools = {f"{one} {kinds[one]}": (one,) for one in types}
    for name, pool in (pools | {"all directions": DIRECTIONS, "all types": types}).items():
        own = [one for one in asked if one.type_id in pool]
        for method in METHODS:
            answered = [one for one in own if method in one.right]
            if answered:
                right = [one.right[method] for one in answered]
                families = [one.family for one in answered]
                detail = calibration(own) if method == WORDS else {}
                yield share_row(f"{title}, {name}", method, right, families, seed, detail=detail)


def calibration(asked: Sequence[Asked]) -> dict[str, Any]:
    """Return whether stated probabilities come true; nothing where none is stated."""
    stated = [one for one in asked if one.stated is not None]
    if not stated:
        return {}
    confidence = np.array([one.stated for one in stated])
    right = np.array([one.right[WORDS] for one in stated])
    return {
        "stated": len(stated),
        "mean_stated": float(confidence.mean()),
        "right_of_stated": float(right.mean()),
        "calibration_error": expected_calibration_error(confidence, right),
    }


def _detail(key: str, form: str = ".3f") -> Callable[[Row], str]:
    return lambda row: format(row.detail[key], form)


_CALIBRATION = {
    "clips, question type": lambda row: row.case,
    "answers": _detail("stated", ""),
    "right": _detail("right_of_stated"),
    "mean stated": _detail("mean_stated"),
    "calibration error": _detail("calibration_error"),
}

QUESTIONS = Section(
    name="questions",
    title="Every question type",
    about=ABOUT,
    run=question_rows,
    views=by_half(Pivot(right_with_interval, "question"))
    | {"Stated probability": (Listing(_CALIBRATION), lambda row: "stated" in row.detail)},
)
