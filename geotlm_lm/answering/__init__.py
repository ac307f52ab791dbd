"""The seam for people and programs: load once, encode a clip once, ask many questions.

A question is read into a `Program`, evaluated exactly on what is believed of the clip, and told.
"""

from geotlm_lm.answering.answer import Answer, Comparison, Why
from geotlm_lm.answering.answerer import CAMERA, Answerer, Session, Turn
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.understanding import LEAST_SURE

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
