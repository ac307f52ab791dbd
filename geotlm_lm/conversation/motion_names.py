"""Find the motions that a text names; ambiguous words name none."""

from __future__ import annotations

import re
from difflib import get_close_matches
from functools import lru_cache

from geotlm_lm.conversation.kind_words import GEL
from geotlm_lm.conversation.motion_verbs import TURN
from geotlm_lm.conversation.non_motion_phrases import (
    ONE_OF_TWO,
    STILL_UNCHANGED,
    UP_IN_PHRASAL_VERB,
)
from geotlm_lm.conversation.text_normalisation import normalised_text
from geotlm_lm.core.labels import Motion

KEPT = 64
"""Texts that are kept as read: many rules read one question, one after another."""

_TO = r"\b(?:to|towards?)"
_TOWARDS, _EDGE = rf"{_TO}(?: the)?", r"(?:edge|border|side|end)\b"

_SO_FAR = (
    r"(?: (?:by|at (?:least|most)|about|around|roughly|nearly|exactly|over|under"
    r"|(?:more|less) than))*"
    r"(?: (?:[\w.-]+ ){0,3}?(?:[\d.]+ ?)?(?:degrees?|degs?|\u00b0|of a turn))?"
)
_TURNING = rf"\b{TURN}(?:s|es|ed|n?ing|e)?{_SO_FAR}(?: to(?:wards)? the)?"
"""What turns left turns counterclockwise, as a cap does: "left" alone would be a slide."""

_NO_WAY = r"(?! (?:to(?:wards?)? )?(?:the )?(?:left|right|up|down|top|bottom)(?:wards?)?\b)"
"""What is pulled back to a side slides there, and is not lifted off."""

_NO_NOUN = r"(?<!\bthe )(?<!\bmy )(?<!\byour )(?<!\bits )"
"""The indent is what shows of an object, and the approach what came before."""

LOST_CONTACT = (
    r"(?<!without )\b(?:lost|los(?:e|es|ing)|broken?|breaks?|ended) (?:the |its |all )?contact\b"
    r"|\bcontact (?:(?:is|was|has|been|being|just|already) ){0,3}(?:lost|gone|broken|ended|over)\b"
    r"|\b(?:been|was|got) let go\b"
)

_NO_MOTION = re.compile(
    r"\b(?:rather than|instead of|as opposed to) (?:to(?:wards?)? )?(?:the )?(?:\w+ing )?[\w-]+"
    r"|am i right|(?:what|which|option|answer|letter|one) is right|(?:is|was|sounds?) that right"
    r"|\b(?:is|are|was|were|am) (?:he|she|we|they|you|my \w+) right\b"
    r"|(?:are|be) right|right (?:or wrong|that|to say|now)"
    r"|, right\b(?!,? (?:\w+,? )?or\b)|\b(?:upper|lower|left|right|both) hal(?:f|ves)"
    r"|(?:left|right)[ -]hand\w*"
    r"|left[ -](?:to[ -])?right|up to\b|upside[ -]down|speed\w* up|slow\w* down|screw\w* in"
    r"|look\w* (?:down|up) (?:at|on|into|from)\b"
    r"|\bwithout (?:los|break)ing (?:the )?contact\b"
    r"|\b(?:from|along|off|at) the (?:left|right|top|bottom|upper|lower)\b"
    rf"|{STILL_UNCHANGED}|{UP_IN_PHRASAL_VERB}|{ONE_OF_TWO}"
)
"""Words of motion in another sense; taken out before motions are looked for."""

NAMES: tuple[tuple[Motion, str], ...] = (
    (
        Motion.COUNTERCLOCKWISE,
        rf"\b(?:counter|anti)[ -]?clock-?wise\b|\bccw\b|{_TURNING} left(?:wards?)?\b",
    ),
    (Motion.CLOCKWISE, rf"\bclock-?wise\b|\bcw\b|{_TURNING} right(?:wards?)?\b"),
    (
        Motion.NONE,
        r"\bno contact\b|\bnot (?:touching|in contact)\b|\buntouched\b|\bout of contact\b"
        rf"|\baway from the {GEL}\b|\boff the {GEL} entirely\b|\bempty {GEL}\b|\bnothing\b"
        rf"|{LOST_CONTACT}",
    ),
    (
        Motion.STILL,
        r"\bstill\b|\bat rest\b|\bstatic\b|\bstationary\b|\bat a standstill\b"
        rf"|\bresting(?: on the {GEL})?\b|\bmotionless\b",
    ),
    (
        Motion.RELEASE,
        r"\breleas(?:e|es|ed|ing)\b|\blift(?:s|ed|ing)?\b(?: off)?|\bcom(?:es|ing) off\b"
        rf"|\blet(?:ting)? go\b|\bpull(?:s|ed|ing)? (?:away|off|back)\b{_NO_WAY}"
        r"|\b(?:detach|reced|retreat)(?:e|es|s|ed|ing)?\b|\btak(?:es|ing) off\b"
        rf"|\bleav(?:e|es|ing) (?:the |my )?{GEL}\b",
    ),
    (
        Motion.PRESS,
        r"\b(?:press|push)(?:es|ed|ing)?\b(?: in(?:to)?| down)?"
        rf"|{_NO_NOUN}\bindents?\b|\bindent(?:ed|ing)\b"
        r"|\bsink(?:s|ing)? in(?:to)?\b"
        rf"|{_NO_NOUN}\b(?:approach|land)(?:es|s|ed|ing)?\b(?! (?:the|a|my|its) (?!{GEL}\b))",
    ),
    (Motion.LEFT, r"\bleft(?:wards?)?\b"),
    (Motion.RIGHT, r"\bright(?:wards?)?\b"),
    (Motion.UP, rf"\bup(?:wards?)?\b|{_TO} the top\b|{_TOWARDS} (?:upper|top) {_EDGE}"),
    (
        Motion.DOWN,
        rf"\bdown(?:wards?)?\b|{_TO} the bottom\b|{_TOWARDS} (?:lower|bottom) {_EDGE}",
    ),
)
"""In the order they are looked for; what is found is taken out, so that "counterclockwise" names no
clockwise turn and "pressing down" no slide."""

_OFTEN_MISTYPED = (
    "clockwise",
    "counterclockwise",
    "anticlockwise",
    "left",
    "right",
    "leftwards",
    "rightwards",
    "upwards",
    "downwards",
    "down",
    "still",
    "pressing",
    "pushing",
    "lifting",
    "releasing",
    "touching",
)

ALIKE = 0.85
"""Similarity from which a word may be a mistyped other one: of "pressing" without an s it is 0.93,
of "shifting" and "lifting" 0.80."""


def motions_named(text: str) -> set[Motion]:
    """Return every motion that `text` names."""
    return set(_named(normalised_text(text)))


@lru_cache(maxsize=KEPT)
def _named(text: str) -> frozenset[Motion]:
    text = _NO_MOTION.sub(" ", text)
    found = set()
    for motion, words in NAMES:
        text, count = re.subn(words, " ", text)
        if count:
            found.add(motion)
    return frozenset(found)


def claimed_motion(text: str) -> Motion | None:
    """Return the one motion that `text` names; None if it names none, or several."""
    named = motions_named(text)
    return named.pop() if len(named) == 1 else None


def nearly_named(text: str) -> bool:
    """Tell whether a word of `text` may be a mistyped motion, such as "clokwise"."""
    words = re.findall(r"[a-z]+", _NO_MOTION.sub(" ", text.lower()))
    return any(get_close_matches(word, _OFTEN_MISTYPED, 1, ALIKE) for word in words)
