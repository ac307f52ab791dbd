"""The slots in which the model says what its prefix shows: one word each, all from one pass.

Behind the prefix stand the slots' own tokens and nothing else, so that what is felt depends on no
question; the words at a slot exclude each other, the slots do not.
"""

from __future__ import annotations

SLOTS: dict[str, tuple[str, ...]] = {
    "turn": ("clockwise", "counterclockwise", "none"),
    "slide": ("left", "right", "up", "down", "none"),
    "press": ("press", "release", "none"),
    "contact": ("yes", "no"),
}
"""Slot -> the words that may fill it."""

SLOT_TOKENS = tuple(f"<{slot}>" for slot in SLOTS)

SLOT_WORDS = tuple(dict.fromkeys(word for words in SLOTS.values() for word in words))
"""Every word once; each is one token of the vocabulary."""
