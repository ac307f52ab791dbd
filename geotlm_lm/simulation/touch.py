"""One touch in a few numbers, for people who try things out; only the noise is random.

Everything else of a touch (optics, lights, the idle gel) is the measured GelSight Mini's.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.simulation.contact import PresetName
from geotlm_lm.simulation.indenters import require_shape
from geotlm_lm.simulation.motions import dominant_motion, path_of
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.randomise import random_scene
from geotlm_lm.simulation.scene import Body, Gel, Markers, Optics, Path, Scene
from geotlm_lm.simulation.shapes import Indenter
from geotlm_lm.simulation.simulate import SimulatedClip, simulate
from geotlm_lm.simulation.surface import pressed_surface
from geotlm_lm.simulation.truth import Contact, contact_of


@dataclass(frozen=True)
class Touch:
    """What is pressed how, and what it does in the four frames: turn, slide and press at once.

    Turn is positive clockwise in the image, x right, y down. An unknown shape, or a number outside
    its range, is a `UsageError`.
    """

    object_name: str = "key"  # a built-in shape's, or any beside an `indenter`
    depth_mm: float = 0.6  # beyond first touch, half-way; 0 or less is no contact
    twist_deg: float = 0.0
    slide_x_mm: float = 0.0
    slide_y_mm: float = 0.0
    press_mm: float = 0.0  # into the gel from the first frame to the last; negative lifts
    pivot_x_mm: float = 0.0  # the axis of the turn from the contact's middle in the last frame
    pivot_y_mm: float = 0.0
    thickness_mm: float = 4.0
    friction: float = 1.0  # felt in the drift of the gel's surface
    seed: int = 0  # of the noise and of the idle gel
    indenter: Indenter | None = None
    is_marked: bool = False

    def __post_init__(self) -> None:
        if self.indenter is None:
            require_shape(self.object_name)
        for name in RANGES:
            require_in_range(name, getattr(self, name))
        low, high = (self.depth_mm + sign * abs(self.press_mm) / 2 for sign in (-1, 1))
        least, most = RANGES["depth_mm"]
        if low < least or high > most:
            half = abs(self.press_mm) / 2
            room = 2 * min(self.depth_mm - least, most - self.depth_mm)
            raise UsageError(
                f"A press by {self.press_mm:g} mm about a depth of {self.depth_mm:g} mm goes from "
                f"{low:g} to {high:g} mm, expected {least:g} to {most:g}, what the gel takes; "
                f"press by at most {room:.3g} mm, or about a depth of {least + half:g} to "
                f"{most - half:g} mm."
            )

    @cached_property
    def contact(self) -> Contact | None:
        """Where it touches in the last frame, or where it let go in the first; None for nowhere."""
        first, *_, last = self._path().poses
        for pose in (last, first):
            if pose[0] > 0:
                scene = self._scene(Path(*((number,) for number in pose)), Motion.STILL)
                touches = pressed_surface(scene, build_profile(scene.body)).touches[0]
                if touches.any():
                    return contact_of(scene, touches)
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
        body = Body(self.object_name, self.seed, texture_um=10.0, indenter=self.indenter)
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


def require_in_range(name: str, value: float, called: str | None = None) -> None:
    """Refuse a number of a touch outside its range with a `UsageError` that names it."""
    low, high = RANGES[name]
    # A NaN fails every comparison, so that this refuses it too.
    if not low <= value <= high:
        raise UsageError(f"{called or name} is {value:g}, expected {low:g} to {high:g}.")


def simulate_touch(
    touch: Touch, *, preset: PresetName = "fast", with_drift: bool = True
) -> SimulatedClip:
    """Return the clip of a touch with its truth; nothing drifts that is not touched."""
    scene = touch.scene()
    drifts = with_drift and max(scene.path.depth_mm) > 0
    return simulate([scene], seed=touch.seed, preset=preset, with_drift=drifts)[0]


def simulate_motion(
    object_name: str,
    motion: Motion,
    *,
    seed: int,
    indenter: Indenter | None = None,
    is_marked: bool = False,
    preset: PresetName = "fast",
    with_drift: bool = False,
) -> SimulatedClip:
    """Return the clip of a motion as a random hand, gel, light and camera show it."""
    scene = random_scene(
        generator_for(seed, "single clip", object_name, motion.value),
        object_name=object_name,
        motion=motion,
        indenter=indenter,
        marker_share=float(is_marked),
    )
    return simulate([scene], seed=seed, preset=preset, with_drift=with_drift)[0]
