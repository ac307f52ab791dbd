"""Build an answer from the model's reply.

The model's own sentence is kept where it is a valid answer; else a rule derives one from it.
"""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.answering.abstention import answer_or_abstain, neutral_answer
from geotlm_lm.answering.answer import Answer, Encoded, deciding_word, evidence, offered_letters
from geotlm_lm.answering.components import split_into_components, without_components
from geotlm_lm.answering.consistency_check import (
    CHECKED_KINDS,
    answers_unanswerable,
    claim_probabilities,
    contradicts_itself,
    contradicts_open_answer,
    ignores_moving_question,
    kind_from_open_answer,
)
from geotlm_lm.answering.measured_amounts import answer_measured
from geotlm_lm.answering.model_query import (
    AMOUNT_QUESTION,
    EVIDENCE_QUESTION,
    MOVING_QUESTION,
    RATE_QUESTION,
    ModelReply,
    TextListener,
    query_likeliest,
    query_model,
    score,
    summed_timings,
)
from geotlm_lm.answering.single_direction import AMOUNT_KINDS, open_answer_motion, with_amount_of
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.axis_claims import asks_components, axes_named
from geotlm_lm.conversation.kinds import LATER_KINDS, asked_kind, is_ruled_out
from geotlm_lm.conversation.motion_answers import (
    ALWAYS_RULE_KINDS,
    CAMERA,
    RULE_KINDS,
    VERDICTS,
    RuleAnswer,
    RuleInput,
    answer_from_motion,
)
from geotlm_lm.conversation.motion_claims import presumed_class
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.reasons import halves
from geotlm_lm.conversation.text_normalisation import normalised_text
from geotlm_lm.conversation.unanswerable import ONE_MOTION
from geotlm_lm.conversation.wording import capitalised, direction_clause, direction_sentence
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import SLIDES, Motion, motion_class
from geotlm_lm.language.parse_answer import Kind, Slots

NOT_UNDERSTOOD = "I found no words for that; ask how the touched object moves."
"""Said in place of words that are none of the answers: half-right words must not look like one."""

KNOWN_WORDS = {
    "magnitude": AMOUNT_QUESTION,
    "rate": RATE_QUESTION,
    "moving": MOVING_QUESTION,
    "evidence": EVIDENCE_QUESTION,
}
"""Kinds that no rule derives from a direction -> a question of theirs known from training."""

UNTRAINED = {
    "magnitude": "I cannot tell how far it moved: this model was not trained for amounts.",
    "rate": "I cannot tell how fast it moved: this model was not trained for amounts.",
}

NEEDS_MORE = {
    "comparison": "I see one clip only; give me a second one to compare it with.",
    "order": ONE_MOTION,
}
"""Kinds that one clip never answers, whatever the model."""

FROM_DIRECTION = "Told by rule from the direction: this model was not trained for {}."
FROM_GEOMETRY = "Told by rule from the geometry: this model was not trained for evidence."

_ASKED_ABOUT = {
    "negation": "denied claims",
    "viewpoint": "other viewpoints",
    "actor": "the sensor's own motion",
    "thread": "threads",
    "mirrored": "mirrored clips",
    "reversed": "clips played backwards",
    "premise": "claims taken for granted",
    "confidence": "its own confidence",
    "undo": "undoing",
}


def answer_in_words(
    bundle: Bundle,
    encoded: Encoded,
    question: str,
    frame: FrameSpec,
    listen: TextListener | None = None,
) -> Answer:
    """Answer a question of a kind the model was trained on; `listen` gets its words so far."""
    heard = query_model(bundle, encoded, question, listen)
    if is_ruled_out(question, heard.slots and heard.slots.kind):
        kind = asked_kind(question)
        if kind in RULE_KINDS:
            return from_open_question(bundle, encoded, question, kind, frame, heard)
        heard = _query_again(bundle, encoded, question, heard, kind)
    if ignores_moving_question(heard.slots, question):
        heard = _query_again(bundle, encoded, question, heard, "moving")
    slots = heard.slots
    if answers_unanswerable(slots, question) and "refusal" in bundle.grammar.kinds:
        text = bundle.grammar.sentence(Slots("refusal"))
        return neutral_answer(encoded, text, "refusal", frame, heard.timing_ms)
    if (kind := kind_from_open_answer(slots, question)) is not None:
        return from_open_question(bundle, encoded, question, kind, frame, heard)
    if slots is None:
        answer = neutral_answer(encoded, NOT_UNDERSTOOD, None, frame, heard.timing_ms)
        return replace(answer, options=heard.options)
    if slots.kind in NEEDS_MORE:
        return neutral_answer(encoded, NEEDS_MORE[slots.kind], slots.kind, frame, heard.timing_ms)
    if slots.kind in ALWAYS_RULE_KINDS:
        return from_open_question(bundle, encoded, question, slots.kind, frame, heard)
    if slots.kind in CHECKED_KINDS:
        opened = query_model(bundle, encoded, OPEN_QUESTION)
        heard = replace(heard, timing_ms=summed_timings(heard, opened))
        if contradicts_open_answer(slots, opened.slots, question, frame):
            opened = replace(opened, timing_ms=heard.timing_ms)
            return from_open_answer(bundle, encoded, question, slots.kind, frame, opened)
        shares = claim_probabilities(slots, opened.options, question, frame)
        heard = replace(heard, options=shares or heard.options)
    if contradicts_itself(slots, question):
        heard = replace(heard, slots=replace(slots, verdict=None))
        return _answer_from_motion(bundle, encoded, question, heard, frame)
    if slots.kind in RULE_KINDS and not is_camera_frame(frame):
        return _answer_from_motion(bundle, encoded, question, heard, frame)
    if slots.kind in AMOUNT_KINDS:
        opened = query_model(bundle, encoded, OPEN_QUESTION)
        heard = replace(heard, timing_ms=summed_timings(heard, opened))
        return answer_amount(bundle, encoded, question, heard, opened, slots.kind, frame)
    return _verbatim_answer(bundle, encoded, heard, frame)


def answer_amount(
    bundle: Bundle,
    encoded: Encoded,
    question: str,
    heard: ModelReply,
    opened: ModelReply,
    kind: Kind,
    frame: FrameSpec,
) -> Answer:
    """Answer with the amount or speed of the turn or slide that the open answer names.

    Where the question takes a turn for granted and it slides, or the other way round, or names an
    axis that it does not slide along, that is said first.

    Args:
        bundle: The model.
        encoded: The clip.
        question: What was asked.
        heard: To it, or to one of that kind.
        opened: To the open question.
        kind: Of the question.
        frame: In which to tell.
    """
    motion = open_answer_motion(opened)
    way = None if motion is None else frame.tell(motion)
    heard = with_amount_of(heard, kind, motion, opened.options)
    if heard.slots is None:
        return neutral_answer(encoded, NOT_UNDERSTOOD, None, frame, heard.timing_ms)
    if heard.slots.unit is None:
        return _verbatim_answer(bundle, encoded, heard, frame)
    answer = answer_measured(bundle, encoded, question, heard, frame)
    presumed = presumed_class(question)
    axes = axes_named(question.lower()) if motion in SLIDES else []
    if motion is None or answer.abstained:
        return answer
    is_of_parts = asks_components(normalised_text(question))
    if is_of_parts and motion in SLIDES:
        return split_into_components(encoded, answer, motion, frame)
    if is_of_parts:
        return without_components(answer, way, frame)
    if len(axes) > 1:  # of both the one is told that it goes along
        return replace(answer, text=f"{direction_sentence(way, frame)} {answer.text}")
    is_along_another = bool(axes) and way not in axes[0]
    if not is_along_another and presumed in (None, motion_class(motion)):
        return answer
    _, denial, *_ = VERDICTS["premise"]
    denial = denial.format(direction_clause(way, frame))
    return replace(answer, text=f"{denial} {answer.text}")


def _verbatim_answer(
    bundle: Bundle, encoded: Encoded, heard: ModelReply, frame: FrameSpec
) -> Answer:
    """Answer in the model's own words, unless they are withheld."""
    slots = heard.slots
    told = RuleAnswer(
        text=heard.text,
        direction=slots.direction,
        frame=CAMERA if slots.kind == "evidence" else frame,
        options=heard.options,
        decided=deciding_word(slots),
        is_refusal=slots.kind == "refusal",
    )
    answer = answer_or_abstain(bundle, encoded, told, slots, heard.timing_ms)
    is_as_heard = answer.text == heard.text and not heard.is_by_rule
    return replace(answer, told_by="model") if is_as_heard else answer


def _query_again(
    bundle: Bundle, encoded: Encoded, question: str, heard: ModelReply, kind: str | None
) -> ModelReply:
    """Return what the model says of the kind the words tell, or of one that they do not rule out.

    For amounts and evidence it is asked in words it knows.
    """
    if kind in KNOWN_WORDS:
        again = query_model(bundle, encoded, KNOWN_WORDS[kind])
        again = replace(again, is_by_rule=True)
    else:
        kinds = bundle.grammar.kinds - LATER_KINDS
        if not offered_letters(question):
            kinds -= {"choice"}
        again = query_likeliest(bundle, encoded, question, kinds)
    return replace(again, timing_ms=summed_timings(heard, again))


def answer_by_rule(
    bundle: Bundle, encoded: Encoded, question: str, kind: str, frame: FrameSpec
) -> Answer:
    """Answer a question of a kind the model was not trained on, or say that it was not."""
    if kind in NEEDS_MORE or kind in UNTRAINED:
        return neutral_answer(encoded, (NEEDS_MORE | UNTRAINED)[kind], kind, frame)
    if kind == "evidence":
        text = f"{capitalised(halves(evidence(encoded)['regions']))}, in the camera image."
        answer = neutral_answer(encoded, text, kind, CAMERA)
        notes = (*answer.notes, FROM_GEOMETRY)
        return replace(answer, abstained=False, confidence=1.0, notes=notes)
    answer = from_open_question(bundle, encoded, question, kind, frame)
    return replace(answer, notes=(*answer.notes, FROM_DIRECTION.format(_ASKED_ABOUT[kind])))


def is_camera_frame(frame: FrameSpec) -> bool:
    """Tell whether `frame` names every direction as the camera image shows it."""
    return replace(frame, contact_side=None, thread=None, mm_per_px=None) == CAMERA


def from_open_question(
    bundle: Bundle,
    encoded: Encoded,
    question: str,
    kind: str,
    frame: FrameSpec,
    before: ModelReply | None = None,
) -> Answer:
    """Ask the model the open question, and derive the answer of `kind` from its reply.

    Args:
        bundle: The model.
        encoded: The clip.
        question: What was asked.
        kind: What it is answered as.
        frame: In which to tell.
        before: What was heard before, which took its time as well.
    """
    opened = query_model(bundle, encoded, OPEN_QUESTION)
    if before is not None:
        opened = replace(opened, timing_ms=summed_timings(before, opened))
    return from_open_answer(bundle, encoded, question, kind, frame, opened)


def from_open_answer(
    bundle: Bundle, encoded: Encoded, question: str, kind: str, frame: FrameSpec, heard: ModelReply
) -> Answer:
    """Derive the answer of `kind` from the model's reply to the open question."""
    if heard.slots is None or heard.slots.direction is None:
        return neutral_answer(encoded, NOT_UNDERSTOOD, kind, frame, heard.timing_ms)
    # The verdict, if the model gave one, was on another question.
    slots = replace(heard.slots, kind=kind, verdict=None)
    return _answer_from_motion(bundle, encoded, question, replace(heard, slots=slots), frame)


def _answer_from_motion(
    bundle: Bundle, encoded: Encoded, question: str, heard: ModelReply, frame: FrameSpec
) -> Answer:
    slots, options = heard.slots, heard.options
    if slots.direction is None:  # "it slides": which way, the open question tells
        return from_open_question(bundle, encoded, question, slots.kind, frame, heard)
    if not set(options) <= {motion.value for motion in Motion}:
        # Probabilities of a verdict or of letters name no motion: those of the open question do.
        options = score(bundle, encoded, OPEN_QUESTION, "direction")
    probabilities = {Motion(word): share for word, share in options.items()}
    felt = RuleInput(slots.kind, slots.direction, question, frame, probabilities, slots.verdict)
    return answer_or_abstain(bundle, encoded, answer_from_motion(felt), slots, heard.timing_ms)
