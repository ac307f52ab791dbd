"""Rewrite questions about contact and slip in the wording the model was trained on.

What has left the gel, what is held and what is pressed against it are asked of contact; slip is a
slide, as in the templates, and a turn only where it is called one.
"""

from __future__ import annotations

import re

from geotlm_lm.conversation.object_names import with_generic_objects
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.question_affixes import TAIL
from geotlm_lm.conversation.text_normalisation import without_openers

_PHRASES = Phrases("canonical_wording")
_IS_TOUCHED = "Is anything touching the gel?"
_IS_LOST = "Has contact been lost?"
_IS_STILL = "Is it holding still?"
_SLIPS, _SLIDES, _TURNS = "Is it slipping?", "Is it sliding?", "Is it turning?"
_MOVES = "Is it moving at all?"

_SAID: tuple[tuple[str, str], ...] = (
    (_PHRASES.text("IS_LOST"), _IS_LOST),
    (_PHRASES.text("IS_TOUCHED"), _IS_TOUCHED),
    (_PHRASES.text("IS_PRESSED"), f"{_IS_TOUCHED} Is it pressing in?"),
    (_PHRASES.text("IS_STILL"), _IS_STILL),
    (_PHRASES.text("OPEN"), OPEN_QUESTION),
    (_PHRASES.text("SLIDES"), _SLIDES),
    (_PHRASES.text("TURNS"), _TURNS),
    (_PHRASES.text("WHICH_AXIS"), OPEN_QUESTION),
    (_PHRASES.text("MOVES"), _MOVES),
    (_PHRASES.text("SLIPS_IN_ROTATION"), _TURNS),
    (_PHRASES.text("SLIPS"), _SLIPS),
)

_PATTERNS = tuple(
    (re.compile(rf"(?:tell me[,:]? )?(?:{words}){TAIL}"), known) for words, known in _SAID
)


SLIP_IS_A_SLIDE = "Slip is taken for a slide; ask 'is it turning?' for a turn."
_NAMES_SLIP = _PHRASES.pattern("NAMES_SLIP")


def names_slip(question: str) -> bool:
    """Tell whether `question` uses the word slip for a motion."""
    return bool(_NAMES_SLIP.search(question.lower()))


def in_canonical_words(question: str) -> str:
    """Rewrite a question for contact or slip in trained wording; others stay as they are.

    What asks for anything besides stays as it is.
    """
    text = without_openers(question)
    texts = (text, *with_generic_objects(text))
    return next((known for words, known in _PATTERNS if any(map(words.fullmatch, texts))), question)
