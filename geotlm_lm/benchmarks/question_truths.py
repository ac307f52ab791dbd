"""What the right answer to a question is, for any motion and frame, and whether an answer is it.

Works the truth out from labels and frames alone, apart from the rules that answer by them, so that
a wrong rule is a wrong answer.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from geotlm_lm.answering import Answer
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, SLIDES, Motion, mirror, motion_class, reverse
from geotlm_lm.core.tolerance import within_tolerance
from geotlm_lm.data.questions import QuestionAnswer
from geotlm_lm.data.templates import load_templates
from geotlm_lm.language.parse_answer import Slots
from geotlm_lm.query.types import THREAD_ATOMS

DECLINED = ("refusal", "comparison")
"""Kinds that one clip cannot answer."""

OF_A_RECORDING = ("when", "how-long", "how-often", "unanswerable")
"""What a question with a premise may ask that four frames cannot tell; nothing is claimed then."""

AT_REST = (Motion.STILL, Motion.NONE)

OTHER_FRAME = {"viewpoint": {"viewpoint": "object"}, "actor": {"actor": "sensor"}}
"""Kinds that are told in another frame, and in which."""


@dataclass(frozen=True)
class Truth:
    """The right answer.

    Args:
        kind: Of the question, as its template calls it.
        decided: The deciding word, or the kind of motion; None where the motion says it.
        direction: The motion claimed, from the point of view asked for; None where any may be.
        is_so: Whether what is claimed holds; None where nothing is.
        abstains: Whether it is to be declined.
        amount: How far, in `unit`, or how fast per second.
        unit: "deg" or "px", "deg/s" and "px/s" of a speed.
        seconds: That the motion takes, of a speed.
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
    """Return the right answer to `asked` about a clip of `motion`, told in `frame`.

    The question's own answer gives claim, options and amount; a speed needs a clip that is timed.
    """
    kind, told = asked.slots.kind, frame.edit.of_way(motion)
    if kind in ("verify", "negation"):
        return Truth(kind, direction=told, is_so=told == claim_of(asked))
    if kind == "choice":
        letter = {one.direction: one.letter for one in _options(asked)}.get(told)
        return Truth(kind, letter, told)
    if kind == "class":
        return Truth(kind, motion_class(motion).value)
    if kind in ("contact", "moving"):
        at_rest = (Motion.NONE,) if kind == "contact" else AT_REST
        return Truth(kind, is_so=motion not in at_rest)
    if kind in ("magnitude", "rate"):
        return _of_amount(asked, motion, seconds)
    if kind in DECLINED:
        return Truth(kind, abstains=True)
    if kind == "thread":
        return _of_thread(motion, frame)
    changed = {"mirrored": mirror, "reversed": reverse, "undo": reverse}.get(kind)
    frame = replace(frame, **OTHER_FRAME.get(kind, {}))
    told = frame.edit.of_way(changed(motion) if changed else motion)
    return Truth(kind, direction=told)


def _of_amount(asked: QuestionAnswer, motion: Motion, seconds: float | None) -> Truth:
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


def _of_thread(motion: Motion, frame: FrameSpec) -> Truth:
    told, tightens = frame.edit.of_way(motion), frame.tightens(motion)
    if motion not in DIRECTED or (motion in SLIDES and frame.contact_side != "side"):
        return Truth("thread", "neither", told)
    if tightens is None:
        return Truth("thread", abstains=True)
    return Truth("thread", "tighten" if tightens else "loosen", told)


def is_right(answer: Answer, truth: Truth) -> bool:
    """Tell whether `answer` is the right one: deciding and claiming what it should.

    An amount is right within its tolerance.
    """
    if truth.kind == "premise" and answer.kind in OF_A_RECORDING:
        return answer.abstained
    if truth.kind == "order" and answer.abstained:  # one clip shows no order, but a motion
        return True
    if answer.abstained != truth.abstains:
        return False
    if truth.abstains:
        return True
    if truth.amount is not None:
        return _is_amount(answer, truth)
    if truth.kind == "class":
        claimed = answer.direction
        return claimed is not None and motion_class(claimed).value == truth.decided
    if truth.direction not in (None, answer.direction):
        return False
    if truth.kind == "thread":
        return _is_thread(answer, truth.decided)
    if truth.is_so is not None:
        return answer.decided == ("yes" if truth.is_so != _denies(answer) else "no")
    return truth.decided in (None, answer.decided)


def _is_amount(answer: Answer, truth: Truth) -> bool:
    told = answer.amount
    if told is None or told.unit != truth.unit:
        return False
    unit = truth.unit.removesuffix("/s")
    return within_tolerance(told.value * truth.seconds, truth.amount, unit)


def _denies(answer: Answer) -> bool:
    """Tell whether an answer's yes is to the contrary of what was claimed: "is it not turning?"."""
    proposition = answer.resumed.parts[0].ask.proposition
    return proposition is not None and proposition.denies


def _is_thread(answer: Answer, truth: str) -> bool:
    """Tell whether what is said of a thread is so: asked openly, or whether it tightens."""
    proposition = answer.resumed.parts[0].ask.proposition
    if proposition is None:
        said = answer.decided or ""
        return not said.startswith(THREAD_ATOMS) if truth == "neither" else said.startswith(truth)
    holds = (proposition.literals[0].atom == truth) != _denies(answer)
    return answer.decided == ("yes" if holds else "no")


def claim_of(asked: QuestionAnswer) -> Motion:
    """Return the motion that a question claims."""
    is_true = asked.slots.kind != "negation"
    return next(one.direction for one in _options(asked) if one.verdict == is_true)


def _options(asked: QuestionAnswer) -> list[Slots]:
    answers = load_templates().types[asked.type_id].answers
    return [answers[sentence] for sentence in asked.options]
