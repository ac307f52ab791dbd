"""Inflected verbs of motion, by what they mean: turning, sliding, any motion, pressing."""

from __future__ import annotations

from typing import Literal

from geotlm_lm.conversation.phrases import Verb, forms_of, verbs

Form = Literal["base", "third", "past", "gerund"]

TURNS, SLIDES = tuple(verbs("TURNS")), tuple(verbs("SLIDES"))
GOES, MOVES = tuple(verbs("GOES")), tuple(verbs("MOVES"))
NEARS, LIFTS = tuple(verbs("NEARS")), tuple(verbs("LIFTS"))
PRESSES = tuple(verbs("PRESSES"))
_BASES = {form: verb[0] for verb in verbs("VERBS") for form in verb}


def forms(verbs: tuple[Verb, ...], *which: Form) -> str:
    """Return a pattern of the given forms of verbs, of all of them where none is given."""
    return forms_of(verbs, *which)


def base_of(word: str) -> str | None:
    """Return the base form of a word for motion, such as "turn" of "turned"; None of any other."""
    return _BASES.get(word)
