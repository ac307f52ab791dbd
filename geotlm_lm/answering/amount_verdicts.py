"""Judge an amount that a question claims: "did it turn 45 degrees?" -> yes or no."""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.answering.answer import KIND_OF_UNIT, Answer, Encoded
from geotlm_lm.answering.answer_assembly import answer_amount, from_open_answer
from geotlm_lm.answering.measured_amounts import NO_LENGTH, amount_distribution
from geotlm_lm.answering.model_query import (
    AMOUNT_QUESTION,
    RATE_QUESTION,
    ModelReply,
    query_model,
    summed_timings,
)
from geotlm_lm.answering.single_direction import open_answer_motion, with_amount_of
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.motion_claims import claimed_motions
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.stated_amounts import Stated, denies_amount, without_amount
from geotlm_lm.conversation.wording import decapitalised
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE

_DENIALS = {True: "Yes, that is so: ", False: "No, that is not so: "}
"""Before the amount, where a question denies one: a bare "no" could be read either way."""


def judge_amount_claim(
    bundle: Bundle, encoded: Encoded, question: str, claim: Stated, frame: FrameSpec
) -> Answer:
    """Measure the amount or speed and judge the claim by the probabilities of all amounts.

    The way it goes is judged first, where the question claims one: what slid left has not turned by
    any number of degrees. An amount counts as the one claimed within the tolerance of an answer.

    Args:
        bundle: The model.
        encoded: The clip.
        question: What was asked.
        claim: The amount it claims.
        frame: In which to tell.
    """
    opened = query_model(bundle, encoded, OPEN_QUESTION)
    is_denied = denies_amount(question)
    claims = None if is_denied else claimed_motions(without_amount(question))
    motion = opened.slots and opened.slots.direction
    if claims is not None and motion is not None and frame.tell(motion) not in claims:
        rest = without_amount(question)
        return from_open_answer(bundle, encoded, rest, "verify", frame, opened)
    unit = claim.unit.removesuffix("/s")
    if unit == "px":
        frame = replace(frame, mm_per_px=None)  # judged in the unit it is claimed in
    kind = "rate" if claim.is_speed else "magnitude"
    known = RATE_QUESTION if claim.is_speed else AMOUNT_QUESTION
    heard = query_model(bundle, encoded, known)
    heard = replace(heard, timing_ms=summed_timings(heard, opened))
    heard = with_amount_of(heard, kind, open_answer_motion(opened), opened.options)
    answer = answer_amount(bundle, encoded, known, heard, opened, kind, frame)
    if answer.amount is None:
        decided = "yes" if is_denied else "no"
        return answer if answer.abstained else replace(answer, decided=decided, told_by="rule")
    if unit == "mm" and answer.amount.unit.startswith("px"):
        text = f"I cannot judge millimetres: {decapitalised(answer.text)}{NO_LENGTH}"
        return replace(answer, text=text, abstained=True, confidence=0.0, decided=None)
    share = _share(bundle, encoded, claim, heard, frame)
    share = 1.0 - share if is_denied else share
    is_so = share >= 0.5
    verdict = _DENIALS[is_so] if is_denied else ("Yes, " if is_so else "No, ")
    return replace(
        answer,
        text=f"{verdict}{decapitalised(answer.text)}",
        confidence=share if is_so else 1.0 - share,
        options={"yes": share, "no": 1.0 - share},
        decided="yes" if is_so else "no",
        told_by="rule",
    )


def _share(
    bundle: Bundle, encoded: Encoded, claim: Stated, heard: ModelReply, frame: FrameSpec
) -> float:
    """Return the probability of the claim; of one in another unit, that it goes no way at all."""
    weighed = amount_distribution(bundle, encoded, heard.slots.unit, frame)
    goes = heard.options[KIND_OF_UNIT[heard.slots.unit]]
    if weighed.unit != claim.unit.removesuffix("/s"):
        return 1.0 - goes
    seconds = encoded.seconds if claim.is_speed else 1.0
    least = weighed.tolerance / seconds
    tolerances = [max(least, RELATIVE_TOLERANCE * end) for end in claim.ends]
    held = [claim.holds(amount / seconds, *tolerances) for amount in weighed.amounts]
    return goes * float(weighed.shares[held].sum())
