"""One touch said in a few numbers, for people who try things out; only the noise is random.

Everything a touch does not say (optics, lights, the idle gel) is the measured GelSight Mini.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.indenter import Indenter
from geotlm_lm.simulation.indenters import INDENTERS
from geotlm_lm.simulation.motions import dominant_motion, path_of
from geotlm_lm.simulation.presets import PresetName
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import Body, Gel, Markers, Optics, Path, Scene
from geotlm_lm.simulation.simulate import SimulatedClip, simulate
from geotlm_lm.simulation.surface import pressed_surface
from geotlm_lm.simulation.trace import Contact


@dataclass(frozen=True)
class Touch:
    """What is pressed how, and what it does in the four frames: turn, slide and press at once.

    Args:
        object_name: A built-in shape, or any name beside an `indenter`.
        depth_mm: Approach beyond first touch half-way; 0 or less is no contact.
        twist_deg: Turn, positive clockwise in the image.
        slide_x_mm: Travel to the right.
        slide_y_mm: Travel down the image.
        press_mm: Approach into the gel from the first frame to the last; negative lifts.
        pivot_x_mm: Where the axis of the turn lies to the right of the middle of the contact, in
            the last frame.
        pivot_y_mm: The same below it.
        thickness_mm: Of the gel.
        friction: Coulomb's coefficient; felt in the drift of the gel's surface.
        seed: Of the noise and of the idle gel.
        indenter: A shape of one's own.
        is_marked: Whether dots are printed on the gel.

    Raises:
        UsageError: If there is no such shape, or a number is outside its range.
    """

    object_name: str = "key"
    depth_mm: float = 0.6
    twist_deg: float = 0.0
    slide_x_mm: float = 0.0
    slide_y_mm: float = 0.0
    press_mm: float = 0.0
    pivot_x_mm: float = 0.0
    pivot_y_mm: float = 0.0
    thickness_mm: float = 4.0
    friction: float = 1.0
    seed: int = 0
    indenter: Indenter | None = None
    is_marked: bool = False

    def __post_init__(self) -> None:
        if self.indenter is None and self.object_name not in INDENTERS:
            raise UsageError(
                f"There is no shape '{self.object_name[:40]}', expected one of "
                f"{', '.join(sorted(INDENTERS))}."
            )
        for name in RANGES:
            require_in_range(name, getattr(self, name))
        low, high = (self.depth_mm + sign * abs(self.press_mm) / 2 for sign in (-1, 1))
        least, most = RANGES["depth_mm"]
        if low < least or high > most:
            raise UsageError(
                f"A press by {self.press_mm:g} mm about a depth of {self.depth_mm:g} mm goes from "
                f"{low:g} to {high:g} mm, expected {least:g} to {most:g}, what the gel takes; "
                f"press less, or about another depth."
            )

    @cached_property
    def contact(self) -> Contact | None:
        """Where it touches in the last frame, or where it let go in the first; None for nowhere."""
        path = self._path()
        poses = zip(path.depth_mm, path.x_mm, path.y_mm, path.rotation_rad, strict=True)
        first, *_, last = (Path(*((number,) for number in pose)) for pose in poses)
        for pose in (last, first):
            if pose.depth_mm[0] > 0:
                scene = self._scene(pose, Motion.STILL)
                touches = pressed_surface(scene, build_profile(scene.body)).touches[0]
                if touches.any():
                    return Contact.of(scene, touches)
        return None

    @property
    def motion(self) -> Motion:
        """What the touch mostly does, turn and slide compared by their paths at the contact."""
        if self.contact is None:
            return Motion.NONE
        return dominant_motion(self._path(), self.contact.radius_mm)

    def scene(self) -> Scene:
        """Return what is simulated: turn, slide and press go evenly about the view's middle."""
        path = self._path()
        if self.contact is not None:
            x, y = self.contact.middle_mm
            path = self._path((x - path.x_mm[-1], y - path.y_mm[-1]))
        return self._scene(path, self.motion)

    def _path(self, contact_mm: tuple[float, float] = (0.0, 0.0)) -> Path:
        return path_of(
            turn_deg=self.twist_deg,
            right_mm=self.slide_x_mm,
            down_mm=self.slide_y_mm,
            inward_mm=self.press_mm,
            depth_mm=self.depth_mm,
            pivot_mm=(self.pivot_x_mm, self.pivot_y_mm),
            contact_mm=contact_mm,
        )

    def _scene(self, path: Path, motion: Motion) -> Scene:
        gel = Gel(thickness_mm=self.thickness_mm, friction=self.friction)
        kind = self.indenter
        body = Body(self.object_name, variant=self.seed, texture_um=10.0, indenter=kind)
        optics = Optics(idle=self.seed, markers=Markers() if self.is_marked else None)
        return Scene(body, path, motion, gel, optics)


RANGES = {
    "depth_mm": (-1.0, 1.5),
    "twist_deg": (-60.0, 60.0),
    "slide_x_mm": (-5.0, 5.0),
    "slide_y_mm": (-5.0, 5.0),
    "press_mm": (-2.0, 2.0),
    "pivot_x_mm": (-6.0, 6.0),
    "pivot_y_mm": (-6.0, 6.0),
    "thickness_mm": (1.0, 6.0),
    "friction": (0.0, 3.0),
    "seed": (0, 2**31 - 1),
}
"""Least and most of each number: a little more than the model was trained on."""


def require_in_range(name: str, value: float, told_as: str | None = None) -> None:
    """Refuse a number of a touch that is outside its range.

    Args:
        name: Of the field.
        value: What was given.
        told_as: What the number is called where it was asked for; the field's name by default.

    Raises:
        UsageError: If it is outside, or not a number.
    """
    low, high = RANGES[name]
    # A NaN fails every comparison, so that this refuses it too.
    if not low <= value <= high:
        raise UsageError(f"{told_as or name} is {value:g}, expected {low:g} to {high:g}.")


def simulate_touch(
    touch: Touch, *, preset: PresetName = "fast", with_drift: bool = True
) -> SimulatedClip:
    """Return the clip of a touch, its label and its true fields.

    Args:
        touch: What is done.
        preset: How finely and tightly the contact is solved.
        with_drift: Whether the gel's drift is among them; nothing drifts that is not touched.

    Raises:
        UsageError: If there is no such preset.
    """
    scene = touch.scene()
    drifts = with_drift and max(scene.path.depth_mm) > 0
    return simulate([scene], seed=touch.seed, preset=preset, with_drift=drifts)[0]
