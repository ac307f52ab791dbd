"""Extract questions embedded in a sentence: "I can't tell whether it turns, can you?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_names import claimed_motion
from geotlm_lm.conversation.motion_verbs import base_of
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.wording import capitalised

_PHRASES = Phrases("indirect_questions")
_WHETHER = _PHRASES.pattern("WHETHER", re.IGNORECASE)
_TOLD_WHETHER = _PHRASES.pattern("TOLD_WHETHER", re.IGNORECASE)
_WHICH = _PHRASES.pattern("WHICH", re.IGNORECASE)
_OR_NOT = _PHRASES.pattern("OR_NOT", re.IGNORECASE)
_HAS_GONE = _PHRASES.pattern("HAS_GONE", re.IGNORECASE)
_THIRD = _PHRASES.pattern("THIRD", re.IGNORECASE)


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
