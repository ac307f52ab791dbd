"""Recognise names of the touched object: "it", "the bottle cap", "my hex nut"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.kind_words import HOLDER, PICTURE
from geotlm_lm.conversation.motion_verbs import GOES, PRESSES, SLIDES, TURNS

_NAMED = "_thing"
THING = rf"(?:it|this|that|anything|something|{_NAMED})"
"""What moves, in a text of which `with_generic_objects` has taken the names."""

_BETWEEN = """
it this that these those they them he she him her we you i there who whom which what whose how
where when why if whether because or and but not no never nothing nobody neither nor none only a
an the my your its our any some each every both all other else another one two three ten first
second third last next same is was are were be been being has had have do does did will would
could can may might must should almost again twice once often always soon already now just still
ever even like seem seems in on at to from by with without for since until than as about against
after before behind between during over under left right up down leftward leftwards rightward
rightwards upward upwards downward downwards sideways cw ccw clockwise counterclockwise
anticlockwise say says said think thinks thought claim claims claimed reports doubt doubts doubted
deny denies denied believe believes told tell tells make makes made let lets cause causes caused
fail fails failed refuse refuses refused cease ceases ceased done
"""
_MEASURES = """
number count total sum size half halves side sides top bottom middle centre center axis direction
way sense angle distance amount degree degrees pixel pixels speed rate velocity reason evidence
proof probability chance odds likelihood confidence certainty accuracy time moment force forces
torque pressure temperature light signal text question answer matter contact touch motion movement
imprint
"""
_OTHERS = """
clip clips frame frames world table background user operator manual label report log colleague
friend person people arm thumb palm hand jaw jaws finger fingers fingertips grip grasp hold
"""
_NO_NAMES = frozenset(
    (
        *_BETWEEN.split(),
        *_MEASURES.split(),
        *_OTHERS.split(),
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
