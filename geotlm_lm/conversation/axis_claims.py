"""Recognise claims of a slide along an image axis, in either direction."""

from __future__ import annotations

import re

from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.core.labels import Motion

_PHRASES = Phrases("axis_claims")
_TURNING = _PHRASES.pattern("TURNING")

_AXES = (
    (
        frozenset({Motion.LEFT, Motion.RIGHT}),
        _PHRASES.text("HORIZONTAL"),
    ),
    (
        frozenset({Motion.UP, Motion.DOWN}),
        _PHRASES.text("VERTICAL"),
    ),
    (frozenset({Motion.PRESS, Motion.RELEASE}), _PHRASES.text("PERPENDICULAR")),
)


_COMPONENTS = _PHRASES.pattern("COMPONENTS")


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
