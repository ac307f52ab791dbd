"""Questions that stand inside another sentence: "I can't tell whether it turns, can you?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_verbs import VERBS, base_of, forms
from geotlm_lm.conversation.wording import capitalised

_HELLO = r"(?:(?:sorry|hm+|well|hi|hello|hey|please|so|and|ok|now)[,:.]? +)*"
_TELL = (
    r"(?:tell|say|see|know|make out|feel|decide|judge|check|confirm|verify|determine|find out"
    r"|figure out|detect|notice)"
)
_JUST = r"(?:(?:please|kindly|also|maybe|possibly|perhaps|really|just|still|quite|happen to) )*"
_ME = r"(?: (?:me|us|for me|for us))?(?: please)?"
_CAN = r"(?:can|could|would|will|might|may|do|did)"
_NOT = r"(?:can't|cannot|can not|couldn't|could not|don't|do not)"
_WONDERS = (
    rf"(?:i|we)(?:'d|'m|'re)? ?{_JUST}(?:{_NOT} {_JUST}{_TELL}"
    r"|(?:am |are )?(?:not sure|unsure|wondering|curious)|was wondering|wonder"
    rf"|(?:would |should )?(?:like|love|need)(?: (?:you )?to {_TELL}{_ME})"
    r"|have no (?:idea|clue))"
)
_ASKS_YOU = (
    rf"{_CAN} you {_JUST}(?:be able to )?(?:(?!tell (?:whether|if)\b){_TELL}{_ME}|let me know)"
    r"|would you mind (?:telling|letting) (?:me|us)(?: know)?|let (?:me|us) know"
    rf"|(?:do you have |have you )?(?:any|an) (?:idea|clue)|(?:can|could|may) (?:i|we) {_TELL}"
    rf"|(?:is it|would it be) (?:possible|known)(?: (?:for you )?to {_TELL}{_ME})?"
    r"|(?:my|the) question is"
)
_WANTS = rf"(?:i|we) want(?: (?:you )?to {_TELL}{_ME})"
_IF_YOU_CAN = rf"(?: (?:whether|if) you {_CAN} {_JUST}(?:be able to )?{_TELL}{_ME})?"
_LEAD = rf"{_HELLO}(?:{_WONDERS}|{_WANTS}|{_ASKS_YOU}){_IF_YOU_CAN}"
_TOLD_TO = rf"{_HELLO}(?:can you tell|check|verify|confirm|tell me|say|see)"
_CAN_YOU = (
    rf"(?:[,;.!?:]| -+)? *(?:but )?{_CAN} you(?: (?:tell|see|say|know|feel|help))?(?: me)?"
    r"(?: please)?[ ?.!]*"
)
_ENDS = rf"(?:{_CAN_YOU}|[ ?.!]*)"

_SUBJECT = r"(?P<who>there|it|this|that|something|anything|(?:the|my|this|that)(?: \w+){1,2}?)"
_CLAUSE = (
    rf"{_SUBJECT}(?:(?P<does>'s| is| was| has| does| did)\b(?P<rest> .+?)"
    rf"| (?P<verb>{forms(VERBS, 'third', 'past')})\b(?P<way>.*?))"
)
_WHETHER = re.compile(rf"{_LEAD} (?:whether|if) {_CLAUSE}{_ENDS}", re.IGNORECASE)
_TOLD_WHETHER = re.compile(
    rf"(?:{_LEAD}|{_TOLD_TO}) (?:whether|if) {_CLAUSE}{_ENDS}", re.IGNORECASE
)
_WHICH = re.compile(
    rf"{_HELLO}{_WONDERS}{_IF_YOU_CAN} (?P<asked>(?:which|what) (?:way|direction) .+?){_ENDS}",
    re.IGNORECASE,
)
"""Of who wonders alone: "can you tell me which way it turns?" is known to models."""

_THIRD = re.compile(forms(VERBS, "third"), re.IGNORECASE)


def asked_within(question: str) -> str:
    """Return the question that a sentence about not knowing, or asking, holds.

    Any other text as it is, and so is "tell me whether it turns", which models know.
    """
    text = " ".join(question.replace("\u2019", "'").split())
    if (which := _WHICH.fullmatch(text)) is not None:
        return f"{capitalised(which['asked'])}?"
    whether = _WHETHER.fullmatch(text)
    return question if whether is None else _asked(whether)


def claim_within(question: str) -> str:
    """Return the question of "tell me whether it turns" as well; any other text as it is."""
    whether = _TOLD_WHETHER.fullmatch(" ".join(question.replace("\u2019", "'").split()))
    return question if whether is None else _asked(whether)


def _asked(whether: re.Match[str]) -> str:
    """Return a clause after "whether" as a question of its own."""
    who, verb = whether["who"], whether["verb"]
    if verb is None:
        does = whether["does"].strip().lower().replace("'s", "is")
        return f"{capitalised(does)} {who}{whether['rest']}?"
    does = "Does" if _THIRD.fullmatch(verb) else "Did"
    return f"{does} {who} {base_of(verb.lower())}{whether['way']}?"
