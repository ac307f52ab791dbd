"""Whether stated evidence agrees with a field: every claim in the words against its sign.

Reads the words a user reads, whoever said them; knows no model.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

from geotlm_lm.core.labels import Motion

if TYPE_CHECKING:
    from geotlm_lm.answering import Answer
    from geotlm_lm.conversation.reasons import Regions

AXES = {
    "right": ("shear_change_x", 1),
    "left": ("shear_change_x", -1),
    "down": ("shear_change_y", 1),
    "up": ("shear_change_y", -1),
}
"""Way -> component of the shear change, and the sign it then has."""

CLAIMS_OF: Mapping[Motion, tuple[tuple[str, str], ...]] = {
    Motion.CLOCKWISE: (("upper_minus_lower", "right"), ("left_minus_right", "up")),
    Motion.COUNTERCLOCKWISE: (("upper_minus_lower", "left"), ("left_minus_right", "down")),
    Motion.LEFT: (("global", "left"),),
    Motion.RIGHT: (("global", "right"),),
    Motion.UP: (("global", "up"),),
    Motion.DOWN: (("global", "down"),),
}
"""What the model's words about the halves claim, by the motion they carry: regions and ways."""

_WHOLE = re.compile(r"the whole contact goes (right|left|up|down)")
_HALF = re.compile(r"the (upper|left) half goes (right|left|up|down) against the")


def stated_claims(answer: Answer) -> list[tuple[str, str]]:
    """Return the region and the way of everything an answer about evidence says to move."""
    if answer.told_by == "model":
        return list(CLAIMS_OF.get(answer.direction, ()))
    text = answer.text.lower()
    found = [("global", way) for way in _WHOLE.findall(text)]
    others = {"upper": "upper_minus_lower", "left": "left_minus_right"}
    return found + [(others[half], way) for half, way in _HALF.findall(text)]


def claims_right(answer: Answer, field: Regions) -> list[bool]:
    """Return, claim by claim, whether the field's sign there is the stated one."""
    right = []
    for region, way in stated_claims(answer):
        component, sign = AXES[way]
        right.append(sign * field[region][component] > 0)
    return right
