"""Every question type asked about simulated and real clips, and groups that belong together.

Answers come from `Answerer.ask` and its sessions, as a user gets them, and are graded by truths
that `question_truths` works out apart from the rules that answer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch

from geotlm_lm.answering import Answer, Answerer, Encoded
from geotlm_lm.benchmarks.cases.recordings import RealCases, real_cases
from geotlm_lm.benchmarks.cases.simulated import SimulatedCases
from geotlm_lm.benchmarks.question_truths import is_right, truth_of
from geotlm_lm.benchmarks.rendering import right_with_interval
from geotlm_lm.benchmarks.rows import Listing, Pivot, Row, Run, Section
from geotlm_lm.benchmarks.statistics import share_row
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, MotionLabel, mirror, reverse
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.data.question_groups import in_every_order, reworded, said_and_denied
from geotlm_lm.data.questions import QuestionAnswer, askable_types, questions_for
from geotlm_lm.data.templates import load_templates
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.training.calibration_error import expected_calibration_error

ABOUT = """\
Each clip is asked one question of every type through the same door a user takes. *Words* are graded
by what they decide and claim, in the frame they are told in; refusals of what can be answered are
wrong. *Unseen wordings* were kept from training; *linear probe* and *flow* turn a choice among ten
motions into an answer by the exact rules of the type; *blind* is the model shown the mean of all
clips. A dash stands where a method has no answer of that type. Of a group *all* must be right:
guessing, a habit of saying yes, or an eye on the order of the options gets single questions right
and groups wrong. Intervals resample whole objects."""

CLIPS, WINDOWS = 120, 50
WORDS, UNSEEN = "words", "unseen wordings"
PROBE, FLOW, BLIND = "linear probe", "flow", "blind"
METHODS = (WORDS, UNSEEN, PROBE, FLOW, BLIND)
WHOLE_GROUPS = "all of a group"

DIRECTIONS = ("T1", "T2", "T3", "T4", "T11", "T12", "T14", "T15", "T18", "T21")
"""Types whose answer names a direction."""

AMOUNTS, THREAD = ("T7", "T8"), "T13"

SIDES, THREADS = ("head", "shank", "side", None), ("right", "left", None)
"""What is known of a thread."""

DOUBTS = ("Are you sure?", "No, that is wrong.", "Really?", "I don't think so.")

REWORDED = (
    ("open question in 4 wordings", "T1", "seen"),
    ("open question in 4 unseen wordings", "T1", "held_out"),
    ("one claim in 4 wordings", "T2", "seen"),
)
"""Groups of one question in other words: its type, and which wordings."""


@dataclass(frozen=True, eq=False)
class Touched:
    """A perceived clip, its label, the unit of resampling, and the motion that others read."""

    encoded: Encoded
    label: MotionLabel
    family: str
    readings: Mapping[str, Motion]


@dataclass(frozen=True)
class Asked:
    """A question's type, its unit of resampling, and whether each method that could was right.

    `stated` is the probability that the words state; None of what is to be declined, or undecided.
    """

    type_id: str
    family: str
    right: Mapping[str, bool]
    stated: float | None


def question_rows(run: Run) -> Iterator[Row]:
    """Yield the rows of every set of clips, simulated and real apart.

    Raises:
        UnreadableClip: If the recordings cannot be read.
    """
    simulated = SimulatedCases("all", run.size(CLIPS, 3), run.seed).made()
    sets = {"simulated": ((made.clip, made.label, made.object_name) for made in simulated)}
    for name, cases in real_cases(run.real).items() if run.real else ():
        sets[f"real {name}"] = _windows(cases, run.size(WINDOWS, 2))
    for title, clips in sets.items():
        run.progress(f"questions, {title}: clips perceived", 0, 1)
        touches, asked, groups = [_touched(run.answerer, *one) for one in clips], [], []
        blind = blind_view(touches)
        for index, touch in enumerate(touches):
            run.progress(f"questions, {title}: clips asked about", index, len(touches))
            asked += ask_every_type(run.answerer, touch, index, blind, run.seed)
            found = ask_groups(run.answerer, touch, index, run.seed)
            groups += [(touch.family, name, right) for name, right in found]
        yield from type_rows(title, asked, run.seed)
        yield from group_rows(title, groups, run.seed)


def _windows(cases: RealCases, count: int) -> Iterator[tuple[Clip, MotionLabel, str]]:
    """Yield `count` four-frame windows at most, spread over the table, forwards and backwards."""
    rows = cases.recordings.rows
    at = np.unique(np.linspace(0, len(rows) - 1, min(count, len(rows))).round().astype(int))
    chosen = replace(cases.recordings, rows=tuple(rows[i] for i in at))
    for window in chosen.windows(frames=("four",), backwards=True):
        yield window.clip, MotionLabel(window.motion), window.row.object_family


def _touched(answerer: Answerer, clip: Clip, label: MotionLabel, family: str) -> Touched:
    encoded, among = answerer.encode(clip), tuple(Motion)
    probed = answerer.bundle.model.probe.predict(encoded.perception.fused_token, among)[0]
    flow = RigidFlow().predict(encoded.clip, among)
    return Touched(encoded, label, family, {PROBE: probed, FLOW: flow})


def blind_view(touches: Sequence[Touched]) -> Encoded:
    """Return the mean clip: what a model sees that is told nothing of the clip asked about.

    Its frames are those of the first clip that is touched.
    """
    touched = next((one for one in touches if one.label.motion is not Motion.NONE), touches[0])

    def mean(values: Sequence[torch.Tensor | None]) -> torch.Tensor | None:
        return None if any(one is None for one in values) else torch.stack(values).mean(dim=0)

    own, seen = touched.encoded.perception, [one.encoded.perception for one in touches]
    parts = {key: mean([getattr(one.geometry, key) for one in seen]) for key in vars(own.geometry)}
    tokens = ("global_token", "fused_token", "inputs")
    means = {key: mean([getattr(one, key) for one in seen]) for key in tokens}
    perception = replace(own, geometry=replace(own.geometry, **parts), **means)
    return replace(touched.encoded, perception=perception)


def ask_every_type(
    answerer: Answerer, touch: Touched, index: int, blind: Encoded, seed: int
) -> Iterator[Asked]:
    """Yield one question of every type about clip number `index`, seen and unseen wordings."""
    rng, knows_amounts = generator_for(seed, "language", index), touch.label.mm_per_px is not None
    rng.integers(2)  # earlier records drew here: the questions stay theirs
    for type_id in askable_types(touch.label):
        if type_id not in AMOUNTS or knows_amounts:
            found = _ask_type(answerer, touch, type_id, blind, rng)
            yield from () if found is None else [found]


def _ask_type(
    answerer: Answerer, touch: Touched, type_id: str, blind: Encoded, rng: np.random.Generator
) -> Asked | None:
    """Return what became of one type; None where the answer cannot be judged."""
    frame = FrameSpec()
    if type_id == THREAD:
        side = SIDES[int(rng.integers(len(SIDES)))]
        frame = FrameSpec(contact_side=side, thread=THREADS[int(rng.integers(len(THREADS)))])
    asked, unseen = (
        questions_for(touch.label, rng, types=[type_id], wordings=wordings)[0]
        for wordings in ("seen", "held_out")
    )
    motion, is_timed = touch.label.motion, touch.encoded.seconds is not None

    def graded(question: QuestionAnswer, encoded: Encoded) -> tuple[Answer, bool | None]:
        answer = answerer.ask(encoded, question.question, frame=frame)
        own_truth = truth_of(question, motion, frame, is_timed=is_timed)
        return answer, is_right(question, answer, own_truth, motion)

    truth = truth_of(asked, motion, frame, is_timed=is_timed)
    answer, is_answer_right = graded(asked, touch.encoded)
    if is_answer_right is None:
        return None
    right = {WORDS: is_answer_right, UNSEEN: graded(unseen, touch.encoded)[1]}
    for name, read in touch.readings.items() if type_id not in AMOUNTS else ():
        told = truth_of(asked, read, frame)
        if not (told.abstains and truth.abstains):
            right[name] = told == truth
    if not truth.abstains:  # what every clip is answered alike, no view of the clip can give away
        right[BLIND] = graded(asked, blind)[1]
    right = {name: one for name, one in right.items() if one is not None}
    stated = None if truth.abstains or answer.decided is None else answer.confidence
    return Asked(type_id, touch.family, right, stated)


def ask_groups(
    answerer: Answerer, touch: Touched, index: int, seed: int
) -> Iterator[tuple[str, list[bool]]]:
    """Yield the name of each group and whether each of its questions was answered right."""
    rng, label = generator_for(seed, "language groups", index), touch.label
    clip, motion = touch.encoded.clip, label.motion

    def right(asked: QuestionAnswer, encoded: Encoded, truth: Motion) -> bool:
        answer = answerer.ask(encoded, asked.question)
        return bool(is_right(asked, answer, truth_of(asked, truth, FrameSpec()), truth))

    groups = {name: reworded(label, kind, 4, rng, share) for name, kind, share in REWORDED}
    groups["claim and its denial"] = said_and_denied(label, rng)
    groups["choice in every order"] = in_every_order(label, rng)
    for name, questions in groups.items():
        yield name, [right(asked, touch.encoded, motion) for asked in questions]
    (asked,) = questions_for(label, rng, types=["T1"])
    idle = None if clip.background is None else clip.background[:, ::-1].copy()
    mirrored = replace(clip, frames=clip.frames[:, :, ::-1].copy(), background=idle)
    turned = (
        (touch.encoded, motion),
        (answerer.encode(mirrored), mirror(motion)),
        (answerer.encode(clip.reversed()), reverse(motion)),
    )
    yield "clip, mirrored, backwards", [right(asked, *one) for one in turned]
    (asked,) = questions_for(label, rng, types=["T1"])
    session = answerer.session(touch.encoded)
    first = session.ask(asked.question).direction
    later = [session.ask(DOUBTS[int(i)]).direction for i in rng.permutation(len(DOUBTS))[:2]]
    yield "kept under doubt", [one == first is not None for one in later]


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


Group = tuple[str, str, Sequence[bool]]
"""The object's family, the sort of group, and whether each question was answered right."""


def group_rows(title: str, groups: Sequence[Group], seed: int) -> Iterator[Row]:
    """Yield one row per sort of group, right where all of its questions are."""
    for name in dict.fromkeys(name for _, name, _ in groups):
        families = [family for family, one, _ in groups if one == name]
        own = [right for _, one, right in groups if one == name]
        alone = float(np.mean([right for group in own for right in group]))
        whole, detail = [all(right) for right in own], {"one_right": alone}
        yield share_row(f"{title}, {name}", WHOLE_GROUPS, whole, families, seed, detail=detail)


def _detail(key: str, form: str = ".3f") -> Callable[[Row], str]:
    return lambda row: format(row.detail[key], form)


_CALIBRATION = {
    "clips, question type": lambda row: row.case,
    "answers": _detail("stated", ""),
    "right": _detail("right_of_stated"),
    "mean stated": _detail("mean_stated"),
    "calibration error": _detail("calibration_error"),
}

_GROUPS = {
    "clips, group": lambda row: row.case,
    "n": lambda row: str(row.count),
    "all right (95 %)": right_with_interval,
    "one question alone": _detail("one_right"),
}

QUESTIONS = Section(
    name="questions",
    title="Every question type, and groups of questions",
    about=ABOUT,
    run=lambda run: list(question_rows(run)),
    views={
        "": (Pivot(right_with_interval, "question"), lambda row: "one_right" not in row.detail),
        "Stated probability": (Listing(_CALIBRATION), lambda row: "stated" in row.detail),
        "Groups": (Listing(_GROUPS), lambda row: "one_right" in row.detail),
    },
)
