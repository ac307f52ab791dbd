"""Recognise requests for other possible motions: "second guess?", "what are the probabilities?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.text_normalisation import without_openers

_OTHERS = (
    r"(?:(?:what|which) (?:else|other (?:motion|way|option|answer)s?) (?:could|can|might|may|would)"
    r" (?:it|this|that) (?:be|have been|do)"
    r"|what else(?: is (?:possible|likely|probable))?"
    r"|(?:(?:what(?:'s| is)|tell me|give me) )?(?:(?:the|your) )?(?:second|next)"
    r"(?:[ -](?:best|likeliest|most (?:likely|probable)))? ?(?:guess|answer|choice|option|one)?"
    r"|(?:(?:what are|are there|tell me|give me|list) )?(?:(?:the|your|any|all(?: the)?) )*"
    r"(?:alternatives?|runners?[ -]up)"
    r"|(?:(?:what are|tell me|give me|show(?: me)?|list|print) )?(?:(?:the|your|all(?: the)?) )*"
    r"(?:probabilities|odds)(?: of (?:each|all|the) (?:\w+ )?(?:motions?|options?|answers?))?"
    r"|(?:list|rank|show(?: me)?|give me) (?:(?:the|your|all(?: the)?) )*"
    r"(?:options|answers|motions(?= (?:with|by) ))"
    r"(?: (?:with|by) (?:their )?(?:probabilit(?:y|ies)|odds|likelihoods?))?"
    r"|top (?:two|three|2|3)(?: (?:guesses|answers|options))?)"
)
_ASKED = re.compile(rf"{_OTHERS}(?:,? please)?[ ?.!]*")
_BARE = re.compile(r"(?:the )?(?:second|next)(?: (?:one|answer|choice|option))?\W*")


def asks_alternatives(question: str) -> bool:
    """Tell whether a whole text asks for other possible motions of one clip."""
    text = without_openers(question)
    return _ASKED.fullmatch(text) is not None and _BARE.fullmatch(text) is None
