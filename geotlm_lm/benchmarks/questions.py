"""Questions: every type asked about simulated and real clips.

The truth is worked out from labels and frames alone, apart from the rules that answer by them, so
that a wrong rule is a wrong answer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geotlm_lm.answering import Answer, Answerer, Encoded
from geotlm_lm.answering.evidence_of import recording_of
from geotlm_lm.benchmarks.cases import by_half, recordings_by_half, simulated_clips, titled
from geotlm_lm.benchmarks.harness import Listing, Pivot, Row, Run, Section
from geotlm_lm.benchmarks.judging import share_row
from geotlm_lm.benchmarks.rendering import right_with_interval
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.edit import MIRRORED, opposite
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import (
    DIRECTED,
    SLIDES,
    Motion,
    MotionLabel,
    motion_class,
)
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.core.tolerance import within_tolerance
from geotlm_lm.data.labelled_recordings import LabelledRecordings
from geotlm_lm.data.questions import QuestionAnswer, askable_types, questions_for
from geotlm_lm.data.templates import load_templates
from geotlm_lm.language.parse_answer import Slots
from geotlm_lm.query import values
from geotlm_lm.query.program import Expression, head_of
from geotlm_lm.training.calibration import expected_calibration_error

DECLINED = ("refusal", "comparison")
"""Kinds that one clip cannot answer."""

AT_REST = (Motion.STILL, Motion.NONE)

OTHER_FRAME = {"viewpoint": {"viewpoint": "object"}, "actor": {"actor": "sensor"}}
"""Kinds that are told in another frame, and in which."""

CLIPS, WINDOWS = 120, 25
WORDS, UNSEEN = "words", "unseen wordings"

DIRECTIONS = ("T1", "T2", "T3", "T4", "T11", "T12", "T14", "T15", "T18", "T21")
"""Types whose answer names a direction."""

AMOUNTS, THREAD = ("T7", "T8"), "T13"

SIDES, THREADS = ("head", "shank", "side", None), ("right", "left", None)
"""What is known of a thread."""


@dataclass(frozen=True)
class Truth:
    """The right answer to a question of a kind, as its template calls it.

    `decided` is the deciding word, or the kind of motion; `direction` the motion from the point of
    view asked for (None: any); `is_so` whether a claim holds; `unit` "deg", "px", "deg/s" or
    "px/s", of a speed over `seconds`.
    """

    kind: str
    decided: str | None = None
    direction: Motion | None = None
    is_so: bool | None = None
    abstains: bool = False
    amount: float | None = None
    unit: str | None = None
    seconds: float = 1.0


def truth_of(
    asked: QuestionAnswer, motion: Motion, frame: FrameSpec, *, seconds: float | None = 1.0
) -> Truth:
    """Return the right answer to `asked` about a clip of `motion`, as `frame` sees it.

    The question's own answer gives claim, options and amount; a speed needs a clip that is timed.
    """
    kind, way = asked.slots.kind, frame.edit.of_way(motion)
    if kind in ("verify", "negation"):
        return Truth(kind, direction=way, is_so=way == claim_of(asked))
    if kind == "choice":
        letter = {option.direction: option.letter for option in _options(asked)}.get(way)
        return Truth(kind, letter, way)
    if kind == "class":
        return Truth(kind, motion_class(motion).value)
    if kind in ("contact", "moving"):
        at_rest = (Motion.NONE,) if kind == "contact" else AT_REST
        return Truth(kind, is_so=motion not in at_rest)
    if kind in ("magnitude", "rate"):
        return _amount_truth(asked, motion, seconds)
    if kind in DECLINED:
        return Truth(kind, abstains=True)
    if kind == "thread":
        return _thread_truth(motion, frame)
    changed = {"mirrored": MIRRORED.of_way, "reversed": opposite, "undo": opposite}.get(kind)
    frame = replace(frame, **OTHER_FRAME.get(kind, {}))
    way = frame.edit.of_way(changed(motion) if changed else motion)
    return Truth(kind, direction=way)


def _amount_truth(asked: QuestionAnswer, motion: Motion, seconds: float | None) -> Truth:
    kind, unit = asked.slots.kind, asked.slots.unit
    if motion in AT_REST:
        return Truth(kind, direction=motion)
    if kind == "rate" and seconds is None:
        return Truth(kind, abstains=True)
    if motion not in DIRECTED:  # how deep a press goes, no label tells
        return Truth(kind, direction=motion)
    if kind == "magnitude":
        return Truth(kind, amount=asked.amount, unit=unit)
    return Truth(kind, amount=asked.amount, unit=f"{unit}/s", seconds=seconds)


def _thread_truth(motion: Motion, frame: FrameSpec) -> Truth:
    way, tightens = frame.edit.of_way(motion), frame.tightens(motion)
    if motion not in DIRECTED or (motion in SLIDES and frame.contact_side != "side"):
        return Truth("thread", "neither", way)
    if tightens is None:
        return Truth("thread", abstains=True)
    return Truth("thread", "tighten" if tightens else "loosen", way)


def is_right(answer: Answer, truth: Truth) -> bool:
    """Whether `answer` decides and claims what it should; an amount within its tolerance."""
    if truth.kind == "premise" and answer.values and all(map(_is_untold, answer.values)):
        return answer.abstained  # when, how long or how often: four frames claim nothing
    if truth.kind == "order" and answer.abstained:  # one clip shows no order, but a motion
        return True
    if answer.abstained != truth.abstains:
        return False
    if truth.abstains:
        return True
    if truth.amount is not None:
        amount, unit = answer.amount, truth.unit.removesuffix("/s")
        if amount is None or amount.unit != truth.unit:
            return False
        return within_tolerance(amount.value * truth.seconds, truth.amount, unit)
    if truth.kind == "class":
        claimed = answer.direction
        return claimed is not None and motion_class(claimed).value == truth.decided
    if truth.direction not in (None, answer.direction):
        return False
    if truth.kind == "thread":
        return _is_right_of_thread(answer, truth.decided)
    if truth.is_so is not None:
        return answer.decided == ("yes" if truth.is_so != _claim(answer)[1] else "no")
    return truth.decided in (None, answer.decided)


def _is_untold(value: values.Value) -> bool:
    """Whether a value is of what only a recording that was followed tells, or no touch does."""
    return getattr(value, "reason", "") == "track" or getattr(value, "kind", "") == "cannot"


def _claim(answer: Answer) -> tuple[Expression, bool]:
    """Return what was claimed, and whether a yes is to the contrary: "is it not turning?"."""
    claimed, denies = head_of(answer.resumed.answers[0]), False
    while claimed.word == "not":
        claimed, denies = head_of(claimed.arguments[0]), not denies
    return claimed, denies


def _is_right_of_thread(answer: Answer, truth: str) -> bool:
    """Whether a thread was judged right: asked openly, of several, or whether it tightens."""
    value = answer.values[0]
    if isinstance(value, values.Truth):
        claimed, denies = _claim(answer)
        return value.holds == ((claimed.word == truth) != denies)
    if isinstance(value, values.Choice):
        cases = head_of(value.of).arguments[0]
        words = [cases[place].holds.word for place in value.chosen]
        return words == [truth] if truth != "neither" else not {"tighten", "loosen"} & {*words}
    names = {True: "tighten", False: "loosen", None: "neither"}
    return isinstance(value, values.Moved) and names[value.tightens] == truth


def claim_of(asked: QuestionAnswer) -> Motion:
    """Return the motion that a question claims."""
    is_true = asked.slots.kind != "negation"
    return next(option.direction for option in _options(asked) if option.verdict == is_true)


def _options(asked: QuestionAnswer) -> list[Slots]:
    answers = load_templates().types[asked.type_id].answers
    return [answers[sentence] for sentence in asked.options]


@dataclass(frozen=True)
class Asked:
    """A question's type, whether each method was right, and its unit of resampling.

    `stated` is the probability that the words state; None of what is to be declined, or undecided.
    """

    type_id: str
    right: Mapping[str, bool]
    stated: float | None
    family: str = ""


def question_rows(run: Run) -> Iterator[Row]:
    """Yield the rows of every set of clips, simulated and real apart."""
    simulated = simulated_clips("all", run.size(CLIPS, 3), run.seed)
    sets = {"simulated": ((made.clip, made.label, made.object_name) for made in simulated)}
    for name, half, real in recordings_by_half(run.real):
        sets[titled(f"real {name}", half)] = _windows(real, run.size(WINDOWS, 2))
    for title, clips in sets.items():
        run.progress(f"questions, {title}", 0, 1)
        asked: list[Asked] = []
        for index, (clip, label, family) in enumerate(clips):
            rng = generator_for(run.seed, "language", index)
            encoded = run.answerer.encode(clip)
            for type_id in askable_types(label):
                if type_id not in AMOUNTS or label.mm_per_px is not None:
                    result = _ask_type(run.answerer, encoded, label, type_id, rng)
                    asked.append(replace(result, family=family))
        yield from type_rows(title, asked, run.seed)


def _windows(recordings: LabelledRecordings, count: int) -> Iterator[tuple[Clip, MotionLabel, str]]:
    """Yield `count` four-frame windows at most, spread over the table, forwards and backwards."""
    rows = recordings.rows
    at = np.unique(np.linspace(0, len(rows) - 1, min(count, len(rows))).round().astype(int))
    chosen = replace(recordings, rows=tuple(rows[i] for i in at))
    for window in chosen.windows(frames=("four",), backwards=True):
        yield window.clip, MotionLabel(window.motion), window.row.object_family


def _ask_type(
    answerer: Answerer, encoded: Encoded, label: MotionLabel, type_id: str, rng: np.random.Generator
) -> Asked:
    frame = FrameSpec()
    if type_id == THREAD:
        side = SIDES[int(rng.integers(len(SIDES)))]
        frame = FrameSpec(contact_side=side, thread=THREADS[int(rng.integers(len(THREADS)))])
    asked, unseen = (
        questions_for(label, rng, types=[type_id], wordings=wordings)[0]
        for wordings in ("seen", "held_out")
    )
    motion, seconds = label.motion, recording_of(encoded).seconds

    def graded(question: QuestionAnswer) -> tuple[Answer, Truth, bool]:
        answer = answerer.ask(encoded, question.question, frame=frame)
        truth = truth_of(question, motion, frame, seconds=seconds)
        return answer, truth, is_right(answer, truth)

    answer, truth, is_answer_right = graded(asked)
    right = {WORDS: is_answer_right, UNSEEN: graded(unseen)[2]}
    stated = None if truth.abstains or answer.decided is None else answer.confidence
    return Asked(type_id, right, stated)


def type_rows(title: str, asked: Sequence[Asked], seed: int) -> Iterator[Row]:
    """Yield the rows of both wordings, of each type and of types pooled."""
    kinds = {name: type_.kind for name, type_ in load_templates().types.items()}
    types = sorted({x.type_id for x in asked}, key=lambda name: int(name.removeprefix("T")))
    pools = {f"{name} {kinds[name]}": (name,) for name in types}
    for name, pool in (pools | {"all directions": DIRECTIONS, "all types": types}).items():
        own = [x for x in asked if x.type_id in pool]
        families = [x.family for x in own]
        for method in (WORDS, UNSEEN) if own else ():
            right = [x.right[method] for x in own]
            detail = calibration(own) if method == WORDS else {}
            yield share_row(f"{title}, {name}", method, right, families, seed, detail=detail)


def calibration(asked: Sequence[Asked]) -> dict[str, Any]:
    """Return whether stated probabilities come true; nothing where none is stated."""
    stated = [x for x in asked if x.stated is not None]
    if not stated:
        return {}
    confidence = np.array([x.stated for x in stated])
    right = np.array([x.right[WORDS] for x in stated])
    return {
        "stated": len(stated),
        "mean_stated": float(confidence.mean()),
        "right_of_stated": float(right.mean()),
        "calibration_error": expected_calibration_error(confidence, right),
    }


def detail_cell(key: str, form: str = ".3f") -> Callable[[Row], str]:
    """Return what shows a number of a row's detail."""
    return lambda row: format(row.detail[key], form)


_CALIBRATION = {
    "clips, question type": lambda row: row.case,
    "answers": detail_cell("stated", ""),
    "right": detail_cell("right_of_stated"),
    "mean stated": detail_cell("mean_stated"),
    "calibration error": detail_cell("calibration_error"),
}

QUESTIONS = Section(
    name="questions",
    title="Every question type",
    about="""\
Each clip is asked one question of every type through the same door a user takes. *Words* are graded
by what they decide and claim, in the frame they are told in; refusals of what can be answered are
wrong. *Unseen wordings* were kept from training. Intervals resample whole objects.""",
    run=question_rows,
    views=by_half(Pivot(right_with_interval, "question"))
    | {"Stated probability": (Listing(_CALIBRATION), lambda row: "stated" in row.detail)},
)
