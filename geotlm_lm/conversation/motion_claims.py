"""Find the motions that a yes-or-no question claims, by its words alone."""

from __future__ import annotations

import re

from geotlm_lm.conversation.axis_claims import claimed_axis
from geotlm_lm.conversation.motion_names import LOST_CONTACT, claimed_motion, motions_named
from geotlm_lm.conversation.option_labels import labelled
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text
from geotlm_lm.core.labels import DIRECTED, Motion, MotionClass, motion_class

_PHRASES = Phrases("motion_claims")
_BESIDES = _PHRASES.pattern("BESIDES")

CLASS_NAMES: tuple[tuple[MotionClass, str], ...] = (
    (MotionClass.ROTATION, _PHRASES.text("ANY_TURN")),
    (MotionClass.SLIDE, _PHRASES.text("ANY_SLIDE")),
)
"""Words of a kind of motion that leave its direction open."""


_VERBS: tuple[tuple[MotionClass, str], ...] = (
    (MotionClass.ROTATION, _PHRASES.text("VERB_OF_TURNING")),
    (MotionClass.SLIDE, _PHRASES.text("VERB_OF_SLIDING")),
)
"""What the touched object does by itself: no "turntable", "my turn", "turns out", "I turned it"."""

_ENDED = _PHRASES.pattern("ENDED")
_NO_END = _PHRASES.pattern("NO_END")
_TOUCHING = _PHRASES.pattern("TOUCHING")

_AT_REST = frozenset({Motion.STILL, Motion.NONE})

_ANOTHER_TIME = _PHRASES.pattern("ANOTHER_TIME")
_DENIED = _PHRASES.pattern("DENIED")
_YES_OR_NO = _PHRASES.pattern("YES_OR_NO")
_PREDICATES = _PHRASES.pattern("PREDICATES")
_OF_SOMETHING_ELSE = _PHRASES.pattern("OF_SOMETHING_ELSE")
_OR_NOT = _PHRASES.pattern("OR_NOT")
_STILL_GOING = _PHRASES.pattern("STILL_GOING", re.IGNORECASE)
_STILL_AT_END = _PHRASES.pattern("STILL_AT_END", re.IGNORECASE)


def asks_yes_or_no(text: str) -> bool:
    """Tell whether `text`, in lower case, holds a question to be answered by yes or no."""
    return bool(_YES_OR_NO.search(text))


def claimed_motion_class(text: str) -> MotionClass | None:
    """Return the one kind of motion a yes-or-no question claims without a direction, else None."""
    text = _BESIDES.sub(" ", normalised_text(text))
    if motions_named(text) or not asks_yes_or_no(text):
        return None
    named = [kind for kind, words in CLASS_NAMES if re.search(words, text)]
    return named[0] if len(named) == 1 else None


def claims_end(text: str) -> bool:
    """Tell whether a yes-or-no question claims that a motion, or the contact, is over."""
    text = _OR_NOT.sub(" ", normalised_text(text))
    if not asks_yes_or_no(text) or _ANOTHER_TIME.search(text) or _NO_END.search(text):
        return False
    return bool(_ENDED.search(text) or re.search(LOST_CONTACT, text))


def claimed_motions(question: str) -> frozenset[Motion] | None:
    """Return the motions of which a yes to `question` would be true; None if it claims none.

    A claim of a motion, of a kind of motion, or of the end of either: what has stopped turning may
    do anything but turn, and what has stopped neither turns nor slides nor presses.
    """
    if claims_end(question):
        return _left_at_the_end(normalised_text(question))
    axis = claimed_axis(question.lower())
    if axis and motions_named(question) <= axis:  # no choice: "up, down, sideways?"
        return axis
    motion, kind = claimed_motion(question), claimed_motion_class(question)
    named = {motion} - {None} or {one for one in Motion if motion_class(one) == kind}
    return frozenset(named) or None


def _left_at_the_end(text: str) -> frozenset[Motion]:
    """Return what may be true once what `text` calls over is over."""
    ended = _ENDED.search(text)
    over = text[ended.end() :] if ended else text
    if _TOUCHING.search(over):
        return frozenset({Motion.NONE, Motion.RELEASE})
    before = motions_named(text[: ended.start()])
    if before:
        return frozenset(before)  # "is it at rest, no longer moving?"
    named = motions_named(over)
    kinds = {kind for kind, words in CLASS_NAMES if re.search(words, over)} if not named else set()
    named |= {one for one in Motion if motion_class(one) in kinds}
    return frozenset(set(Motion) - named) if named - _AT_REST else _AT_REST


def presumed_class(text: str) -> MotionClass | None:
    """Return the kind of motion that an open question presumes: "Which way does it turn?".

    None where its words tell of no turn and no slide, or of both, or where they deny one. A choice
    of two ways of one kind, "cw or ccw?", takes that kind for granted too.
    """
    text = normalised_text(text)
    if _DENIED.search(text):
        return None
    kinds = {kind for kind, words in _VERBS if re.search(words, text)}
    named = motions_named(text)
    # One way alone may be a place: "the right cap".
    kinds |= {motion_class(one) for one in named if len(named) > 1 or one not in DIRECTED}
    presumed = kinds.pop() if len(kinds) == 1 else None
    return presumed if presumed in (MotionClass.ROTATION, MotionClass.SLIDE) else None


def claims_motion(text: str) -> bool:
    """Tell whether `text` surely is a yes-or-no question that claims a motion, or a kind of one.

    Touch can tell that, in whatever words the rest is asked. Of 9,000 questions from the templates
    about contact, about any motion at all or beyond touch, none passes for one.
    """
    text = _BESIDES.sub(" ", _OR_NOT.sub(" ", normalised_text(text)))
    if claims_end(text):
        return True
    if _OF_SOMETHING_ELSE.search(text):
        return False
    is_terse = re.match(r"\W*(?:moving|sliding|going) ", text) and not motions_named(text)
    if claimed_axis(text) and (is_terse or _PREDICATES.search(text)):
        return True
    if not _PREDICATES.search(text):
        return False
    kinds = {motion_class(one) for one in motions_named(text)}
    kinds |= {kind for kind, words in CLASS_NAMES if re.search(words, text)}
    if len(kinds) > 1:
        return False  # asks which of them it is
    return claimed_motion(text) is not None or claimed_motion_class(text) is not None


_BOTH = _PHRASES.pattern("BOTH")
_WEIGHED = _PHRASES.pattern("WEIGHED")


def asks_both_kinds(text: str) -> bool:
    """Tell whether `text` asks if it turns and slides at once."""
    text = normalised_text(text)
    return bool(_BOTH.search(text)) and not _WEIGHED.search(text) and _names_two_kinds(text)


def weighs_kinds(text: str) -> bool:
    """Tell whether `text` asks if it turns more than it slides, or the other way round."""
    text = normalised_text(text)
    return bool(_WEIGHED.search(text)) and _names_two_kinds(text)


def _names_two_kinds(text: str) -> bool:
    kinds = {kind for kind, words in CLASS_NAMES if re.search(words, text)}
    return len(kinds) == 2 and not motions_named(text)


def offered_options(question: str) -> dict[str, Motion]:
    """Return the motions a multiple choice offers, by letter or number.

    Each stands before its option, "A) left", or in brackets behind it, "left (A)". Options that are
    not understood are left out.
    """
    found = labelled(question.strip().upper(), lambda option: bool(motions_named(option)))
    named = {letter: claimed_motion(option) for letter, option in found}
    return {letter: motion for letter, motion in named.items() if motion is not None}


def without_adverbs(question: str) -> str:
    """Return a question without the "still" of "is it still turning?", which claims no rest."""
    return _STILL_AT_END.sub(r"\1", _STILL_GOING.sub("", question))
