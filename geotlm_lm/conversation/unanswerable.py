"""Recognise questions that are never answered, and reply with what can be told instead.

Talk that asks nothing is replied to here as well.
"""

from __future__ import annotations

import re

from geotlm_lm.conversation.axis_claims import claimed_axis
from geotlm_lm.conversation.kinds import asks_direction
from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.number_words import NUMBER
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text, without_openers
from geotlm_lm.conversation.unsupported_motions import unsupported_motion_reply

_PHRASES = Phrases("unanswerable", NUMBER=NUMBER)
_WHEN = (
    "I tell how it moves between the frames used, not when: `geotlm-lm watch` tells when each "
    "motion of a recording begins and ends."
)
_FORCE = "I cannot tell force or depth; I tell which way it moves, how far and whether it touches."
_MEAN_SPEED = (
    "I tell one mean speed between the frames used, not how it changes: `geotlm-lm watch` tells "
    "the motions of a recording one by one."
)
_ADVICE = "I tell how the touched object moves and whether it touches, not what to do about it."
_QUALITY = "I tell whether something touches and where, not what shape or how firm a contact is."
_NO_PLACES = (
    "I tell left, right, up and down as the camera image shows them, and no way towards a thing or "
    "a point of the compass."
)
_NO_COMPARISON = (
    "I judge a speed or a distance by a number; ask for example 'is it faster than 10 degrees per "
    "second?'."
)
_SETS = "I tell which way it turns in the camera image, not what that sets."
ONE_MOTION = "I see one motion per clip; give me the parts as clips of their own, in order."
"""Said where parts of a clip are asked for."""

_NEAREST = "I tell the nearest of left, right, up and down, and no angle between them."
_AXIS = (
    "I tell turns as drawn in the camera image, not by a sign: clockwise there is positive about "
    "an axis that points from the sensor into the object."
)
_SIZE = "I tell how far it turns or slides and how much of the image it touches, not its size."
_WHOLE = (
    "I tell one motion between the frames used, as a whole; for a part of a recording choose its "
    "frames, such as by --frames 40:60."
)
_TALK = (
    "Ask how the touched object moves: which way it turns or slides, how far, how fast, whether it "
    "touches at all, and why I say so."
)

_TURN_SIGN = _PHRASES.pattern("TURN_SIGN")

_FILLERS = frozenset(_PHRASES.words("FILLERS"))

_UNTOLD: tuple[tuple[re.Pattern[str], str], ...] = (
    (_PHRASES.pattern("WHEN"), _WHEN),
    (_PHRASES.pattern("FORCE"), _FORCE),
    (_TURN_SIGN, _AXIS),
    (_PHRASES.pattern("TALK"), _TALK),
)


_ASKS_NO_ADVICE = _PHRASES.pattern("ASKS_NO_ADVICE")

_NEVER: tuple[tuple[re.Pattern[str], str], ...] = (
    (_PHRASES.pattern("HOW_HARD"), _FORCE),
    (_PHRASES.pattern("SPEED_CHANGES"), _MEAN_SPEED),
    (_PHRASES.pattern("ADVICE"), _ADVICE),
    (_PHRASES.pattern("CONTACT_QUALITY"), _QUALITY),
    (_PHRASES.pattern("TIGHTNESS"), _QUALITY),
    (_PHRASES.pattern("DIAGONAL"), _NEAREST),
    (_PHRASES.pattern("LOADS"), _FORCE),
    (_PHRASES.pattern("SIZES"), _SIZE),
    (_PHRASES.pattern("PART_OF_THE_TIME"), _WHOLE),
    (_PHRASES.pattern("COMPARED_TO_A_THING"), _NO_COMPARISON),
    (_PHRASES.pattern("SETTINGS"), _SETS),
)
"""Asked in words that a rule or the model would take for another question."""

_PARTS = _PHRASES.pattern("PARTS")
_TO_A_PLACE = _PHRASES.pattern("TO_A_PLACE")
_PLACE = _PHRASES.pattern("PLACE")
_OF_A_MOTION = _PHRASES.pattern("OF_A_MOTION")
_HOW_LARGE = _PHRASES.pattern("HOW_LARGE")


def unanswerable_reply(question: str) -> str | None:
    """Return the reply to a question that no answer fits; None where one may.

    A presupposed motion ("when did it start to turn left?") is judged as such, not declined.
    """
    text = without_openers(question)
    *asking, talk = _UNTOLD
    if talk[0].fullmatch(text) or _FILLERS.issuperset(re.findall(r"[\w']+", text)):
        return talk[1]
    if motions_named(text):
        return None
    if claimed_axis(text):
        asking = [row for row in asking if row[0] is not _TURN_SIGN]
    return next((said for words, said in asking if words.search(text)), None)


def never_answered_reply(question: str) -> str | None:
    """Return the reply to a question easily mistaken for an answerable one; else None."""
    text = without_openers(question)
    if _PARTS.search(text):
        return ONE_MOTION
    if (other := unsupported_motion_reply(text)) is not None:
        return other
    if asks_direction(text.rpartition(". ")[2]):
        return None  # "the video is slowed down. Which way does it move?"
    if _TO_A_PLACE.search(text) and not motions_named(text):
        return _NO_PLACES
    said = next((said for words, said in _NEVER if words.search(text)), None)
    return None if said == _ADVICE and _ASKS_NO_ADVICE.search(text) else said


def asks_place(question: str) -> bool:
    """Tell whether `question` asks where on the gel the contact is."""
    asked = _HOW_LARGE.sub("", without_openers(question))
    return bool(_PLACE.search(normalised_text(question))) and not _OF_A_MOTION.search(asked)
