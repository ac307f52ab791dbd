"""Recognise claims of a slide along an image axis, in either direction."""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_verbs import GO, SLIDE, TURN
from geotlm_lm.core.labels import Motion

_MOTION = r"(?:motion|movement|slide|slip|shift|direction)"
_IS_IT = r"(?:is|was) (?:it|this|that)"
_ALONG = r"(?:along|in|on)(?: the)?(?: (?:image|picture|camera|frame)(?:'s)?)? [+-]?"
_TURNING = re.compile(rf"\b{TURN}")

_AXES = (
    (
        frozenset({Motion.LEFT, Motion.RIGHT}),
        rf"\b(?:horizontally|sideways|sidewards?|(?:from )?side to side|{_ALONG}x"
        rf"|(?:horizontal|sideways) {_MOTION}"
        rf"|(?:{_MOTION}|{_IS_IT}) (?:\w+ )?(?:horizontal|sideways))\b",
    ),
    (
        frozenset({Motion.UP, Motion.DOWN}),
        rf"\b(?:vertically|up and down|{_ALONG}(?:x (?:and|or) )?y|vertical {_MOTION}"
        rf"|(?:{_MOTION}|{_IS_IT}) (?:\w+ )?vertical)\b",
    ),
    (frozenset({Motion.PRESS, Motion.RELEASE}), rf"\b{_ALONG}z\b"),
)

_AND = r"(?:,? and |, ?|/| & )"
_EXTENT = r"(?:components?|displacements?|shifts?|distances?|travels?|offsets?|parts?|amounts?)"
_LEVEL = r"(?:horizontal|vertical)(?:ly)?"
_JUDGES = (
    r"(?:(?:and|so|but|ok|now)[, ]+)*(?:(?:is|was|are|were|does|did|do|has) (?!you\b|it possible\b)"
    r"|any )|.*\b(?:which|what) (?:way|direction)\b|.*\bpoint"
)
"""Asks for a verdict, or for the way, and for no parts."""

COMPONENTS = (
    rf"^(?!\W*(?:{_JUDGES})).*?(?:"
    rf"\bd ?x{_AND}d ?y\b|\bdelta[ -]?x{_AND}(?:delta[ -]?)?y\b|\bx{_AND}(?:the )?y[ -]{_EXTENT}\b"
    rf"|\b{_LEVEL}{_AND}(?:the )?{_LEVEL} {_EXTENT}\b"
    r"|\b(?:translation|displacement|motion|slide|sliding|shift|slip) vector\b"
    r"|^\W*(?:the )?d ?[xy](?: (?:in )?(?:px|pixels|mm))?\W*$|\bheading in (?:degrees|radians)\b"
    r"|^\W*(?:what(?:'s| is) )?(?:the |its )?(?:heading angle|bearing|azimuth)\W*$"
    r"|\bangle (?:in degrees )?(?:from|to|with) the x[ -]?axis\b"
    rf"|\b(?:at|in) (?:what|which) angle (?:does|did|is|was) \S+(?: \w+)? (?:{SLIDE}|{GO}|go)"
    rf"|\bcomponents of (?:the|its) {_MOTION}"
    r"|\bhow (?:much|far|fast|many \w+)(?: (?:is|was|did|does) \S+(?: \w+)?)? "
    r"(?:(?:in|along)(?: the)? x|horizontally)\b.* (?:(?:in|along)(?: the)? y|vertically)\b)"
)
"""Asks how far it went in x and how far in y."""

_COMPONENTS = re.compile(COMPONENTS)


def asks_components(text: str) -> bool:
    """Tell whether `text`, in lower case, asks how far it went along both axes of the image."""
    return bool(_COMPONENTS.search(text))


def claimed_axis(text: str) -> frozenset[Motion]:
    """Return the two motions along the one axis that `text` names; none if it names none, or two.

    Args:
        text: In lower case.
    """
    if _TURNING.search(text):
        return frozenset()  # "turning about a vertical axis"
    named = axes_named(text)
    return named[0] if len(named) == 1 else frozenset()


def axes_named(text: str) -> list[frozenset[Motion]]:
    """Return the two motions along each axis that `text`, in lower case, names."""
    return [motions for motions, words in _AXES if re.search(words, text)]
