"""Yes or no to an amount that a question claims: "did it turn 45 degrees?"."""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.answering.answer import GOES_BY, Answer, Encoded
from geotlm_lm.answering.hearing import AMOUNT_QUESTION, OPEN_QUESTION, hear
from geotlm_lm.answering.measuring import NO_LENGTH, answer_measured, weighed_amounts
from geotlm_lm.answering.replying import from_open_answer, in_words
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.claims import claimed
from geotlm_lm.conversation.stated_amounts import StatedAmount, without_amount
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.evaluation.answers import RELATIVE_TOLERANCE


def judged_amount(
    bundle: Bundle, encoded: Encoded, question: str, claim: StatedAmount, frame: FrameSpec
) -> Answer:
    """Measure how far it went and judge the claim by the probabilities of all amounts.

    The way it goes is judged first, where the question claims one: what slid left has not turned by
    any number of degrees. An amount counts as the one claimed within the tolerance of an answer.

    Args:
        bundle: The model.
        encoded: The clip.
        question: What was asked.
        claim: The amount it claims.
        frame: In which to tell.
    """
    claims = claimed(without_amount(question))
    if claims is not None:
        opened = hear(bundle, encoded, OPEN_QUESTION)
        motion = opened.slots and opened.slots.direction
        if motion is not None and frame.tell(motion) not in claims:
            rest = without_amount(question)
            return from_open_answer(bundle, encoded, rest, "verify", frame, opened)
    if claim.unit == "px":
        frame = replace(frame, mm_per_px=None)  # judged in the unit it is claimed in
    heard = hear(bundle, encoded, AMOUNT_QUESTION)
    if heard.slots is None or heard.slots.unit is None:
        answer = in_words(bundle, encoded, AMOUNT_QUESTION, frame)
    else:
        answer = answer_measured(bundle, encoded, AMOUNT_QUESTION, heard, frame)
    if answer.amount is None:
        return answer if answer.abstained else replace(answer, decided="no", told_by="rule")
    said = f"{answer.text[:1].lower()}{answer.text[1:]}"
    if claim.unit == "mm" and answer.amount.unit == "px":
        text = f"I cannot judge millimetres: {said}{NO_LENGTH}"
        return replace(answer, text=text, abstained=True, confidence=0.0, decided=None)
    weighed = weighed_amounts(bundle, encoded, heard.slots.unit, frame)
    goes = heard.options[GOES_BY[heard.slots.unit]]
    share = 1.0 - goes
    if weighed.unit == claim.unit:
        tolerance = max(weighed.tolerance, RELATIVE_TOLERANCE * claim.value)
        held = [claim.holds(amount, tolerance) for amount in weighed.amounts]
        share = goes * float(weighed.shares[held].sum())
    is_so = share >= 0.5
    return replace(
        answer,
        text=f"{'Yes' if is_so else 'No'}, {said}",
        confidence=share if is_so else 1.0 - share,
        options={"yes": share, "no": 1.0 - share},
        decided="yes" if is_so else "no",
        told_by="rule",
    )
