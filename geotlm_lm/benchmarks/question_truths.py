"""What the right answer to a question is, for any motion and frame, and whether an answer is it.

Works the truth out from labels and frames alone, apart from the rules that answer by them, so that
a wrong rule is a wrong answer.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from geotlm_lm.answering import Answer
from geotlm_lm.answering.amounts import amount_in
from geotlm_lm.conversation.reasons import pattern_of
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, SLIDES, Motion, mirror, motion_class, reverse
from geotlm_lm.core.tolerance import within_tolerance
from geotlm_lm.data.questions import QuestionAnswer
from geotlm_lm.data.templates import load_templates
from geotlm_lm.language.parse_answer import Slots

VERDICTS = {"negation": ("it is", "it is not"), "premise": ("it holds", "it does not")}
VERDICTS |= dict.fromkeys(("verify", "contact", "moving"), ("yes", "no"))
"""Deciding words where the claim is true, and where it is not."""

CLAIMING = frozenset({"verify", "negation", "premise"})
"""Kinds whose questions claim a motion."""

DECLINED = ("refusal", "comparison", "order")
"""Kinds that one clip cannot answer."""

OTHER_FRAME = {"viewpoint": {"viewpoint": "object"}, "actor": {"actor": "sensor"}}
"""Kinds that are told in another frame, and in which."""


@dataclass(frozen=True)
class Truth:
    """The right answer: its deciding word, the motion claimed in its frame, or an amount."""

    decided: str | None = None
    direction: Motion | None = None
    abstains: bool = False
    amount: float | None = None
    unit: str | None = None


def truth_of(
    asked: QuestionAnswer, motion: Motion, frame: FrameSpec, *, is_timed: bool = True
) -> Truth:
    """Return the right answer to `asked` about a clip of `motion`, told in `frame`.

    The question's own answer gives claim, options and amount; a speed needs a clip that is timed.
    """
    kind, told = asked.slots.kind, frame.tell(motion)
    if kind in CLAIMING:
        return Truth(VERDICTS[kind][told != claim_of(asked)], told)
    if kind == "choice":
        letter = {one.direction: one.letter for one in _options(asked)}.get(told)
        return Truth(letter and f"{letter}) {told.value}", told)
    if kind == "class":
        return Truth(motion_class(motion).value)
    if kind in ("contact", "moving"):
        at_rest = (Motion.NONE,) if kind == "contact" else (Motion.NONE, Motion.STILL)
        return Truth(VERDICTS[kind][motion in at_rest])
    if kind in ("magnitude", "rate") and motion in DIRECTED:
        is_declined = kind == "rate" and not is_timed
        return Truth(abstains=is_declined, amount=asked.amount, unit=asked.slots.unit)
    if kind in DECLINED:
        return Truth(abstains=True)
    if kind == "thread":
        return _of_thread(motion, frame)
    if kind in ("magnitude", "rate", "evidence"):
        return Truth(motion.value, motion)
    changed = {"mirrored": mirror, "reversed": reverse, "undo": reverse}.get(kind)
    frame = replace(frame, **OTHER_FRAME.get(kind, {}))
    told = frame.tell(changed(motion) if changed else motion)
    return Truth(told.value, told)


def _of_thread(motion: Motion, frame: FrameSpec) -> Truth:
    told, tightens = frame.tell(motion), frame.tightens(motion)
    if motion not in DIRECTED or (motion in SLIDES and frame.contact_side != "side"):
        return Truth("neither", told)
    if tightens is None:
        return Truth(abstains=True)
    return Truth("tightens" if tightens else "loosens", told)


def is_right(asked: QuestionAnswer, answer: Answer, truth: Truth, motion: Motion) -> bool | None:
    """Tell whether `answer` is the right one: of the kind asked for, deciding and claiming it.

    An amount is right within its tolerance; words that are none of the answers are wrong. Evidence
    by rule says where the halves go, not which motion that is: the whole must go the way of
    `motion`; None where there is no way to go.
    """
    is_by_rule = answer.told_by == "rule" and not answer.abstained
    if is_by_rule and answer.kind == "evidence" == asked.slots.kind:
        pattern = pattern_of(answer.evidence["regions"])
        return bool(pattern.along(motion) > 0) if motion in DIRECTED else None
    if not _is_of_kind(answer, asked.slots.kind) or answer.abstained != truth.abstains:
        return False
    if truth.abstains:
        return True
    if truth.amount is None:
        return (answer.decided, answer.direction) == (truth.decided, truth.direction)
    amount, unit = amount_in(answer.decided) or (0.0, None)
    return unit == truth.unit and within_tolerance(amount, truth.amount, unit)


def _is_of_kind(answer: Answer, kind: str) -> bool:
    """Tell whether an answer is of the kind asked for.

    "Seen from the object's side, which way?" may also be taken for a plain question in that frame.
    """
    if answer.kind == "direction" and kind in OTHER_FRAME:
        return replace(answer.frame, **OTHER_FRAME[kind]) == answer.frame
    return answer.kind == kind


def claim_of(asked: QuestionAnswer) -> Motion:
    """Return the motion that a question claims."""
    is_true = asked.slots.kind != "negation"
    return next(one.direction for one in _options(asked) if one.verdict == is_true)


def _options(asked: QuestionAnswer) -> list[Slots]:
    answers = load_templates().types[asked.type_id].answers
    return [answers[sentence] for sentence in asked.options]
