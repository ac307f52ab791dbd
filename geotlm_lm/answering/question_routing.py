"""Route one question about one clip, as it was typed, to what answers it.

What needs no model is answered here: facts about the recording, what is never told, where the
contact is. A text that asks two things is answered in two parts.
"""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.answering.abstention import neutral_answer
from geotlm_lm.answering.alternatives import with_alternatives
from geotlm_lm.answering.amount_answers import answer_amount, judge_amount_claim
from geotlm_lm.answering.answer import Answer
from geotlm_lm.answering.answer_assembly import answer_by_rule, answer_in_words
from geotlm_lm.answering.contact_answer import answer_contact_location
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.merging import merge_answers
from geotlm_lm.answering.streaming import Listener, StableWords
from geotlm_lm.answering.track_answers import answer_of_track
from geotlm_lm.answering.understanding import kind_by_rule
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.alternatives import asks_alternatives
from geotlm_lm.conversation.amount_questions import asks_depth, canonical_amount_question
from geotlm_lm.conversation.canonical_wording import SLIP_IS_A_SLIDE, in_canonical_words, names_slip
from geotlm_lm.conversation.clock_words import without_clocks
from geotlm_lm.conversation.compound_questions import split_questions
from geotlm_lm.conversation.courtesies import without_courtesies
from geotlm_lm.conversation.either_or import OF_THE_END, asked_whether_over, without_opposites
from geotlm_lm.conversation.english import ENGLISH_ONLY, is_english
from geotlm_lm.conversation.frame_facts import has_trailing_rotation, read_facts
from geotlm_lm.conversation.frame_questions import (
    RELATIVE,
    asks_frame,
    asks_which_moves,
    frame_clarification,
    unknown_frame_request,
)
from geotlm_lm.conversation.future_questions import NO_PREDICTION, asks_future_motion
from geotlm_lm.conversation.image_rotation import unclear_rotation
from geotlm_lm.conversation.indirect_questions import embedded_question
from geotlm_lm.conversation.kinds import asked_kind
from geotlm_lm.conversation.motion_answers import ALWAYS_RULE_KINDS, CAMERA
from geotlm_lm.conversation.motion_claims import weighs_kinds, without_adverbs
from geotlm_lm.conversation.motion_questions import canonical_motion_question
from geotlm_lm.conversation.negation_wording import with_explicit_negation
from geotlm_lm.conversation.option_meanings import initials_spelt_out
from geotlm_lm.conversation.pixel_scale import asks_scale, known_scale_sentence, with_pixel_size
from geotlm_lm.conversation.preceding_context import without_context
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.recording_questions import (
    Topic,
    recording_sentence,
    recording_topic,
)
from geotlm_lm.conversation.reported_claims import question_about_report
from geotlm_lm.conversation.sensor_motion import as_object_motion, names_the_object
from geotlm_lm.conversation.short_questions import expanded_question
from geotlm_lm.conversation.signed_axes import (
    CLOCKWISE_IS_POSITIVE,
    asks_sign_of_turn,
    canonical_axis_question,
    counts_pixels,
)
from geotlm_lm.conversation.spelling import corrected_spelling, split_code_words
from geotlm_lm.conversation.stated_amounts import (
    UNJUDGED,
    claimed_amount,
    claims_unread_amount,
)
from geotlm_lm.conversation.statements import TURN_TOLD_AFTER, UNREAD, is_unread_statement
from geotlm_lm.conversation.text_normalisation import normalised_text
from geotlm_lm.conversation.thread_words import canonical_thread_question
from geotlm_lm.conversation.unanswerable import (
    asks_place,
    never_answered_reply,
    unanswerable_reply,
)
from geotlm_lm.conversation.wording import frame_summary
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, ROTATIONS


def answer_question(
    bundle: Bundle,
    encoded: Encoded,
    question: str,
    frame: FrameSpec,
    listen: Listener | None = None,
) -> Answer:
    """Answer a question that is neither empty nor too long.

    Args:
        bundle: The model.
        encoded: The clip.
        question: As it was typed.
        frame: In which to tell directions.
        listen: Told the model's words piece by piece, as far as they stand in the answer.
    """
    question = with_pixel_size(without_courtesies(question), encoded.clip.frames.shape[2])
    if not is_english(question):
        return neutral_answer(encoded, ENGLISH_ONLY, None, frame)
    stated = read_facts(question, frame)
    if has_trailing_rotation(stated.rest):
        rest = stated.rest[: stated.rest.rindex("?") + 1]
        answer = answer_question(bundle, encoded, rest, stated.frame, listen)
        return replace(answer, notes=(*answer.notes, TURN_TOLD_AFTER))
    if not stated.rest:
        noted = neutral_answer(
            encoded, f"Noted: {frame_summary(stated.frame)}.", "frame", stated.frame
        )
        return replace(noted, abstained=False, confidence=1.0)
    if (missing := unclear_rotation(stated.rest, question)) is not None:
        return neutral_answer(encoded, missing, "frame", stated.frame)
    if (settled := frame_clarification(stated.rest, stated.frame)) is not None:
        return neutral_answer(encoded, settled, "frame", stated.frame)
    if not stated.is_stated and is_unread_statement(stated.rest):
        return neutral_answer(encoded, UNREAD, "frame", frame)
    asked, frame = _canonical_question(stated.rest, stated.frame)
    is_whole = normalised_text(stated.rest) == normalised_text(
        question
    )  # nothing supposed, no fact told
    if is_whole and asks_future_motion(asked):
        return neutral_answer(encoded, NO_PREDICTION, "refusal", frame)
    answer = answer_of_track(encoded, stated.rest, frame)
    if answer is None:
        answer = _answer_through_other_questions(bundle, encoded, asked, frame)
    if answer is None:
        answer = _answer_without_model(bundle, encoded, asked, frame)
    if answer is not None:
        return answer
    kind = kind_by_rule(asked)
    if kind is None and (told := asked_kind(asked)) in ALWAYS_RULE_KINDS:
        kind = told
    if kind is not None:
        answer = answer_by_rule(bundle, encoded, asked, kind, frame)
    else:
        words = listen and StableWords(bundle, encoded, asked, frame, listen)
        answer = answer_in_words(bundle, encoded, asked, frame, words)
    return _with_sign_convention(stated.rest, asked, answer)


def _canonical_question(text: str, frame: FrameSpec) -> tuple[str, FrameSpec]:
    """Return what a text asks, spelt rightly and in words that rules and model know.

    With it the frame to answer in: who names the sensor or the object asks of that one's motion,
    and rows and columns are those of the image as it was recorded.
    """
    if counts_pixels(text):
        frame = CAMERA
    asked = _in_training_words(text, frame)
    if (of_it := as_object_motion(asked)) is not None:
        return _in_plain_words(of_it), replace(frame, actor="sensor")
    if frame.actor == "sensor" and names_the_object(asked):
        frame = replace(frame, actor="object")
    return _in_plain_words(asked), frame


def _in_plain_words(asked: str) -> str:
    """Return a question for a motion or an amount and no more in words that every model knows."""
    return canonical_motion_question(asked) or canonical_amount_question(asked) or asked


def _in_training_words(text: str, frame: FrameSpec) -> str:
    words = with_explicit_negation(
        split_code_words(
            without_context(corrected_spelling(without_clocks(initials_spelt_out(text))))
        )
    )
    asked = without_opposites(without_adverbs(expanded_question(embedded_question(words))))
    asked = question_about_report(asked) or asked
    asked = canonical_axis_question(asked) or in_canonical_words(asked)
    return canonical_thread_question(asked, frame.thread is not None)


def _answer_through_other_questions(
    bundle: Bundle, encoded: Encoded, asked: str, frame: FrameSpec
) -> Answer | None:
    """Return the answer to what asks, in other words, for answers to one question or to two."""
    if asks_alternatives(asked):
        return with_alternatives(answer_question(bundle, encoded, OPEN_QUESTION, frame))
    if weighs_kinds(asked):
        return answer_question(bundle, encoded, OPEN_QUESTION, frame)
    if (limited := _answerable_part(asked)) is not None:
        rest, limit = limited
        answer = answer_question(bundle, encoded, rest, frame)
        return (
            replace(answer, notes=(*answer.notes, limit)) if _is_partial(limit, answer) else answer
        )
    parts = split_questions(asked)
    if parts is None:
        return None
    return merge_answers(*(answer_question(bundle, encoded, part, frame) for part in parts))


def _is_partial(limit: str, answer: Answer) -> bool:
    """Tell whether an answer is less than was asked for; one without a way is the same anywhere."""
    if limit == OF_THE_END:
        return answer.decided == "yes"
    return answer.direction in DIRECTED and answer.kind not in _WITHOUT_WAY


_WITHOUT_WAY = ("magnitude", "rate", "moving", "contact", "class", "confidence")
"""Kinds whose answers are the same from every side."""


def _answerable_part(asked: str) -> tuple[str, str] | None:
    """Return what of a question a recording tells of, and what it does not; None where it may all.

    Whether a motion is over is limited only where it goes at all.
    """
    if (another := unknown_frame_request(asked)) is not None:
        return another
    going = asked_whether_over(asked)
    return None if going is None else (going, OF_THE_END)


def _with_sign_convention(said: str, asked: str, answer: Answer) -> Answer:
    """Return an answer on a turn with a note on what the question's words are taken to mean.

    What slip is taken for is told where it is denied, and which sign of an angle is which way where
    a sign is asked after.

    Args:
        said: The question before it was put into known words.
        asked: And after.
        answer: The answer to it.
    """
    if answer.direction not in ROTATIONS:
        return answer
    if asks_sign_of_turn(said):
        return replace(answer, notes=(*answer.notes, CLOCKWISE_IS_POSITIVE))
    if answer.decided == "no" and names_slip(asked):
        return replace(answer, notes=(*answer.notes, SLIP_IS_A_SLIDE))
    return answer


def _answer_without_model(
    bundle: Bundle, encoded: Encoded, asked: str, frame: FrameSpec
) -> Answer | None:
    """Return the answer to what no model is asked, or not in these words; None to anything else."""
    if (topic := recording_topic(asked)) is not None:
        return _answer_about_recording(encoded, topic, frame)
    if asks_scale(asked):
        said = neutral_answer(encoded, known_scale_sentence(frame.mm_per_px), "frame", frame)
        is_known = frame.mm_per_px is not None
        return replace(said, abstained=False, confidence=1.0) if is_known else said
    if asks_frame(asked):
        said = neutral_answer(
            encoded, f"I tell directions in this frame: {frame_summary(frame)}.", "frame", frame
        )
        return replace(said, abstained=False, confidence=1.0)
    if asks_depth(asked):
        return answer_amount(bundle, encoded, asked, "magnitude", frame)
    if asks_which_moves(asked):
        return neutral_answer(encoded, RELATIVE, "refusal", frame)
    kind = asked_kind(asked)
    said = never_answered_reply(asked) or (unanswerable_reply(asked) if kind is None else None)
    if said is not None:
        return neutral_answer(encoded, said, "refusal", frame)
    if kind in (None, "magnitude", "evidence", "actor") and asks_place(asked):
        return answer_contact_location(bundle, encoded)
    claim = claimed_amount(asked)
    if claim is None:
        is_unread = claims_unread_amount(asked)
        return neutral_answer(encoded, UNJUDGED, "magnitude", frame) if is_unread else None
    return judge_amount_claim(bundle, encoded, asked, claim, frame)


def _answer_about_recording(encoded: Encoded, topic: Topic, frame: FrameSpec) -> Answer:
    """Say what is known of the frames, whatever they show."""
    clip = encoded.clip
    numbers = clip.frame_numbers if encoded.track is None else tuple(encoded.track.numbers)
    text = recording_sentence(topic, clip.frames.shape[1:3], clip.fps, numbers)
    return replace(neutral_answer(encoded, text, "frame", frame), abstained=False, confidence=1.0)
