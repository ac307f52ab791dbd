"""The seam for people and programs: load once, encode a clip once, ask many questions.

A question is read into a `Query`, decided exactly from what is believed of the clip, and told: in
the language model's own words where it would write just that, else by rule.
"""

from geotlm_lm.answering.answer import Answer, Comparison, Why
from geotlm_lm.answering.answerer import CAMERA, Answerer
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.session import Session, Turn
from geotlm_lm.answering.withholding import LEAST_SURE

__all__ = [
    "CAMERA",
    "LEAST_SURE",
    "Answer",
    "Answerer",
    "Comparison",
    "Encoded",
    "Session",
    "Turn",
    "Why",
]
