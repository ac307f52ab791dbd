"""Build an answer from what is believed; the model's sentence is kept where it says the same."""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.answering.abstention import answer_or_abstain, neutral_answer
from geotlm_lm.answering.amount_answers import AMOUNT_KINDS, answer_amount, told_amount
from geotlm_lm.answering.answer import Answer, deciding_word, evidence
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.measured_motion import felt_of
from geotlm_lm.answering.model_query import (
    EVIDENCE_QUESTION,
    Heard,
    ModelCheck,
    ModelReply,
    TextListener,
    query_model,
    summed_timings,
)
from geotlm_lm.answering.understanding import kind_told, understood_kind
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.felt import Felt
from geotlm_lm.conversation.kinds import asked_amount, asks_direction
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
    """Answer a question that the model is asked too; `listen` gets its words so far.

    Where the question's words tell the kind of answer and nobody listens, what is decided comes
    first, and the model need not write: it is read whether it would write just that.
    """
    is_open_to_all = listen is None and not (encoded.is_untouched and asks_direction(question))
    if is_open_to_all and (kind := kind_told(bundle, encoded, question)) is not None:
        heard = ModelCheck(bundle, encoded, question)
        return _answer_of_kind(bundle, encoded, question, kind, frame, heard)
    heard = query_model(bundle, encoded, question, listen)
    return answer_heard(bundle, encoded, question, frame, heard)


def answer_heard(
    bundle: Bundle, encoded: Encoded, question: str, frame: FrameSpec, heard: ModelReply
) -> Answer:
    """Return the answer, given the model's reply to the question."""
    kind = understood_kind(bundle, encoded, question, heard)
    if kind is None:
        return neutral_answer(encoded, NOT_UNDERSTOOD, None, frame, heard.timing_ms)
    return _answer_of_kind(bundle, encoded, question, kind, frame, heard)


def _answer_of_kind(
    bundle: Bundle, encoded: Encoded, question: str, kind: str, frame: FrameSpec, heard: Heard
) -> Answer:
    if kind in RULE_KINDS:
        return answer_by_rule(bundle, encoded, question, kind, frame, heard)
    if kind in AMOUNT_KINDS:
        return answer_amount(bundle, encoded, question, kind, frame, heard)
    if kind == "evidence":
        return _evidence(bundle, encoded, frame, heard)
    text = NEEDS_MORE.get(kind) or bundle.grammar.sentence(Slots(kind))
    is_own = heard.written([text]) is not None and not heard.is_by_rule
    answer = neutral_answer(encoded, text, kind, frame, heard.timing_ms)
    return replace(answer, told_by="model") if is_own else answer


def answer_by_rule(
    bundle: Bundle,
    encoded: Encoded,
    question: str,
    kind: str,
    frame: FrameSpec,
    heard: Heard | None = None,
) -> Answer:
    """Answer a question of one of `RULE_KINDS` from what is believed.

    Args:
        bundle: The model.
        encoded: The clip.
        question: What was asked.
        kind: What it is answered as.
        frame: In which to tell.
        heard: What is known of the model's own words, where it is asked.
    """
    slots = heard and heard.slots
    verdict, motion = (slots.verdict, slots.direction) if slots else (None, None)
    asked = RuleInput(kind, felt_of(encoded, frame), question, frame, verdict, motion)
    told = answer_from_motion(asked)
    own = heard and heard.written(_own_sentences(bundle, told, kind, frame))
    told = replace(told, text=own or told.text)
    timing = {} if heard is None else heard.timing_ms
    answer = answer_or_abstain(bundle, encoded, told, kind, timing)
    is_own = own is not None and answer.text == own and not heard.is_by_rule
    answer = replace(answer, told_by="model") if is_own else answer
    if asked_amount(question) is None or told.component is None or answer.abstained:
        return answer
    return replace(answer, amount=told_amount(encoded, told.component, frame))


def is_camera_frame(frame: FrameSpec) -> bool:
    """Tell whether `frame` names every direction as the camera image shows it."""
    return replace(frame, contact_side=None, thread=None, mm_per_px=None) == CAMERA


def _own_sentences(bundle: Bundle, told: RuleAnswer, kind: str, frame: FrameSpec) -> list[str]:
    """Return the model's sentences that say what is decided, where there is no more to say."""
    if kind in ALWAYS_RULE_KINDS or not told.is_plain:
        return []
    if told.direction is not None and not is_camera_frame(frame):
        return []
    parse = bundle.grammar.parse
    return [one for one in bundle.grammar.options_for(kind) if _says(parse(one), told)]


def _says(slots: Slots, told: RuleAnswer) -> bool:
    is_same_way = slots.direction in (None, told.direction)
    is_same_way = is_same_way and slots.motion_class in (None, told.motion_class)
    return is_same_way and deciding_word(slots) == told.decided


def _evidence(bundle: Bundle, encoded: Encoded, frame: FrameSpec, heard: Heard) -> Answer:
    """Tell where the halves go: in the model's words where they conclude what is believed."""
    felt = felt_of(encoded)
    own = own_evidence(bundle, felt, heard)
    is_asked = own is not None and not heard.is_by_rule
    if own is None:
        again = ModelCheck(bundle, encoded, EVIDENCE_QUESTION)
        own = own_evidence(bundle, felt, again)
        heard = replace(heard, timing_ms=summed_timings(heard, again))
    text = f"{capitalised(halves(evidence(encoded)['regions']))}, in the camera image."
    told = RuleAnswer(text, None, CAMERA, {}, "evidence", 1.0)
    if own is not None:
        way = bundle.grammar.parse(own).direction
        sure = felt.words[way.value]
        told = RuleAnswer(own, way, CAMERA, felt.words, way.value, sure)
    answer = answer_or_abstain(bundle, encoded, told, "evidence", heard.timing_ms)
    is_own = is_asked and answer.text == own
    return replace(answer, told_by="model") if is_own else answer


def own_evidence(bundle: Bundle, felt: Felt, heard: Heard) -> str | None:
    """Return the model's sentences of evidence that conclude what is believed; None without any."""
    parse, options = bundle.grammar.parse, bundle.grammar.options_for("evidence")
    return heard.written([one for one in options if parse(one).direction in felt.state])
