"""Classify a question by its words alone.

For kinds a model was not trained on, and against a trained one that takes a wording it does not
know for another kind: the rules keep it from taking "and played backwards?" for a question about
the clip as it is, and "what does the camera see?" for one about a clip played backwards. They claim
none of the kinds every model holds: direction, yes or no, choice, class, contact, moving, refusal.
"""

from __future__ import annotations

import re
from functools import lru_cache

from geotlm_lm.conversation.kind_phrases import RULES
from geotlm_lm.conversation.motion_claims import offered_options
from geotlm_lm.conversation.motion_names import KEPT, claimed_motion, motions_named
from geotlm_lm.conversation.non_tactile_questions import asks_beyond_touch
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text

_PHRASES = Phrases("kinds")
LATER_KINDS = frozenset(RULES) | {"negation", "premise"}
"""Kinds the rules know by their words."""

_SEVERAL = ("comparison", "order")
"""Kinds whose words are common ones ("the same", "in order"): alone they overrule no answer of a
kind that every model holds, and none of a later kind whose words the question has as well."""

_RULES = {kind: re.compile("|".join(words)) for kind, words in RULES.items()}

_NEGATION = _PHRASES.pattern("NEGATION")
_NO_NEGATION = _PHRASES.pattern("NO_NEGATION")
_PREMISE = _PHRASES.pattern("PREMISE")
_DIRECTION = _PHRASES.pattern("DIRECTION")
_WHETHER_MOVING = _PHRASES.pattern("WHETHER_MOVING")
_MORE_THAN_DIRECTION = _PHRASES.pattern("MORE_THAN_DIRECTION")


def asks_direction(question: str) -> bool:
    """Tell whether `question` surely asks openly for the motion, and for nothing else.

    Many ways to ask it are not recognised: what is not sure is left to the model.
    """
    text = normalised_text(question)
    if asked_kind(question) is not None or claimed_motion(text) is not None:
        return False
    return bool(_DIRECTION.search(text)) and not (
        _MORE_THAN_DIRECTION.search(text) or motions_named(text) or offered_options(question)
    )


def asks_whether_moving(question: str) -> bool:
    """Tell whether `question` surely asks whether anything moves, in whatever word for it.

    A model that has never read "budge" takes it for something touch cannot tell.
    """
    return bool(_WHETHER_MOVING.search(normalised_text(question)))


def asked_amount(question: str) -> str | None:
    """Return "rate" or "magnitude" where `question` asks how fast or how far, whatever besides."""
    text = normalised_text(question)
    return next((kind for kind in ("rate", "magnitude") if _RULES[kind].search(text)), None)


def asks_from_object(question: str) -> bool:
    """Tell whether `question` asks for the view from the object's side, whatever besides."""
    return bool(_RULES["viewpoint"].search(normalised_text(question)))


def is_ruled_out(question: str, kind: str | None) -> bool:
    """Tell whether the words of `question` exclude an answer of `kind`.

    They do where they tell a later kind and the answer is of another, and where the answer is of a
    later kind whose words are missing. Of 12,600 questions from the templates, a quarter of their
    wordings held out of training, the rules name the kind of 2 wrongly and miss that of 1.

    Args:
        question: What was asked.
        kind: What the answer is to; None where it is none.
    """
    told = asked_kind(question)
    if told in _SEVERAL:
        text = normalised_text(question)
        return kind in LATER_KINDS and not (kind in _RULES and _RULES[kind].search(text))
    if told is None:
        return kind in LATER_KINDS
    return kind != told


@lru_cache(maxsize=KEPT)
def asked_kind(question: str) -> str | None:
    """Return the kind of `question` if its words tell one of the later kinds; else None."""
    text = normalised_text(question)
    if asks_beyond_touch(text):
        return None
    if claimed_motion(text) is not None:
        if _PREMISE.search(text):
            return "premise"
        if _NEGATION.search(_NO_NEGATION.sub(" ", text)):
            return "negation"
    return next((kind for kind, words in _RULES.items() if words.search(text)), None)
