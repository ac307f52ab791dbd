"""Build an answer from what is felt; the model's sentence is kept where it says the same."""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.answering.abstention import answer_or_abstain, neutral_answer
from geotlm_lm.answering.amount_answers import AMOUNT_KINDS, answer_amount, told_amount
from geotlm_lm.answering.answer import Answer, deciding_word, evidence
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.measured_motion import felt_of
from geotlm_lm.answering.model_query import (
    EVIDENCE_QUESTION,
    ModelReply,
    TextListener,
    query_model,
    summed_timings,
)
from geotlm_lm.answering.understanding import understood_kind
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.kinds import asked_amount
from geotlm_lm.conversation.motion_answers import (
    ALWAYS_RULE_KINDS,
    CAMERA,
    RULE_KINDS,
    RuleAnswer,
    RuleInput,
    answer_from_motion,
)
from geotlm_lm.conversation.reasons import halves
from geotlm_lm.conversation.unanswerable import ONE_MOTION
from geotlm_lm.conversation.wording import capitalised
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.language.parse_answer import Slots

NOT_UNDERSTOOD = "I found no words for that; ask how the touched object moves."
"""Said in place of words that are none of the answers: half-right words must not look like one."""

NEEDS_MORE = {
    "comparison": "I see one clip only; give me a second one to compare it with.",
    "order": ONE_MOTION,
}
"""Kinds that one clip never answers, whatever the model."""


def answer_in_words(
    bundle: Bundle,
    encoded: Encoded,
    question: str,
    frame: FrameSpec,
    listen: TextListener | None = None,
) -> Answer:
    """Answer a question that the model is asked too; `listen` gets its words so far."""
    heard = query_model(bundle, encoded, question, listen)
    return answer_heard(bundle, encoded, question, frame, heard)


def answer_heard(
    bundle: Bundle, encoded: Encoded, question: str, frame: FrameSpec, heard: ModelReply
) -> Answer:
    """Return the answer, given the model's reply to the question."""
    kind = understood_kind(bundle, encoded, question, heard)
    if kind is None:
        return neutral_answer(encoded, NOT_UNDERSTOOD, None, frame, heard.timing_ms)
    if kind in RULE_KINDS:
        return answer_by_rule(bundle, encoded, question, kind, frame, heard)
    if kind in AMOUNT_KINDS:
        return answer_amount(bundle, encoded, question, kind, frame, heard)
    if kind == "evidence":
        return _evidence(bundle, encoded, frame, heard)
    text = NEEDS_MORE.get(kind) or bundle.grammar.sentence(Slots(kind))
    answer = neutral_answer(encoded, text, kind, frame, heard.timing_ms)
    is_own = text == heard.text and not heard.is_by_rule
    return replace(answer, told_by="model") if is_own else answer


def answer_by_rule(
    bundle: Bundle,
    encoded: Encoded,
    question: str,
    kind: str,
    frame: FrameSpec,
    heard: ModelReply | None = None,
) -> Answer:
    """Answer a question of one of `RULE_KINDS` from what is felt.

    Args:
        bundle: The model.
        encoded: The clip.
        question: What was asked.
        kind: What it is answered as.
        frame: In which to tell.
        heard: The model's reply to it, where it was asked.
    """
    slots = heard and heard.slots
    verdict, motion = (slots.verdict, slots.direction) if slots else (None, None)
    felt = felt_of(bundle, encoded, frame)
    asked = RuleInput(kind, felt, question, frame, verdict, motion)
    told, is_own = answer_from_motion(asked), False
    if heard is not None and _says(heard, told, kind, frame):
        told, is_own = replace(told, text=heard.text), True
    timing = {} if heard is None else heard.timing_ms
    answer = answer_or_abstain(bundle, encoded, told, kind, timing)
    is_own = is_own and answer.text == told.text and not heard.is_by_rule
    answer = replace(answer, told_by="model") if is_own else answer
    if asked_amount(question) is None or told.component is None or answer.abstained:
        return answer
    return replace(answer, amount=told_amount(encoded, told.component, frame))


def is_camera_frame(frame: FrameSpec) -> bool:
    """Tell whether `frame` names every direction as the camera image shows it."""
    return replace(frame, contact_side=None, thread=None, mm_per_px=None) == CAMERA


def _says(heard: ModelReply, told: RuleAnswer, kind: str, frame: FrameSpec) -> bool:
    """Tell whether the model's sentence says what is decided, and there is no more to say."""
    slots = heard.slots
    if slots is None or slots.kind != kind or kind in ALWAYS_RULE_KINDS or not told.is_plain:
        return False
    if told.direction is not None and not is_camera_frame(frame):
        return False
    is_same_way = slots.direction in (None, told.direction)
    is_same_way = is_same_way and slots.motion_class in (None, told.motion_class)
    return is_same_way and deciding_word(slots) == told.decided


def _evidence(bundle: Bundle, encoded: Encoded, frame: FrameSpec, heard: ModelReply) -> Answer:
    """Tell where the halves go: in the model's words where they conclude what is felt."""
    if "evidence" in bundle.grammar.kinds and (not heard.slots or heard.slots.kind != "evidence"):
        again = query_model(bundle, encoded, EVIDENCE_QUESTION)
        heard = replace(again, timing_ms=summed_timings(heard, again), is_by_rule=True)
    text = f"{capitalised(halves(evidence(encoded)['regions']))}, in the camera image."
    told = RuleAnswer(text, None, CAMERA, {}, "evidence", 1.0)
    slots, felt = heard.slots, felt_of(bundle, encoded)
    is_felt = slots and slots.kind == "evidence" and slots.direction in felt.state
    if is_felt:
        sure = felt.words[slots.direction.value]
        told = RuleAnswer(
            heard.text, slots.direction, CAMERA, felt.words, slots.direction.value, sure
        )
    answer = answer_or_abstain(bundle, encoded, told, "evidence", heard.timing_ms)
    is_own = is_felt and answer.text == heard.text and not heard.is_by_rule
    return replace(answer, told_by="model") if is_own else answer
