"""Extract questions embedded in a sentence: "I can't tell whether it turns, can you?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_names import claimed_motion
from geotlm_lm.conversation.motion_verbs import GOES, VERBS, base_of, forms
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
_WHETHER = re.compile(rf"{_LEAD} (?:whether(?: or not)?|if) {_CLAUSE}{_ENDS}", re.IGNORECASE)
_TOLD_WHETHER = re.compile(
    rf"(?:{_LEAD}|{_TOLD_TO}) (?:whether(?: or not)?|if) {_CLAUSE}{_ENDS}", re.IGNORECASE
)
_WHICH = re.compile(
    rf"{_HELLO}{_WONDERS}{_IF_YOU_CAN} (?P<asked>(?:which|what) (?:way|direction) .+?){_ENDS}",
    re.IGNORECASE,
)
"""Of who wonders alone: "can you tell me which way it turns?" is known to models."""

_OR_NOT = re.compile(r"\bwhether or not\b", re.IGNORECASE)
"""Unlike "whether" alone, new to models after "can you tell" too."""

_HAS_GONE = re.compile(
    r"(?P<lead>(?:(?:and|so|ok|now|but)[, ]+)*)(?:has|have|had) (?P<who>it|this|that|(?:the|my)"
    rf" \w+) (?:just |already |now )?(?P<went>{forms(GOES, 'past')}|gone) (?P<way>.+)",
    re.IGNORECASE,
)
"""Models take it for a question whether anything moves, whatever way it names."""

_THIRD = re.compile(forms(VERBS, "third"), re.IGNORECASE)


def embedded_question(question: str) -> str:
    """Return the question inside a sentence about not knowing, or asking.

    Any other text as it is, and so is "tell me whether it turns", which models know.
    """
    text = " ".join(question.replace("\u2019", "'").split())
    if (which := _WHICH.fullmatch(text)) is not None:
        return f"{capitalised(which['asked'])}?"
    is_either = _OR_NOT.search(text)
    whether = (_TOLD_WHETHER if is_either else _WHETHER).fullmatch(text)
    return _in_simple_past(question) if whether is None else _asked(whether)


def embedded_claim(question: str) -> str:
    """Return the question inside "tell me whether it turns"; any other text as it is."""
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


def _in_simple_past(question: str) -> str:
    """Return "Did it move right?" of "Has it moved right?"; any other text as it is."""
    said = _HAS_GONE.fullmatch(question)
    if said is None or claimed_motion(question) is None:
        return question
    verb = base_of(said["went"].lower()) or "go"
    did = f"{said['lead']}did" if said["lead"] else "Did"
    return f"{did} {said['who']} {verb} {said['way']}"
