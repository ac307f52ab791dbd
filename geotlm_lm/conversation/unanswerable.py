"""Recognise questions that are never answered, and reply with what can be told instead.

Talk that asks nothing is replied to here as well.
"""

from __future__ import annotations

import re

from geotlm_lm.conversation.axis_claims import claimed_axis
from geotlm_lm.conversation.kind_words import EXTENDED, PICTURE
from geotlm_lm.conversation.kinds import asks_direction
from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.motion_verbs import ENDING, GO, SLIDE, TURN
from geotlm_lm.conversation.number_words import NUMBER
from geotlm_lm.conversation.text_normalisation import normalised_text, without_openers
from geotlm_lm.conversation.unsupported_motions import unsupported_motion_reply

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

ONE_KIND = "I tell the one motion that shows most, not whether a lesser one goes with it."

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

_TURN_SIGN = re.compile(r"\bright[ -]hand rule\b|\b[xyz][ -]axis\b")

_FILLERS = frozenset(
    ("and", "so", "but", "or", "now", "then", "yes", "yeah", "yep", "no", "not", "maybe", "well")
    + ("hm", "uh", "oh", "it", "this", "that", "the", "object")
)
"""A text of these alone asks nothing."""

_UNTOLD: tuple[tuple[re.Pattern[str], str], ...] = (
    (
        re.compile(
            r"^when (?:is|was|does|did|do|has|will|exactly)\b"
            r"|^when\W*$"
            r"|\b(?:at|in|from) (?:what|which) (?:frame|time|moment|second)\b"
            r"|^(?:what|which) frame\b"
        ),
        _WHEN,
    ),
    (
        re.compile(
            r"\bhow (?:deep|hard|firmly)\b|\b(?:in)?depth of\b"
            r"|\bforces?\b|\bnewtons?\b|\btorque\b"
            r"|\b(?:how much|what|which) (?:is the )?pressure\b"
            r"|\b(?:did|does|is|was|has) the pressure\b(?! (?:knob|pad|valve|plate|switch|dial)\b)"
            r"|\bstiffness\b"
        ),
        _FORCE,
    ),
    (_TURN_SIGN, _AXIS),
    (
        re.compile(
            r"(?:(?:hi|hello|hey|ok|okay|thanks?|thank you|thx|cool|great|nice|bye|goodbye|help"
            r"|roger(?: that)?|got it(?!\W*\?)|copy(?: that)?|many thanks"
            r"|good (?:morning|afternoon|evening|day)"
            r"|quit|exit|stop|what can (?:you|i) (?:do|ask|tell)(?: you| me)?|who are you"
            r"|how does this work)(?: (?:a lot|so much|very much|there|please|me))?[ ,.!?]*)+"
        ),
        _TALK,
    ),
)

_LOAD = r"(?:\w+ )?(?:forces?|torque|newtons?|pressure)(?! (?:point|sensor|gauge|plate))"
_IN_UNIT = r"(?: in (?:mm|cm|px|pixels|millimet(?:re|er)s|centimet(?:re|er)s|microns|inches))?"
_A_THING = (
    r"(?:the|this|that|these|those|my|its|your) (?:\w+ )?"
    rf"(?!{PICTURE}|(?:{EXTENDED}|contact|touch|imprint|pixel|frame|view|path|error|amount"
    r"|change)s?\b)\w+"
)
_GOES = rf"(?:(?:com|go|head|{GO}|{SLIDE}|{TURN}){ENDING})"
_DOES_IT = r"(?:does|did|is|was|has) (?:it|this|that|(?:the|my) \w+)"
_ASIDE = (
    r"(?:left|right|top|bottom|upper|lower|sides?|up|down|other|opposite|same|halt|stop|rest"
    r"|start|beginning)\b"
)
_SENSOR = r"(?:gel|sensor|pad|skin|camera|image|picture)\b"
_THE = r"(?:the|my|your|its|an?) "
_WAY_TO = (
    rf"(?:(?:towards?|away from) (?:{_THE})?"
    rf"|(?<!relative )(?<!respect )(?<!close )(?<!parallel )(?<!compared )(?<!due )"
    r"(?<!up )(?<!thanks )(?<!next )(?<!similar )(?<!opposite )(?<!prior )(?<!according )"
    rf"to {_THE})"
)

_ACT = (
    r"(?:close|open|grip|grasp|regrasp|hold|squeeze|push|pull|lift|let go|release|stop|wait|retry"
    r"|slow down|speed up|increase|decrease|reduce|continue|proceed|go on|move on|pick|drop"
    r"|(?:tighten|loosen) (?:my|the|our) (?:grip|grasp|hold))\b"
)

_ASKS_NO_ADVICE = re.compile(
    r"\b(?:undo\w*|(?:revers|cancel|counteract)\w*|back|by \w+ing|confidence|certainty|answer"
    r"|(?:that|this|it) to (?:an?|the|one|left|right|up|down|yes|no|(?:counter|anti)?clockwise)"
    r")\b"
)
"""Asks for what undoes or brings about a motion, or of the answer: no advice."""

_NEVER: tuple[tuple[re.Pattern[str], str], ...] = (
    (
        re.compile(
            r"\b(?:press|push|squeez)\w*(?: \w+){0,3}? (?:harder|deeper|firmer|stronger|tighter"
            r"|more (?:firmly|strongly|deeply))\b|\bhow (?:strongly|tightly|heavily)\b"
        ),
        _FORCE,
    ),
    (
        re.compile(
            r"\b(?:accelerat|decelerat)(?:es?|ed|ing)\b|\b(?:speeding up|slowing down)\b"
            r"|\b(?:speeds? up|slows? down)\W*$"
            r"|\b(?:faster|slower) (?:at|near|towards?) the (?:end|start|beginning)\b"
            r"|\b(?:speed|rate|velocity) (?:\w+ ){0,2}(?:constant|steady|even|uniform)\b"
            r"|\bconstant (?:speed|rate|velocity)\b|\bacceleration\b"
            r"|\b(?:top|peak|max(?:imum)?|instantaneous|final|initial) (?:speed|rate|velocity)\b"
            r"|\b(?:speed|rate|velocity) at the (?:start|end|beginning)\b"
        ),
        _MEAN_SPEED,
    ),
    (
        re.compile(
            r"^(?:(?:should|shall|must) (?:i|we|the (?:robot|gripper))"
            rf"|do (?:i|we) (?:have|need) to) (?:now |better )?{_ACT}"
            rf"|^can (?:i|we) (?:now |safely )?{_ACT}"
            r"|^what should (?:i|we) do\b(?! to\b)"
            rf"|\bis it (?:safe|ok|okay|fine|time|wise) to {_ACT}"
        ),
        _ADVICE,
    ),
    (
        re.compile(
            r"^\W*(?:is|was|does|did|has) (?:the |this |that |its )?(?:contact|touch|imprint)"
            r"(?: area)? (?:been )?(?:get(?:ting|s)? )?(?:growing|grow|shrinking|shrink"
            r"|increas(?:e|ing)|decreas(?:e|ing)|bigger|larger|smaller|round|square|gentle|firm"
            r"|soft|hard|light|strong|weak|stable|flat|sharp)\W*$"
        ),
        _QUALITY,
    ),
    (
        re.compile(
            r"^\W*(?:is|was) (?:the |this |that |its |my )?\w+ (?:tight|loose|secure)\W*$"
            r"|\bhow (?:tight|loose|secure) (?:is|was)\b"
        ),
        _QUALITY,
    ),
    (re.compile(r"\bdiagonal(?:ly)?\W*$"), _NEAREST),
    (
        re.compile(
            rf"\b(?:how much|how many|what|which)(?: is| was)?(?: the)? {_LOAD}\b"
            rf"|\bhow (?:large|big|high|great|strong) (?:is|was) the {_LOAD}\b"
            rf"|\bamount of {_LOAD}\b"
        ),
        _FORCE,
    ),
    (
        re.compile(
            r"\bhow (?:large|big|small|wide|tall|thick) "
            rf"(?:is|was|are|were) {_A_THING}{_IN_UNIT}\W*$"
            rf"|\b(?:size|diameter|width|length|height|radius) of {_A_THING}{_IN_UNIT}\W*$"
        ),
        _SIZE,
    ),
    (
        re.compile(
            rf"\b(?:in|during|within|over|for) the (?:last|first|final) (?:(?:{NUMBER}) ?)?"
            r"(?:s|ms|secs?|seconds?|milliseconds?|frames|part|half|third|quarter)\b"
            r"(?! (?:clip|recording|video)\b)"
        ),
        _WHOLE,
    ),
    (
        re.compile(
            r"\b(?:faster|slower|quicker|further|farther) than (?:an?|the|my|your) "
            r"(?!\d|(?:first|second|third|other|last|previous|one)\b(?! hand))"
            r"|\btoo (?:far|much|fast|slow|slowly|quick|quickly|little|long)\W*$"
            r"|\b(?:far|fast|slow|much|slowly) enough\W*$"
            r"|^(?:is|was) (?:it|that|this) "
            r"(?:a lot|a little|much|little|far|fast|slow)\W*$"
        ),
        _NO_COMPARISON,
    ),
    (
        re.compile(
            r"\b(?:is|was|am|are) (?:\S+ ){1,4}?turn(?:ed|ing) (?:(?:the|my) \w+ )?"
            r"(?:up|down|on|off)\W*$"
        ),
        _SETS,
    ),
)
"""Asked in words that a rule or the model would take for another question."""

_PARTS = re.compile(
    rf"\b{_GOES} (?:again )?(?:at|near|towards?|until) the (?:very )?(?:end|start|beginning)\b"
    rf"|^\W*{_DOES_IT} {_GOES} back(?! into| (?:to the )?(?:left|right|up|down)\b)\b"
    rf"|^\W*{_DOES_IT} (?:change|switch|revers|alternat)\w*(?: (?:its|the) )? ?"
    r"(?:way|direction|sense)\b|\bback and forth\b|\bto and fro\b|\boscillat\w*"
)
"""Ask for what happens within a clip."""

_TO_A_PLACE = re.compile(
    rf"\b{_GOES} (?!(?:on|back)\b)(?:\w+ ){{0,2}}?{_WAY_TO}"
    rf"(?!(?:\w+ )?{_ASIDE}|{_SENSOR}|{_THE})\w+"
    r"|\b(?:north|south|east|west)(?:-?(?:east|west)|wards?)?\b|\b(?:proximal|distal)(?:ly)?\b"
)
"""Asks for a way that no word for a direction of the image names."""

_PLACE = re.compile(
    r"\bwhere(?: is|'s| was) (?:the |its )?(?:contact|touch|imprint)\b"
    r"|\bwhere (?:does|did|do) (?:\S+ ){1,3}touch\b|\bwhere (?:am i|are you|is it) touching\b"
    r"|\b(?:is|was) the (?:contact|touch|imprint) (?:(?:only|just|mostly|mainly|all) )?"
    r"(?:at|on|in|near) (?:the|my) (?!move\b)"
    r"|\b(?:what|which|where) (?:is |was )?(?:the )?contact (?:place|position|location|point)\b"
    r"|^(?:the )?contact (?:place|position|location|area|size)\W*$"
    r"|\b(?:touch(?:es|ing|ed)?|contact) (?:on|at|in|near) (?:the |my )?(?:left|right|upper|lower"
    r"|top|bottom|middle|centre|center|corner|edge|border)\b"
    r"|\bwhere (?:in|on|at) the (?:\S+ ){1,5}(?:touch|contact)\w*\b"
    r"|\b(?:which|what) (?:part|side|area|region|spot|half) of (?:\S+ ){1,3}touch\w*\b"
    r"|\b(?:which|what) (?:part|side|area|region|spot|half) (?:is|was) (?:being )?touch(?:ed|ing)\b"
    r"|\bhow (?:much|large|big|wide) (?:\S+ ){1,4}(?:touch(?:ed|ing)|(?<!of )(?:contact|imprint))\b"
    r"|\b(?:what|which|how (?:much|large|big) an?) "
    r"(?:fraction|share|part|percentage|portion|proportion) (?:of|is) (?:\S+ ){1,5}"
    r"(?:touch\w*|contact)\b|^and where\W*$"
    r"|\b(?:size|area) of the (?:contact|touch|imprint)\b|\bcontact area\b"
)
_OF_A_MOTION = re.compile(
    r"\b(?:mov|motion|head|slid|slip|turn|travel|shift|rest|grow|larger|enlarg|smaller|chang)\w*"
    r"|\bgo(?:es|ing)?\b"
)
_HOW_LARGE = re.compile(r"^how (?:large|small)\b")


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
