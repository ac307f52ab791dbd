"""The truth about each component of a labelled clip: what training asks for and scoring grades."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.twist import COMPONENTS, Component, Twist, counts

VISIBLE_GREY = 2.0
"""What a component alone changes the picture by, RMS over the contact, below which a clip does not
tell it: one frame's noise has a standard deviation of 1.2 to 2.0 grey levels, measured."""


@dataclass(frozen=True)
class ComponentTruth:
    """What is true of a clip, component by component.

    Args:
        twist: The motion about the middle of the contact.
        counts: Whether each component counts; None where it is ambiguous, or counts but cannot be
            seen to.
        is_readable: Whether the picture tells how far each component goes, and which way.
        is_touched: Whether anything touches the gel.
    """

    twist: Twist
    counts: Mapping[Component, bool | None]
    is_readable: Mapping[Component, bool]
    is_touched: bool


def component_truth(label: MotionLabel) -> ComponentTruth:
    """Return what a label tells of each component.

    An untouched gel counts no component. What is shorter than counts is readable where the picture
    would tell it, were it as long as counting needs: that it does not count is to be seen.
    """
    is_touched = label.motion is not Motion.NONE and max(label.contact_fraction, default=1.0) > 0
    if not is_touched:
        nothing = dict.fromkeys(COMPONENTS, False)
        return ComponentTruth(Twist(), nothing, nothing, is_touched=False)
    right, down = label.travel_px or (0.0, 0.0)
    twist = Twist(label.rotation_deg, right, down, label.depth_change_mm)
    counted, readable = {}, {}
    for component, visible in zip(COMPONENTS, label.visible_grey, strict=True):
        counted[component] = counts(component, twist.path(component, label.radius_px))
        readable[component] = visible >= VISIBLE_GREY
        if counted[component] and not readable[component]:
            counted[component] = None
    return ComponentTruth(twist, counted, readable, is_touched=True)
