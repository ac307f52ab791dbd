"""One touch said in a few numbers, for people who try things out; only the noise is random.

Everything a touch does not say (optics, lights, the idle gel) is the measured GelSight Mini.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.indenters import INDENTERS
from geotlm_lm.simulation.motions import CONTACT_RADIUS_MM
from geotlm_lm.simulation.scene import Body, Gel, Optics, Path, Scene
from geotlm_lm.simulation.simulate import SimulatedClip, simulate


@dataclass(frozen=True)
class Touch:
    """What is pressed how, and what it does in the four frames.

    Args:
        object_name: A built-in shape.
        depth_mm: Approach beyond first touch; 0 or less is no contact.
        twist_deg: Turn, positive clockwise in the image.
        slide_x_mm: Travel to the right.
        slide_y_mm: Travel down the image.
        thickness_mm: Of the gel.
        friction: Coulomb's coefficient; felt in the drift of the gel's surface.
        seed: Of the noise and of the idle gel.

    Raises:
        UsageError: If there is no such shape, or a number is outside its range.
    """

    object_name: str = "key"
    depth_mm: float = 0.6
    twist_deg: float = 0.0
    slide_x_mm: float = 0.0
    slide_y_mm: float = 0.0
    thickness_mm: float = 4.0
    friction: float = 1.0
    seed: int = 0

    def __post_init__(self) -> None:
        if self.object_name not in INDENTERS:
            raise UsageError(
                f"There is no shape '{self.object_name[:40]}', expected one of "
                f"{', '.join(sorted(INDENTERS))}."
            )
        for one in fields(self)[1:]:
            low, high = RANGES[one.name]
            value = getattr(self, one.name)
            # A NaN fails every comparison, so that this refuses it too.
            if not low <= value <= high:
                raise UsageError(f"{one.name} is {value:g}, expected {low:g} to {high:g}.")

    def scene(self) -> Scene:
        """Return what is simulated: turn and slide go evenly about the middle of the view."""
        time = np.linspace(-0.5, 0.5, FRAME_COUNT)
        path = Path(
            depth_mm=(float(self.depth_mm),) * FRAME_COUNT,
            x_mm=tuple((self.slide_x_mm * time).tolist()),
            y_mm=tuple((self.slide_y_mm * time).tolist()),
            rotation_rad=tuple(np.radians(self.twist_deg * time).tolist()),
        )
        gel = Gel(thickness_mm=self.thickness_mm, friction=self.friction)
        body = Body(self.object_name, variant=self.seed, texture_um=10.0)
        return Scene(body, path, self.motion, gel, Optics(idle=self.seed))

    @property
    def motion(self) -> Motion:
        """What the touch mostly does, turn and slide compared by their paths at the contact."""
        if self.depth_mm <= 0:
            return Motion.NONE
        turn_mm = abs(np.radians(self.twist_deg)) * CONTACT_RADIUS_MM
        if max(turn_mm, abs(self.slide_x_mm), abs(self.slide_y_mm)) < STILL_MM:
            return Motion.STILL
        if turn_mm > np.hypot(self.slide_x_mm, self.slide_y_mm):
            return Motion.CLOCKWISE if self.twist_deg > 0 else Motion.COUNTERCLOCKWISE
        if abs(self.slide_x_mm) >= abs(self.slide_y_mm):
            return Motion.RIGHT if self.slide_x_mm > 0 else Motion.LEFT
        return Motion.DOWN if self.slide_y_mm > 0 else Motion.UP


RANGES = {
    "depth_mm": (-1.0, 1.5),
    "twist_deg": (-40.0, 40.0),
    "slide_x_mm": (-3.0, 3.0),
    "slide_y_mm": (-3.0, 3.0),
    "thickness_mm": (1.0, 6.0),
    "friction": (0.0, 3.0),
    "seed": (0, 2**31 - 1),
}
"""Least and most of each number: what the model was trained on, and a little more of the gel."""

STILL_MM = 0.02
"""Path below which a touch counts as still: less than a quarter of a pixel."""


def simulate_touch(touch: Touch) -> SimulatedClip:
    """Return the clip of a touch, its label and its true fields, the gel's drift among them."""
    return simulate([touch.scene()], seed=touch.seed, with_drift=touch.depth_mm > 0)[0]
