"""Add the amount to a verdict on the motion that a question for an amount presumes."""

from __future__ import annotations

from geotlm_lm.answering.answer import KIND_OF_UNIT, Answer, Encoded
from geotlm_lm.answering.measured_amounts import answer_measured
from geotlm_lm.answering.merging import merge_answers
from geotlm_lm.answering.model_query import ModelReply
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.kinds import asked_amount
from geotlm_lm.conversation.motion_answers import VERDICTS
from geotlm_lm.core.labels import DIRECTED, motion_class
from geotlm_lm.language.parse_answer import Slots


def with_amount(bundle: Bundle, encoded: Encoded, question: str, answer: Answer) -> Answer:
    """Return the verdict on a presumed motion together with the amount that was asked for.

    "How far did it slide left?" of what slides right is told that it goes right, then how far.
    Where no amount can be told, a motion that is denied stands alone, and of one that holds it is
    said why not.
    """
    kind = asked_amount(question)
    if answer.kind != "premise" or answer.abstained or answer.direction not in DIRECTED:
        return answer
    if kind is None or kind not in bundle.grammar.kinds:
        return answer
    goes = motion_class(answer.direction).value
    unit = next(unit for unit, word in KIND_OF_UNIT.items() if word == goes)
    heard = ModelReply(Slots(kind, unit=unit), "", {goes: answer.confidence})
    amount = answer_measured(bundle, encoded, question, heard, answer.frame)
    is_denied = answer.decided == VERDICTS["premise"][3]
    return answer if is_denied and amount.abstained else merge_answers(answer, amount)
