"""Recognise questions for an amount that lack "how far", "how much" or "how many".

"Total rotation?", "slip in mm", "number of degrees it turned" and "did it slide a lot or a little?"
ask for an amount. A model takes many of them for questions about the direction or the kind.
"""

from __future__ import annotations

import re

from geotlm_lm.conversation.kind_phrases import COUNTED
from geotlm_lm.conversation.motion_verbs import MOVES, SLIDES, TURNS, Verb, forms
from geotlm_lm.conversation.object_names import THING, with_generic_objects
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.question_affixes import JUST, TAIL, WHETHER
from geotlm_lm.conversation.text_normalisation import without_openers

_PHRASES = Phrases("amount_questions")
_ASK = _PHRASES.text("ASK")
_MEASURE = _PHRASES.text("MEASURE")
_THE = _PHRASES.text("THE")
_SUM = _PHRASES.group("SUM")
_OF_IT = _PHRASES.text("OF_IT")
_EXTENT = _PHRASES.text("EXTENT")
_IN_UNIT = _PHRASES.text("IN_UNIT")
_MUCH_OR_LITTLE = _PHRASES.text("MUCH_OR_LITTLE")


def _asking(verbs: tuple[Verb, ...], nouns: str) -> tuple[re.Pattern[str], ...]:
    """Return what a whole text is that asks how far a motion by one of `verbs` goes.

    Args:
        verbs: Verbs for one kind of motion.
        nouns: Nouns for it beside "turn" or "turning", as a pattern.
    """
    base, third, past, gerund = (forms(verbs, f) for f in ("base", "third", "past", "gerund"))
    noun = rf"(?:{nouns}|{base}|{gerund})"
    it_went = rf"(?:that )?{THING} {JUST}(?:(?:has |had )?{past}|{third})"
    did_it_go = (
        rf"(?:(?:did|does|do) {THING} {JUST}{base}|(?:has|have|had) {THING} {JUST}{past}"
        rf"|(?:is|was) {THING} {JUST}(?:{past}|{gerund}))"
    )
    said = (
        rf"{_ASK}{_THE}(?:{_SUM} )?{noun}{_EXTENT}{_OF_IT}{_IN_UNIT}",
        rf"{_ASK}{_THE}{_SUM} {noun}{_EXTENT}{_OF_IT}",
        rf"{_ASK}{_THE}{noun} (?:amount|angle|distance|extent|size|magnitude){_OF_IT}",
        rf"{_MEASURE} {_THE}(?:{_SUM} )?{noun}{_EXTENT}{_OF_IT}{_IN_UNIT}?",
        rf"(?:(?:over|through|by) )?(?:what|which) (?:angle|distance) {did_it_go}",
        rf"{_ASK}(?:the )?(?:number|count) of (?P<unit>{COUNTED}) {it_went}",
        rf"(?P<unit>{COUNTED}) {past}",
        rf"{_ASK}(?:the )?(?:angle|distance|amount|extent) {it_went}",
        rf"{did_it_go} (?:{_MUCH_OR_LITTLE})",
    )
    return tuple(re.compile(rf"{WHETHER}{words}{TAIL}") for words in said)


_ASKED = (
    (_asking(TURNS, _PHRASES.text("TURN_NOUNS")), "turn"),
    (_asking(SLIDES, _PHRASES.text("SLIDE_NOUNS")), "slide"),
    (_asking(MOVES, _PHRASES.text("MOTION_NOUNS")), "go"),
)
_RANGE = _PHRASES.pattern("RANGE")
_YAW = _PHRASES.pattern("YAW")
_COUNTS = _PHRASES.pattern("COUNTS")
_DEPTH = _PHRASES.pattern("DEPTH")


def asks_range(question: str) -> bool:
    """Tell whether a whole text asks for the uncertainty of an amount: "error bars?"."""
    return bool(_RANGE.fullmatch(without_openers(question)))


def asks_depth(question: str) -> bool:
    """Tell whether a whole text asks how deep it presses in, or how far it lifts off."""
    return bool(_DEPTH.fullmatch(without_openers(question)))


def canonical_amount_question(question: str) -> str | None:
    """Rewrite a whole question for an amount in trained wording; None for any other."""
    text = without_openers(question)
    if (counts := _COUNTS.fullmatch(text)) is not None:
        return f"How many {counts['unit']}?"
    if asks_range(text):
        return "How far did it go?"
    if _YAW.fullmatch(text):
        return "How far did it turn?"
    texts = (text, *with_generic_objects(text))
    for patterns, verb in _ASKED:
        tried = (words.fullmatch(said) for words in patterns for said in texts)
        if (found := next(filter(None, tried), None)) is not None:
            unit = found.groupdict().get("unit")
            return f"How {f'many {unit}' if unit else 'far'} did it {verb}?"
    return None
