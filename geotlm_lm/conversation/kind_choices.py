"""Recognise choices among kinds of motion and rest: "is it slipping or stationary?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_verbs import SLIDES, TURNS, forms
from geotlm_lm.conversation.text_normalisation import without_openers
from geotlm_lm.core.labels import MotionClass

REST = (
    r"(?:still|stationary|static|at rest|resting|motionless|immobile|stable|at a standstill"
    r"|not moving)"
)

_WORDS: tuple[tuple[MotionClass, str], ...] = (
    (MotionClass.ROTATION, rf"{forms(TURNS, 'base', 'gerund')}|rotation|twist|rotational"),
    (MotionClass.SLIDE, rf"{forms(SLIDES, 'base', 'gerund')}|translation|(?:gross )?slip|linear"),
    (MotionClass.PRESS, r"(?:press|push)(?:ing|ed)?(?: in| down)?"),
    (MotionClass.RELEASE, r"(?:lift|releas)(?:e|ing|ed)?(?: off)?"),
    (MotionClass.STILL, rf"{REST}|stuck|stick(?:ing)?|holding(?: still)?"),
    (MotionClass.NONE, r"nothing|no contact|untouched|not touching"),
)
_ONE = "|".join(f"(?:{words})" for _, words in _WORDS)
_LEAD = r"(?:(?:tell me|which is it)[,:]? +)*"
_IS = r"(?:is|was|does|did) (?:it|this|that|(?:the|my) \w+) "
_CHOICE = re.compile(
    rf"{_LEAD}(?:{_IS})?(?:either )?(?:just |an? )?(?P<one>{_ONE})"
    rf"(?P<others>(?:(?:,|,? or)(?: is it| is| an?| just)? (?:{_ONE}))+)"
    r"(?:,? or (?:what|else))?[ ?.!]*"
)


def offered_kinds(question: str) -> frozenset[MotionClass] | None:
    """Return the kinds of motion that `question` offers to choose from; None if none.

    Rest is one of them, and a turn or a slide another: models know choices among the others.
    """
    said = _CHOICE.fullmatch(without_openers(question))
    if said is None:
        return None
    words = re.split(r",? or (?:is it |is )?|, ", said["one"] + said["others"])
    kinds = frozenset(filter(None, map(_kind, words)))
    is_of_a_way = kinds & {MotionClass.ROTATION, MotionClass.SLIDE}
    return kinds if MotionClass.STILL in kinds and is_of_a_way else None


def _kind(word: str) -> MotionClass | None:
    word = re.sub(r"^(?:just |an? )", "", word.strip())
    return next((kind for kind, words in _WORDS if re.fullmatch(words, word)), None)
