"""Classify questions about two clips: how they relate, or something about one of them."""

from __future__ import annotations

import re

from geotlm_lm.conversation.clip_names import named_alone, place_named
from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.motion_verbs import GO, SLIDE, TURN
from geotlm_lm.conversation.text_normalisation import normalised_text, without_openers

_MOTION_NOUN = (
    r"(?:ways?|directions?|sense|motions?|movements?|rotations?|turns?|turning|slides?|sliding"
    r"|(?:kind|type|sort)s? of (?:motion|movement)s?)"
)
_MOTION = re.compile(
    rf"\b{_MOTION_NOUN}\b|\b(?:go(?:es|ing)?|went)\b"
    rf"|\b(?:head|{GO}|{SLIDE}|{TURN})\w*"
)
_RELATION = re.compile(
    r"\b(?:same|opposites?|differ\w*|compar\w*|alike|similar\w*|identical\w*|equal\w*"
    r"|match(?:es|ed|ing)?|agree[sd]?|disagree[sd]?|related?|in sync)\b"
)
_SAME_WAY = re.compile(
    r"\b(?:same|opposite|different|similar|identical|equal) (?:\w+ ){0,2}"
    rf"(?:{_MOTION_NOUN}|spins?|twists?)\b"
    r"|\bdo(?:es|ing)? (?:exactly )?the (?:same|opposite) thing\b"
    rf"|\b(?:differ\w*|comparison|compare) (?:in|between|of)?(?: the(?:ir)?)? ?{_MOTION_NOUN}\b"
)
_NO_NOUN = (
    r"(?:or|and|as|in|to|for|from|than|with|between|at|here|now|again|not|too|please|then|clips?"
    r"|recordings?|videos?|ones?)"
)
_OF_SOMETHING_ELSE = re.compile(
    rf"\b(?:same|different|similar|identical|equal) (?!{_NO_NOUN}\b)[a-z]+"
    r"|\b(?:looks?|sounds?|feels?|smells?|tastes?)\b"
)

_EACH_ALIKE = re.compile(
    r"^\W*(?:please )?(?:describe|tell me about|report) (?:both|each|them|the two)\b"
)

_EACH_AMOUNT = re.compile(r"\bhow (?:far|much|fast|quick(?:ly)?|slow(?:ly)?)\b")
_EACH_RATE = re.compile(r"\b(?:fast|quick|quickly|slow|slowly)\b")

_OF_BOTH = re.compile(
    r"\b(?:than|further|farther|more|less|larger|smaller|faster|slower|they|them|both|these|two"
    r"|other|this|that|like|it)\b"
)
_WITHIN = re.compile(r"(?:^| )in $")
_IT = re.compile(r"\bit\b")
_NOTHING_ASKED = re.compile(r"\W*(?:and|so|ok|now|what|how|about|of|[ ,])*\bits?\b\W*")

_BETWEEN = (
    r"(?:,? (?:between (?:them|the two(?: clips)?)|from (?:the )?(?:first|one)(?: clip)? to"
    r" (?:the )?(?:second|other|next)(?: clip| one)?|in between|since))?"
)
_THE_WAY = r"(?:it|this|that|the (?:direction|motion|movement|way|sense)(?: of \w+)?)"
_SAID = tuple(
    (re.compile(rf"(?:{words}){_BETWEEN}\W*"), known)
    for words, known in (
        (
            rf"(?:did|has|have|was) {_THE_WAY} (?:been )?(?:chang|switch)(?:e|es|ed)?"
            r"(?: (?:its |the )?(?:way|direction|sense))?",
            "Are they different?",
        ),
        (
            rf"(?:did|has|was|is) {_THE_WAY} (?:been |now )?(?:revers(?:e|ed|ing)"
            r"(?: (?:its |the )?(?:way|direction|sense))?)",
            "Are they opposite?",
        ),
        (
            r"(?:by )?how (?:much|far) (?:do|did) (?:they|the two|these two) differ"
            r"|(?:what(?:'s| is) )?the difference (?:in|of) "
            r"(?:angles?|distances?|amounts?|degrees|sizes?)",
            "How far did each one go?",
        ),
        (
            rf"(?:is|was) {_THE_WAY} back(?: (?:again|where it (?:was|started|began)|in place))?"
            rf"|(?:did|has) {_THE_WAY} (?:go|gone|come|moved?|(?:re)?turn(?:ed)?)"
            r" (?:back(?: to)?|to) where it (?:was|started|began)",
            "Does the second undo the first?",
        ),
    )
)
"""What is asked of two clips without a word for either of them."""

_BEFORE = r"(?:before|last time|the (?:one before|previous (?:one|time|clip|turn|slide)))"
_THAN_BEFORE = rf"(?: than (?:{_BEFORE}|the last (?:one|time|clip|turn|slide)))"
_MORE_THAN_BEFORE = re.compile(
    r"(?:(?:is|was|did|does|has) )?(?:(?:it|this|that)(?: one)? )?"
    rf"(?:(?:(?P<slide>{SLIDE})|(?P<turn>{TURN})|go|went|going|gone|{GO})\w* )?"
    rf"(?P<more>faster|slower|quicker|further|farther|more|less){_THAN_BEFORE}\W*"
    r"|(?:is|was) this one (?P<so>faster|slower|quicker|further|farther)\W*"
)
_FURTHER = {"more": "further"}
_THE_FIRST = re.compile(rf"(?:(?:what about|how about) )?{_BEFORE}\W*")


def canonical_two_clip_question(question: str) -> str | None:
    """Rewrite a question on what changed between two clips in trained wording, else None."""
    text = without_openers(question)
    if (said := _MORE_THAN_BEFORE.fullmatch(text)) is not None:
        more = said["more"] or said["so"]
        verb = "slide" if said["slide"] else "turn" if said["turn"] else "go"
        return f"Does the second {verb} {_FURTHER.get(more, more)} than the first?"
    if _THE_FIRST.fullmatch(text) and text.strip(" ?!.") not in ("before", "last time"):
        return "And the first one?"
    return next((known for words, known in _SAID if words.fullmatch(text)), None)


def asks_relation(question: str) -> bool:
    """Tell whether `question` asks for the directions of two clips, or if they are equal.

    "Are they the same?" does, "are they the same object?" does not.
    """
    text = normalised_text(question)
    if _SAME_WAY.search(text) or _EACH_ALIKE.search(text):
        return True
    if _OF_SOMETHING_ELSE.search(text):
        return False
    return bool(_MOTION.search(text) or _RELATION.search(text) or motions_named(text))


def asks_each_amount(question: str) -> str | None:
    """Return "magnitude" or "rate" where it is asked how far, or how fast, both go; else None."""
    text = normalised_text(question)
    if not _EACH_AMOUNT.search(text) or _RELATION.search(text):
        return None
    return "rate" if _EACH_RATE.search(text) else "magnitude"


def asks_of_one(question: str) -> tuple[int, str] | None:
    """Return which clip alone, 0 or 1, is asked about and what; None where it is not one alone.

    What is asked is told as of a single clip, "which way does it go?"; it is empty where there is
    no more than "and the first one?".
    """
    text = re.sub(r" of (?:the two|them|both)\b", "", normalised_text(question))
    one = named_alone(text)
    if one is None or _RELATION.search(text):
        return None
    before, after = text[: one.start()], text[one.end() :]
    is_place = _WITHIN.search(before) and _IT.search(before + after) and not one["own"]
    if is_place:  # "which way does it turn in the second clip?"
        before, after = _WITHIN.sub("", before), after.lstrip(" ,")
    if _OF_BOTH.search(_IT.sub("", before + after) if is_place else before + after):
        return None
    asked = f"{before}{'' if is_place else 'its' if one['own'] else 'it'}{after}"
    return place_named(one), "" if _NOTHING_ASKED.fullmatch(asked) else asked
