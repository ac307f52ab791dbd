"""What is asked and never told, with a sentence that says what is; and talk that asks nothing."""

from __future__ import annotations

import re

from geotlm_lm.conversation.claims import motions_named

_WHEN = (
    "I tell how it moves between the frames used, not when: `geotlm-lm watch` tells when each "
    "motion of a recording begins and ends."
)
_FORCE = "I cannot tell force or depth; I tell which way it moves, how far and whether it touches."
_AXIS = (
    "I tell turns as drawn in the camera image, not by a sign: clockwise there is positive about "
    "an axis that points from the sensor into the object."
)
_TALK = (
    "Ask how the touched object moves: which way it turns or slides, how far, how fast, whether it "
    "touches at all, and why I say so."
)

_UNTOLD: tuple[tuple[re.Pattern[str], str], ...] = (
    (
        re.compile(
            r"^(?:(?:and|so|ok|hey)[, ]+)?when (?:is|was|does|did|do|has|will|exactly)\b"
            r"|^when\W*$"
            r"|\b(?:at|in|from) (?:what|which) (?:frame|time|moment|second)\b"
            r"|^(?:what|which) frame\b"
        ),
        _WHEN,
    ),
    (
        re.compile(
            r"\bhow deep\b|\b(?:in)?depth of\b|\bforces?\b|\bnewtons?\b|\btorque\b|\bhow hard\b"
            r"|\b(?:how much|what|which) (?:is the )?pressure\b|\bstiffness\b"
        ),
        _FORCE,
    ),
    (re.compile(r"\bright[ -]hand rule\b|\b[xyz][ -]axis\b"), _AXIS),
    (
        re.compile(
            r"(?:(?:hi|hello|hey|ok|okay|thanks?|thank you|thx|cool|great|nice|bye|goodbye|help"
            r"|quit|exit|stop|what can (?:you|i) (?:do|ask|tell)(?: you| me)?|who are you"
            r"|how does this work)(?: (?:a lot|very much|there|please|me))?[ ,.!?]*)+"
        ),
        _TALK,
    ),
)

_PLACE = re.compile(
    r"\bwhere(?: is|'s| was) (?:the |its )?(?:contact|touch|imprint)\b"
    r"|\bwhere (?:does|did|do) (?:\S+ ){1,3}touch\b|\bwhere (?:am i|are you|is it) touching\b"
    r"|\b(?:is|was) the (?:contact|touch|imprint) (?:at|on|in|near) (?:the|my) (?!move\b)"
    r"|\b(?:what|which|where) (?:is |was )?(?:the )?contact (?:place|position|location|point)\b"
    r"|^(?:the )?contact (?:place|position|location)\W*$"
)
_OF_A_MOTION = re.compile(
    r"\b(?:mov|motion|head|slid|slip|turn|travel|shift|rest|grow|larg|small|chang)\w*|\bgo(?:es|ing)?\b"
)


def untold(question: str) -> str | None:
    """Return what to say to a question that no answer of a model fits; None where one may.

    A presupposed motion ("when did it start to turn left?") is judged as such, not declined.
    """
    text = " ".join(question.lower().replace("\u2019", "'").split())
    *asking, talk = _UNTOLD
    if talk[0].fullmatch(text):
        return talk[1]
    if motions_named(text):
        return None
    return next((said for words, said in asking if words.search(text)), None)


def asks_place(question: str) -> bool:
    """Tell whether `question` asks where on the gel the contact is."""
    text = " ".join(question.lower().replace("\u2019", "'").split())
    return bool(_PLACE.search(text)) and not _OF_A_MOTION.search(text)
