"""Find the motions of which each option of a choice is true, also where it names no single one."""

from __future__ import annotations

import re
from collections.abc import Mapping

from geotlm_lm.conversation.compound_claims import EVERY, claimed_set
from geotlm_lm.conversation.felt import State, claim_of
from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.option_labels import labelled, without_tail
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text
from geotlm_lm.core.labels import DIRECTED, Motion

_PHRASES = Phrases("option_meanings")
_REST = _PHRASES.pattern("REST")

_INITIALS = {"l": "left", "r": "right", "u": "up", "d": "down"}
_INITIAL = _PHRASES.text("INITIAL")
_ONLY_INITIALS = _PHRASES.pattern("ONLY_INITIALS")
_NEITHER = _PHRASES.pattern("NEITHER")

OptionSets = Mapping[str, tuple[str, frozenset[Motion]]]
"""By label the words of an option and the motions of which it is true."""


def option_sets(question: str) -> OptionSets | None:
    """Return the words of every lettered option and the motions of which it is true.

    None where no options are lettered, where each names a motion of its own, which every model
    reads, or where one is not understood.
    """
    found = {
        label: without_tail(option.lower())
        for label, option in labelled(question.strip().upper(), lambda one: _means(one) is not None)
    }
    sets = {label: _means(option) for label, option in found.items()}
    if len(found) < 2 or any(motions is None for motions in sets.values()):
        return None
    if all(len(motions) == 1 for motions in sets.values()):
        return None
    rest = EVERY.difference(*sets.values())
    return {label: (found[label], motions or rest) for label, motions in sets.items()}


def _means(option: str) -> frozenset[Motion] | None:
    """Return the motions of which an option is true; none for all the others, None if unknown."""
    words = normalised_text(option).strip(" .,;?!()")
    return frozenset() if _REST.fullmatch(words) else claimed_set(words)


def true_option(sets: OptionSets, state: State) -> str | None:
    """Return the label of the narrowest option that is true of a state; None if none is."""
    true = [label for label, (_, motions) in sets.items() if claim_of(motions)(state)]
    return min(true, key=lambda label: len(sets[label][1]), default=None)


def offers_neither(question: str) -> bool:
    """Tell whether directions are offered without letters, and "neither" with them."""
    text = normalised_text(question)
    named = motions_named(text)
    return bool(_NEITHER.search(text)) and len(named) > 1 and named <= {*DIRECTED}


def initials_spelt_out(question: str) -> str:
    """Return "L, R, U or D?" in words; any other question as it is."""
    text = normalised_text(question)
    if not _ONLY_INITIALS.fullmatch(text):
        return question
    named = re.findall(rf"\b{_INITIAL}\b", text)
    return f"{' or '.join(_INITIALS[one] for one in named)}?"
