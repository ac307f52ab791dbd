"""The truth about each component of a labelled clip: what training asks for and scoring grades."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.twist import COMPONENTS, Component, Twist
from geotlm_lm.simulation.truth import components_of, twist_of


@dataclass(frozen=True)
class ClipTruth:
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


def component_truth(label: MotionLabel) -> ClipTruth:
    """Return what a label tells of each component.

    An untouched gel counts no component. What is shorter than counts is readable where the picture
    would tell it, were it as long as counting needs: that it does not count is to be seen.
    """
    is_touched = label.motion is not Motion.NONE and max(label.contact_fraction, default=1.0) > 0
    if not is_touched:
        nothing = dict.fromkeys(COMPONENTS, False)
        return ClipTruth(Twist(), nothing, nothing, is_touched=False)
    label = replace(label, travel_px=label.travel_px or (0.0, 0.0))
    parts = components_of(label)
    return ClipTruth(
        twist_of(label),
        {
            component: None if one.counts and not one.is_visible else one.counts
            for component, one in parts.items()
        },
        {component: one.is_visible for component, one in parts.items()},
        is_touched=True,
    )
