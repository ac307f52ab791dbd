"""The seam for people and programs: load once, encode a clip once, ask many questions.

Words are those the language model writes, token by token or found in the pass that weighs the
closed set of answers; probabilities come from that pass; the evidence is the geometry the fused
token was made of. What follows exactly from a motion, a frame of reference, a time or a probability
is derived by the rules of `conversation`.
"""

from geotlm_lm.answering.abstention import LEAST_SURE
from geotlm_lm.answering.answer import (
    Answer,
    deciding_word,
    evidence,
)
from geotlm_lm.answering.answer_assembly import NOT_UNDERSTOOD
from geotlm_lm.answering.answerer import Answerer, Why
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.multi_clip import Comparison, Order
from geotlm_lm.answering.session import Session, Turn
from geotlm_lm.conversation.question import OPEN_QUESTION, check_question

__all__ = [
    "LEAST_SURE",
    "NOT_UNDERSTOOD",
    "OPEN_QUESTION",
    "Answer",
    "Answerer",
    "Comparison",
    "Encoded",
    "Order",
    "Session",
    "Turn",
    "Why",
    "check_question",
    "deciding_word",
    "evidence",
]
