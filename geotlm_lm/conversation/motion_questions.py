"""Recognise questions whether it turns, slides, moves, presses or lifts, in any tense.

"Has it turned?", "it slipped, didn't it?", "did it start spinning?", "any twisting?" ask for one
kind of motion. A model that was taught "is it turning?" takes many of them for questions about
contact, about motion of any kind, or about what touch cannot tell.
"""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_verbs import (
    LIFTS,
    MOVES,
    NEARS,
    SLIDES,
    TURNS,
    Verb,
    forms,
)
from geotlm_lm.conversation.object_names import THING, with_generic_objects
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.question_affixes import JUST, TAIL, WHETHER
from geotlm_lm.conversation.text_normalisation import without_openers

_PHRASES = Phrases("motion_questions")
_FAR = _PHRASES.text("FAR")
_SLIPS = tuple(verb for verb in SLIDES if verb[0] == "slip")
_SLIDES = tuple(verb for verb in SLIDES if verb not in _SLIPS)
_NOT = _PHRASES.text("NOT")


def _asking(verbs: tuple[Verb, ...], how_far: str = "") -> re.Pattern[str]:
    """Return what a whole text is that asks whether a motion by one of `verbs` is seen.

    Args:
        verbs: Verbs for one kind of motion.
        how_far: What must follow, such as "far".
    """
    # A model knows "isn't it turning?"; of "isn't it going?" it makes a motion of its own.
    no = _NOT if verbs is MOVES else ""
    base, third, past, gerund = (forms(verbs, f) for f in ("base", "third", "past", "gerund"))
    began = rf"(?:start|begin) (?:to {base}|{gerund})"
    begun = rf"(?:started|begun|began) (?:to {base}|{gerund})"
    said = (
        rf"(?:is|was){no} {THING} {JUST}(?:being {past}|{gerund})",
        rf"was{no} {THING} {JUST}{past}",
        rf"(?:did|does|do){no} {THING} {JUST}(?:(?:seem|appear) to )?(?:{base}|{began})",
        rf"(?:has|have|had){_NOT} {THING} {JUST}(?:(?:been )?{past}|been {gerund}|{begun})",
        rf"(?:could|can|might|may|would) {THING} {JUST}(?:(?:be|have been) {gerund}|have {past})",
        rf"(?:could|might|may) {THING} {JUST}{base}",
        rf"(?:(?:is|was) there )?(?:any|some) {gerund}",
        rf"{gerund}|{past}",
        rf"(?:can|could|do|did) you (?:feel|see|sense|detect|notice) "
        rf"(?:any|some|{THING}) {gerund}",
        rf"{THING}(?:'s| is| was| has been| had been) {JUST}{gerund}",
        rf"{THING}(?:'s| has| had)? {JUST}(?:been )?(?:{past}|{begun})",
        rf"{THING} {JUST}{third}|{THING} (?:is|was) {JUST}{past}",
        rf"{THING} (?:may|might|must|could|should|would) {JUST}"
        rf"(?:have (?:been )?{past}|(?:be|have been) {gerund})",
    )
    return re.compile(rf"{WHETHER}(?:{'|'.join(said)}){how_far}{TAIL}")


_WHICH_KIND = _PHRASES.pattern("WHICH_KIND")
_ASKED = (
    (_WHICH_KIND, "Is it sliding or turning?"),
    (_asking(TURNS), "Is it turning?"),
    (_asking(_SLIPS), "Is it slipping?"),
    (_asking(_SLIDES), "Is it sliding?"),
    (_asking(MOVES), "Is it moving at all?"),
    (_asking(NEARS), "Is it pressing in?"),
    (_asking(LIFTS), "Is it lifting off?"),
    (_asking(TURNS, _FAR), "How far did it turn?"),
    (_asking(SLIDES, _FAR), "How far did it slide?"),
    (_asking(MOVES, _FAR), "How far did it go?"),
)


def canonical_motion_question(question: str) -> str | None:
    """Rewrite a whole question for a kind of motion in trained wording; None for others."""
    texts = with_generic_objects(without_openers(question))
    return next((asked for words, asked in _ASKED if any(map(words.fullmatch, texts))), None)
