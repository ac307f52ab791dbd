"""Claims of a slide along an axis of the image, whichever way it goes."""

from __future__ import annotations

import re

from geotlm_lm.core.labels import Motion

_AXES = (
    (
        frozenset({Motion.LEFT, Motion.RIGHT}),
        r"\b(?:horizontal(?:ly)?|sideways|sidewards?|(?:from )?side to side|along (?:the )?x)\b",
    ),
    (
        frozenset({Motion.UP, Motion.DOWN}),
        r"\b(?:vertical(?:ly)?|up and down|along (?:the )?y)\b",
    ),
)


def claimed_axis(text: str) -> frozenset[Motion]:
    """Return the two motions along the one axis that `text` names; none if it names none, or two.

    Args:
        text: In lower case.
    """
    named = [motions for motions, words in _AXES if re.search(words, text)]
    return named[0] if len(named) == 1 else frozenset()
