"""What the right answer to a question is, for any motion and frame, and whether an answer is it.

Works the truth out from labels and frames alone, apart from the rules that answer by them, so that
a wrong rule is a wrong answer. A reader of motions without words (a probe, optical flow) is graded
by the same truth: it is right where the motion it reads has the same answer.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from geotlm_lm.answering.amounts import amount_in
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import (
    ROTATIONS,
    SLIDES,
    Motion,
    mirror,
    motion_class,
    reverse,
)
from geotlm_lm.data.groups import CLAIMING
from geotlm_lm.data.questions import QuestionAnswer
from geotlm_lm.data.templates import load_templates
from geotlm_lm.evaluation.answers import within_tolerance
from geotlm_lm.language.parse_answer import Slots

if TYPE_CHECKING:
    from geotlm_lm.answering import Answer

VERDICTS = {
    "verify": ("yes", "no"),
    "contact": ("yes", "no"),
    "moving": ("yes", "no"),
    "negation": ("it is", "it is not"),
    "premise": ("it holds", "it does not"),
}
"""Deciding words where the claim is true, and where it is not."""

NEEDS_ANOTHER_CLIP = ("comparison", "order")


@dataclass(frozen=True)
class Truth:
    """The right answer.

    Args:
        decided: Its deciding word; None where it decides nothing.
        direction: The motion it claims, in its frame; None where it claims none.
        abstains: Whether the right answer is to decline.
        amount: How far it goes, in the unit of `unit`; None where no amount is asked.
        unit: "deg" or "px".
    """

    decided: str | None = None
    direction: Motion | None = None
    abstains: bool = False
    amount: float | None = None
    unit: str | None = None


def truth_of(
    asked: QuestionAnswer, motion: Motion, frame: FrameSpec, *, is_timed: bool = True
) -> Truth:
    """Return the right answer to `asked` about a clip of `motion`, told in `frame`.

    Args:
        asked: The question; its own true answer gives the claim, the options and the amount.
        motion: What moves, in the camera image.
        frame: The frame the answer is to be told in.
        is_timed: Whether the clip has a time, which a speed needs.
    """
    kind = asked.slots.kind
    told = frame.tell(motion)
    if kind in CLAIMING:
        return Truth(VERDICTS[kind][told != claim_of(asked)], told)
    if kind == "choice":
        letter = letters_of(asked).get(told)
        return Truth(letter and f"{letter}) {told.value}", told)
    if kind == "class":
        return Truth(motion_class(motion).value)
    if kind in ("contact", "moving"):
        at_rest = (Motion.NONE,) if kind == "contact" else (Motion.NONE, Motion.STILL)
        return Truth(VERDICTS[kind][motion in at_rest])
    if kind in ("magnitude", "rate"):
        if motion not in (*ROTATIONS, *SLIDES):
            return Truth(motion.value, motion)
        return Truth(
            abstains=kind == "rate" and not is_timed, amount=asked.amount, unit=asked.slots.unit
        )
    if kind == "refusal" or kind in NEEDS_ANOTHER_CLIP:
        return Truth(abstains=True)
    if kind == "thread":
        return _of_thread(motion, frame)
    return _of_frame(kind, motion, frame)


def _of_frame(kind: str, motion: Motion, frame: FrameSpec) -> Truth:
    """Return the motion itself, changed and told as this kind of question wants it."""
    if kind == "viewpoint":
        told = replace(frame, viewpoint="object").tell(motion)
    elif kind == "actor":
        told = replace(frame, actor="sensor").tell(motion)
    elif kind == "mirrored":
        told = frame.tell(mirror(motion))
    elif kind in ("reversed", "undo"):
        told = frame.tell(reverse(motion))
    elif kind == "evidence":
        told = motion
    else:
        told = frame.tell(motion)
    return Truth(told.value, told)


def _of_thread(motion: Motion, frame: FrameSpec) -> Truth:
    if motion not in (*ROTATIONS, *SLIDES):
        return Truth("neither", frame.tell(motion))
    if frame.contact_side == "side":
        return Truth(abstains=True)
    if motion in SLIDES:
        return Truth("neither", frame.tell(motion))
    tightens = frame.tightens(motion)
    if tightens is None:
        return Truth(abstains=True)
    return Truth("tightens" if tightens else "loosens", frame.tell(motion))


def is_right(asked: QuestionAnswer, answer: Answer, truth: Truth) -> bool:
    """Tell whether `answer` is the right one: of the kind asked for, deciding and claiming it.

    An amount is right within its tolerance; words that are none of the answers are wrong.
    """
    if not is_understood(asked, answer) or answer.abstained != truth.abstains:
        return False
    if truth.abstains:
        return True
    if truth.amount is not None:
        return _is_near(answer.decided, truth)
    return (answer.decided, answer.direction) == (truth.decided, truth.direction)


def is_understood(asked: QuestionAnswer, answer: Answer) -> bool:
    """Tell whether an answer is of the kind asked for.

    "Seen from the object's side, which way?" may also be taken for a plain question in that frame.
    """
    if answer.kind == "direction" and asked.slots.kind == "viewpoint":
        return answer.frame.viewpoint == "object"
    if answer.kind == "direction" and asked.slots.kind == "actor":
        return answer.frame.actor == "sensor"
    return answer.kind == asked.slots.kind


def scored_is_right(answer: Answer, truth: Truth) -> bool | None:
    """Tell whether the likeliest of the options is right, whatever the words say.

    Returns:
        None where the answer scored no options, none of them could be right, or the right one is an
        amount, which is measured and no option.
    """
    if truth.abstains or truth.amount is not None or not answer.options:
        return None
    return max(answer.options, key=answer.options.get) == truth.decided


def claim_of(asked: QuestionAnswer) -> Motion:
    """Return the motion that a question claims."""
    is_true = asked.slots.kind != "negation"
    return next(one.direction for one in _options(asked) if one.verdict == is_true)


def letters_of(asked: QuestionAnswer) -> dict[Motion, str]:
    """Return the letter of every motion that a choice offers."""
    return {one.direction: one.letter for one in _options(asked)}


def _is_near(decided: str | None, truth: Truth) -> bool:
    said = amount_in(decided)
    return (
        said is not None
        and said[1] == truth.unit
        and within_tolerance(said[0], truth.amount, truth.unit)
    )


def _options(asked: QuestionAnswer) -> list[Slots]:
    answers = load_templates().types[asked.type_id].answers
    return [answers[sentence] for sentence in asked.options]
