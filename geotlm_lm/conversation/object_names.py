"""Recognise names of the touched object: "it", "the bottle cap", "my hex nut"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.kind_words import HOLDER, PICTURE
from geotlm_lm.conversation.motion_verbs import GOES, PRESSES, SLIDES, TURNS
from geotlm_lm.conversation.phrases import Phrases

_PHRASES = Phrases("object_names")
_NAMED = _PHRASES.text("NAMED")
THING = _PHRASES.group("THING")

_NO_NAMES = frozenset(
    (
        *_PHRASES.words("BETWEEN"),
        *_PHRASES.words("MEASURES"),
        *_PHRASES.words("OTHERS"),
        *re.findall("[a-z]+", HOLDER + PICTURE),
        *(form for verb in TURNS + SLIDES + GOES + PRESSES for form in verb),
    )
)
"""Words that are in no name of a thing that is touched: measures and parts of it, and who holds it,
whose motion would turn the question round. Adverbs in -ly and numbers neither."""

_DETERMINERS = ("the", "my", "this", "that")
_WORD = re.compile(r"(\w+)(.*)")


def with_generic_objects(text: str) -> tuple[str, ...]:
    """Replace the names of things in `text`, lower case, by one word, in every reading.

    A name may have one to three words: "did the hex nut drop?" names a hex nut, or a hex nut drop.
    """
    return tuple(dict.fromkeys(_with_generic_objects(text, longest) for longest in (1, 2, 3)))


def _with_generic_objects(text: str, longest: int) -> str:
    words, said = text.split(" "), []
    while words:
        word = words.pop(0)
        length = _length_of_name(words[:longest]) if word in _DETERMINERS else 0
        if length:
            word = f"{_NAMED}{_WORD.match(words[length - 1])[2]}"
            words = words[length:]
        said.append(word)
    return " ".join(said)


def _length_of_name(words: list[str]) -> int:
    """Return how many of the words after a determiner name a thing; a mark or an 's ends it."""
    for at, word in enumerate(words):
        parts = _WORD.match(word)
        if parts is None or parts[1] in _NO_NAMES or parts[1].endswith("ly") or parts[1].isdigit():
            return at
        if parts[2]:
            return at + 1
    return len(words)
