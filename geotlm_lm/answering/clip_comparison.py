"""Answer one question about two clips; `multi_clip` weighs the answers to each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from geotlm_lm.answering.amount_answers import told_amount
from geotlm_lm.answering.answer import Answer
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.measured_motion import felt_of
from geotlm_lm.answering.model_query import AMOUNT_QUESTION, RATE_QUESTION
from geotlm_lm.answering.multi_clip import (
    Comparison,
    answer_about_each,
    answer_about_one,
    asks_amount,
    compare_amounts,
    compare_directions,
    of_one_component,
)
from geotlm_lm.answering.pair_verdicts import (
    judge_amounts,
    judge_count,
    judge_each,
    judge_inverse,
    judge_kind,
    judge_mirror_or_reversal,
    judge_relation,
    judge_transformed,
)
from geotlm_lm.answering.question_routing import answer_question
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.clip_names import clips_by_number
from geotlm_lm.conversation.english import ENGLISH_ONLY, is_english
from geotlm_lm.conversation.felt import Felt
from geotlm_lm.conversation.frame_facts import read_facts
from geotlm_lm.conversation.future_questions import NO_PREDICTION, asks_future_motion
from geotlm_lm.conversation.image_rotation import unclear_rotation
from geotlm_lm.conversation.kinds import asks_from_object
from geotlm_lm.conversation.non_tactile_questions import asks_beyond_touch
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.two_clip_claims import (
    asks_inverse,
    asks_same_amount,
    claimed_count,
    claimed_each,
    claimed_relation,
    claimed_subject,
    claimed_transform,
    claims_same_kind,
    supposed_transform,
)
from geotlm_lm.conversation.two_clip_questions import (
    asks_each_amount,
    asks_of_one,
    asks_relation,
    canonical_two_clip_question,
)
from geotlm_lm.conversation.unanswerable import never_answered_reply, unanswerable_reply
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.twist import COMPONENT_OF
from geotlm_lm.language.parse_answer import Slots

COMPARED_KINDS = (
    "Of two clips I tell whether they go the same way, which one goes further or faster, and which "
    "way each of them goes; ask for one of these."
)
"""Said to a question that asks none of them."""


def compare_clips(
    bundle: Bundle, clips: Sequence[Encoded], question: str, frame: FrameSpec
) -> Comparison:
    """Answer a question about two clips that is neither empty nor too long.

    Args:
        bundle: The model.
        clips: The two.
        question: As it was typed.
        frame: In which to tell directions.
    """
    stated = read_facts(question, frame)
    asked, frame = clips_by_number(stated.rest or question), stated.frame
    asked = canonical_two_clip_question(asked) or asked
    if asks_from_object(asked):
        frame = replace(frame, viewpoint="object")
    felts = [felt_of(one, frame).seen(frame.tell) for one in clips]
    answers = [
        of_one_component(answer_question(bundle, one, OPEN_QUESTION, frame), felt, asked)
        for one, felt in zip(clips, felts, strict=True)
    ]
    if (declined := _declined(bundle, question, asked)) is not None:
        return Comparison(declined, "unknown", 0.0, True, *answers)
    if (decided := _verdict_on_pair(clips, felts, asked, frame, answers)) is not None:
        return decided
    if (one := asks_of_one(asked)) is not None:
        which, of_it = one
        answer = answer_question(bundle, clips[which], of_it or OPEN_QUESTION, frame)
        return answer_about_one(which, answer, answers)
    if asks_amount(asked):
        return _compare_amounts(clips, asked, frame, answers)
    if (kind := asks_each_amount(asked)) is not None:
        of_each = RATE_QUESTION if kind == "rate" else AMOUNT_QUESTION
        return answer_about_each(
            [answer_question(bundle, one, of_each, frame) for one in clips], answers
        )
    if not asks_relation(asked):
        return Comparison(COMPARED_KINDS, "unknown", 0.0, True, *answers)
    claim = claimed_relation(asked)
    return compare_directions(*answers) if claim is None else judge_relation(claim, answers)


def _verdict_on_pair(
    clips: Sequence[Encoded],
    felts: Sequence[Felt],
    asked: str,
    frame: FrameSpec,
    answers: Sequence[Answer],
) -> Comparison | None:
    """Return the verdict on what is claimed of two clips, or which it is; None if neither is."""
    if (image := claimed_transform(asked)) is not None:
        return judge_mirror_or_reversal(image, answers)
    if (supposed := supposed_transform(asked)) is not None:
        rest, which, change = supposed
        judge = _judge_of(rest)
        return None if judge is None else judge_transformed(judge, which, change, answers)
    if (is_one_kind := claims_same_kind(asked)) is not None:
        return judge_kind(is_one_kind, answers)
    if asks_inverse(asked):
        return judge_inverse(_compare_amounts(clips, asked, frame, answers), answers)
    if (kind := asks_same_amount(asked)) is not None:
        is_speed = kind == "rate"
        amounts = _compare_amounts(clips, asked, frame, answers, is_speed=is_speed)
        return judge_amounts(amounts, "similar")
    if asks_amount(asked):
        subject = claimed_subject(asked)
        if subject is None:
            return None
        amounts = _compare_amounts(clips, asked, frame, answers)
        return judge_amounts(amounts, ("first", "second")[subject])
    if (each := claimed_each(asked)) is not None:
        return judge_each(each, felts, answers)
    share = claimed_count(asked)
    return None if share is None else judge_count(share, felts, answers)


def _judge_of(claimed: str) -> Callable[[Sequence[Answer]], Comparison] | None:
    """Return what judges a claim on the two, of their kinds or of their ways; None of any other."""
    if (is_one_kind := claims_same_kind(claimed)) is not None:
        return partial(judge_kind, is_one_kind)
    claim = claimed_relation(claimed)
    return None if claim is None else partial(judge_relation, replace(claim, is_plain=False))


def _declined(bundle: Bundle, question: str, asked: str) -> str | None:
    """Return what to say to what no clip answers; None where two may."""
    if not is_english(question):
        return ENGLISH_ONLY
    if (missing := unclear_rotation(asked)) is not None:
        return missing
    if asks_beyond_touch(asked):
        knows = "refusal" in bundle.grammar.kinds
        return bundle.grammar.sentence(Slots("refusal")) if knows else COMPARED_KINDS
    if asks_future_motion(asked):
        return NO_PREDICTION
    return never_answered_reply(asked) or unanswerable_reply(asked)


def _compare_amounts(
    clips: Sequence[Encoded],
    question: str,
    frame: FrameSpec,
    answers: Sequence[Answer],
    *,
    is_speed: bool = False,
) -> Comparison:
    found = [
        told_amount(one, COMPONENT_OF[said.direction], frame)
        if said.direction in COMPONENT_OF
        else None
        for one, said in zip(clips, answers, strict=True)
    ]
    sizes = {one.clip.frames.shape[1:3] for one in clips}
    seconds = [one.seconds for one in clips]
    is_same_size = len(sizes) == 1
    return compare_amounts(
        question, found, seconds, answers, is_same_size=is_same_size, is_speed=is_speed
    )
