"""Patterns of motion words that mean no motion: "the left cap", "still held", "picked up"."""

from __future__ import annotations

from geotlm_lm.conversation.motion_verbs import GOES, SLIDES, TURNS, forms

STILL_UNCHANGED = (
    r"\bstill (?=(?!during\b)\w+ing\b|(?:held|gripped|grasped|clamped|attached|there)\b"
    rf"|{forms(TURNS + SLIDES + GOES, 'base', 'third')}\b|touch(?:es)?\b)"
)
"""The "still" of what has not changed."""

UP_IN_PHRASAL_VERB = r"\b(?:pick|set|end|show)\w* up\b"
"""The "up" of an outcome, which is no way to go."""

ONE_OF_TWO = (
    r"(?<!\bto )(?<!\bon )(?<!\btowards )\b(?:the|my|this|that|its) (?:left|right) "
    r"(?!(?:edge|border|side|end|direction|way|slide|slip|shift|motion|movement|turn|turning"
    r"|rotation|spin|twist|or|and|then|than|but|not|now|again|too|at|in|on|by|from|of|with|for|as"
    r"|to|over|after|before|when|while|during|until|is|was|does|did|do|please|thanks"
    r"|a|an|the|it|this|that|\w+ly)\b)[a-z]+"
)
"""A thing by its place, "the left cap"; "the left side" and "to the right" are ways to go."""
