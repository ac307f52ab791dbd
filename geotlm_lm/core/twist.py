"""A motion with all its components at once: turn, travel and approach between two times.

Axes and signs are those of `core.labels`: x right, y down, clockwise as drawn and into the gel
positive. Lengths in the image are pixels of the 224-pixel square; travel is that of the middle of
the contact, about which the object turns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from geotlm_lm.core.labels import Motion, signed_amount


class Component(StrEnum):
    """What a motion is made of; a motion may have none, one or all of them at once."""

    TURN = "turn"
    SLIDE = "slide"
    PRESS = "press"


COMPONENTS = tuple(Component)

WAYS = {
    Component.TURN: (Motion.CLOCKWISE, Motion.COUNTERCLOCKWISE),
    Component.SLIDE: (Motion.LEFT, Motion.RIGHT, Motion.UP, Motion.DOWN),
    Component.PRESS: (Motion.PRESS, Motion.RELEASE),
}
"""The names a component's direction may have."""

COMPONENT_OF = {way: component for component, ways in WAYS.items() for way in ways}

AT_REST_PX, MOVING_PX = 0.02, 0.3
"""Path of the imprint up to which it is at rest, and from which on that it moves is asked of what
is measured: nearly all real imprints moved so far are seen to. What lies between is not graded."""

AT_REST_MM, MOVING_MM = 0.01, 0.06
"""The same of the approach of an object: a hand that only turns lets it vary by 0.06 mm."""

BARELY_PX, BARELY_MM = 1.0, 0.15
"""Path below which a turn or a slide, and a press, that is seen is said to move barely."""

ASLANT, DIAGONAL = 1 / 3, math.tan(math.radians(30))
"""Share of a slide's lesser travel in its greater, and of a turn's way back in its way there, from
which on it is said to go that way too; and of a slide from which on it goes both ways alike."""


@dataclass(frozen=True)
class Twist:
    """How an object moves between two times: it turns about the middle of the contact."""

    turn_deg: float = 0.0
    right_px: float = 0.0
    down_px: float = 0.0
    inward_mm: float = 0.0

    @property
    def slide_px(self) -> float:
        """Length of the travel."""
        return math.hypot(self.right_px, self.down_px)

    def along(self, way: Motion) -> float | None:
        """Return how far it goes a way, against it negative; None for stillness and absence."""
        return signed_amount(
            way,
            turn=self.turn_deg,
            right=self.right_px,
            down=self.down_px,
            inward=self.inward_mm,
        )

    def way(self, component: Component) -> Motion:
        """Return the name nearest to a component's direction; of a slide one of four."""
        return max(WAYS[component], key=self.along)

    def lesser_way(self) -> tuple[Motion | None, bool]:
        """Return where a slide goes besides its greater way, if it does, and whether as far."""
        way = self.way(Component.SLIDE)
        far = {each: max(self.along(each) or 0.0, 0.0) for each in WAYS[Component.SLIDE]}
        greatest = max(far.pop(way), 1e-9)
        other = max(far, key=far.__getitem__)
        share = far[other] / greatest
        return other if share >= ASLANT else None, share >= DIAGONAL

    def path(self, component: Component, radius_px: float) -> float:
        """Return how far a component moves the imprint: pixels, of a press millimetres.

        The path of a turn is that at the contact's radius.
        """
        return {
            Component.TURN: abs(math.radians(self.turn_deg)) * radius_px,
            Component.SLIDE: self.slide_px,
            Component.PRESS: abs(self.inward_mm),
        }[component]


def way_words(way: Motion, lesser: Motion | None, *, is_diagonal: bool) -> str:
    """Return where a motion goes: "left and a little up", "left and up"."""
    if lesser is None:
        return way.value
    return f"{way.value} and {'' if is_diagonal else 'a little '}{lesser.value}"


def moves(component: Component, path: float) -> bool | None:
    """Tell whether a component of a `Twist.path` moves; None where that is too little to grade."""
    is_press = component is Component.PRESS
    low, high = (AT_REST_MM, MOVING_MM) if is_press else (AT_REST_PX, MOVING_PX)
    if path >= high:
        return True
    return False if path <= low else None
