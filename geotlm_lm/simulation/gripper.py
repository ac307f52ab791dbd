"""A gripper that turns, pulls or loosens an object through a sensor, one frame at a time.

The sensor is pressed on the object's face. What the object does follows from the grip: it carries
tangential load elastically up to Coulomb's limit and slips beyond (an elastic, perfectly plastic
contact; Johnson, Contact Mechanics, 1985, 7.2 and 7.4). The limit follows from the pressure of the
solved contact, the stiffness is that of a disc of its area on a half-space. A turn is positive
clockwise in the image; lengths are mm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from geotlm_lm.core.clip import Frames
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.core.twist import Twist
from geotlm_lm.simulation.camera import Recorder, idle_frame
from geotlm_lm.simulation.contact import BOX_MM, FAST, normal_pressure
from geotlm_lm.simulation.optics import lit
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.randomise import random_scene
from geotlm_lm.simulation.scene import Path
from geotlm_lm.simulation.surface import pressed_surface

Task = Literal["tighten", "pull", "loosen"]

OBJECTS = ("bottle_cap", "hex_nut", "screw_head", "coin")
"""What is gripped: shapes that no model was trained on."""

IDLE_S, APPROACH_S, SETTLED_S = 0.8, 0.2, 0.2
"""Times for which nothing touches at first, the sensor comes near, and is held still."""

HELD_DEPTH_MM, OFF_MM = (0.7, 1.2), 1.0
"""How deep an object is pressed, and how far its middle lies from the wrist's axis at most."""

PITCH_MM = 2.0
"""Rise of the thread in a turn, as of a bottle's."""


@dataclass(frozen=True)
class Grip:
    """How a contact holds, per shear modulus of the gel."""

    stiffness: float  # load per rad of turn, mm^3, or per mm of slide, mm
    limit: float  # load at which it slips

    @property
    def stretch(self) -> float:
        """How far it gives before it slips, rad or mm."""
        return self.limit / self.stiffness


@dataclass
class Carried:
    """What a grip carries along: elastic up to its limit, slipping beyond."""

    grip: Grip
    stretched: float = 0.0  # of the sensor ahead of the object, rad or mm
    slipped: float = 0.0
    moved: float = 0.0  # of the object

    def pull(self, step: float, load: float) -> None:
        """Move the sensor by a step against a load, a share of the most that the grip holds."""
        self.stretched += step
        most = self.grip.stretch * min(load, 1.0)
        beyond = math.copysign(max(abs(self.stretched) - most, 0.0), self.stretched)
        self.stretched -= beyond
        if load >= 1:
            self.slipped += beyond
        else:
            self.moved += beyond

    @property
    def relative(self) -> float:
        """How far the object has gone relative to the sensor."""
        return -(self.stretched + self.slipped)


@dataclass(frozen=True)
class Setting:
    """What a gripper meets.

    Args:
        friction: Coulomb's, between object and gel.
        rate: Of the sensor's own motion, degrees or mm a second.
        load: What resists, as a share of what the grip holds.
        binds_s: From when to when, seconds of motion, the load is beyond the grip.
        play: Of the wrist, degrees.
        goal: How far is to be turned, degrees.
        thread_ends_deg: Turn at which a loosened cap comes off its thread.
    """

    friction: float
    rate: float
    load: float
    binds_s: tuple[tuple[float, float], ...]
    play: float
    goal: float
    thread_ends_deg: float

    @classmethod
    def drawn(cls, rng: np.random.Generator, task: Task) -> Setting:
        """Return a random one for a task."""
        begins = rng.uniform(0.3, 2.0)
        spans = [(begins, begins + rng.uniform(0.2, 0.8))] * int(rng.integers(0, 2))
        if task == "pull":  # half of them slip, from some time on
            spans = [(begins, math.inf)] * int(rng.integers(0, 2))
        rate = rng.uniform(1.0, 6.0) if task == "pull" else rng.uniform(20.0, 50.0)
        return cls(
            friction=float(rng.uniform(0.1, 0.5)),
            rate=float(rate),
            load=float(rng.uniform(0.1, 0.8)),
            binds_s=tuple(spans),
            play=float(rng.uniform(0.0, 1.5)),
            goal=float(rng.choice([45.0, 60.0, 90.0, 120.0])),
            thread_ends_deg=float(rng.uniform(50.0, 100.0)),
        )

    def load_at(self, moving_s: float) -> float:
        """Return the load at a time of motion."""
        return 2.0 if any(a <= moving_s < b for a, b in self.binds_s) else self.load


@dataclass(frozen=True, eq=False)
class Seen:
    """What a controller sees of one frame."""

    frame: Frames | None  # None where nobody looks
    time_s: float
    own_motion: Twist  # as commanded since the frame before


class Gripper:
    """A wrist with a sensor on an object, commanded frame by frame.

    Args:
        task: "tighten" and "loosen" turn a cap on its thread, "pull" drags a load to the right.
        seed: Draws object, gel, light, noise, load and play.
        fps: Frames per second.
        is_seen: Whether pictures are taken; without them only the mechanics run.
    """

    def __init__(self, task: Task, seed: int, fps: float = 25.0, *, is_seen: bool = True) -> None:
        self._drawn = (task, seed, fps)
        rng = generator_for(seed, "gripper", task)
        self.task, self.fps, self.setting = task, fps, Setting.drawn(rng, task)
        name = OBJECTS[int(rng.integers(len(OBJECTS)))]
        scene = random_scene(rng, object_name=name, motion=Motion.STILL)
        scene = replace(scene, gel=replace(scene.gel, friction=self.setting.friction))
        self.mm_per_px = scene.optics.mm_per_px
        # Held about its middle, as a gripper takes it.
        place = (float(rng.uniform(*HELD_DEPTH_MM)), *rng.uniform(-OFF_MM, OFF_MM, 2).tolist())
        pose = (*place, scene.path.rotation_rad[0])
        self._scene = replace(scene, path=Path(*((number,) for number in pose)))
        self._profile, self._is_seen = build_profile(scene.body), is_seen
        self._depth, *self._at = pose
        self._recorder, optics = Recorder(scene.optics, rng), scene.optics
        idle = idle_frame(optics.idle, optics.mounting, optics.lamps)
        self._base = idle * (1 + np.asarray(optics.light_change, np.float32))[:, None, None]
        self.carried = Carried(self.grips(self._depth)[task == "pull"])
        self._count, self._moving_s = -1, 0.0
        self._wrist = self._tool = 0.0  # rad, or mm of a pull
        self.lost_s: float | None = None  # when contact was lost; None where it was not

    def again(self) -> Gripper:
        """Return the same gripper before it moved, without pictures."""
        return Gripper(*self._drawn, is_seen=False)

    @property
    def time_s(self) -> float:
        """When the last frame was taken."""
        return self._count / self.fps

    @property
    def is_ready(self) -> bool:
        """Whether the object is held, so that the wrist may move."""
        return self.time_s >= IDLE_S + APPROACH_S + SETTLED_S

    @property
    def turned_deg(self) -> float:
        """How far the object has turned in the world, clockwise."""
        return math.degrees(self.carried.moved)

    @property
    def slid_mm(self) -> float:
        """How far a pulled object has gone relative to the sensor."""
        return abs(self.carried.relative)

    @property
    def commanded_deg(self) -> float:
        """How far the wrist was commanded to turn, clockwise."""
        return math.degrees(self._wrist)

    def grips(self, depth_mm: float) -> tuple[Grip, Grip]:
        """Return how the contact at a depth holds against a turn, and against a slide."""
        pose = replace(self._scene.path, depth_mm=(depth_mm,))
        pressure = normal_pressure(replace(self._scene, path=pose), self._profile, FAST)
        cell = BOX_MM / len(pressure)
        axis = (np.arange(len(pressure)) - (len(pressure) - 1) / 2) * cell
        x, y = np.meshgrid(axis, axis)
        force = pressure.sum() * cell**2
        middle = (pressure * x).sum() / pressure.sum(), (pressure * y).sum() / pressure.sum()
        arm = np.hypot(x - middle[0], y - middle[1])
        radius = math.sqrt(float((pressure > 0).sum()) * cell**2 / math.pi)
        friction, nu = self._scene.gel.friction, self._scene.gel.poisson_ratio
        # Of a disc on a half-space of unit shear modulus (Johnson 1985, 3.7 and 3.9).
        turn = Grip(16 / 3 * radius**3, friction * float((pressure * arm).sum()) * cell**2)
        return turn, Grip(8 * radius / (2 - nu), friction * float(force))

    def step(self, rate: float) -> Seen:
        """Move on by a frame and return what is seen then.

        Args:
            rate: Degrees clockwise, or mm to the right, a second; nothing moves before `is_ready`.
        """
        step = rate / self.fps if self.is_ready else 0.0  # from a frame on at which it is held
        self._count += 1
        if self.task != "pull":
            step = math.radians(step)
        self._wrist += step
        before, self._tool = self._tool, self._played()
        self.carried.pull(self._tool - before, self.setting.load_at(self._moving_s))
        self._moving_s += (step != 0) / self.fps
        depth = self._depth_now()
        if depth <= 0 and self.is_ready and self.lost_s is None:
            self.lost_s = self.time_s
        frame = self._picture(depth) if self._is_seen else None
        return Seen(frame, self.time_s, self._own(step))

    def _played(self) -> float:
        """Return where the sensor is: the wrist turns by its play before it takes it along."""
        half = math.radians(self.setting.play) / 2 if self.task != "pull" else 0.0
        return min(max(self._tool, self._wrist - half), self._wrist + half)

    def _depth_now(self) -> float:
        since = self.time_s - IDLE_S
        if since < APPROACH_S:
            return -1.0 if since < 0 else self._depth * since / APPROACH_S
        if self.task != "loosen":
            return self._depth
        # The sensor rises with the wrist, the cap with its thread until it comes off.
        ahead = abs(self._wrist) - abs(self.carried.moved)
        depth = self._depth - PITCH_MM * max(ahead, 0.0) / (2 * math.pi)
        return -1.0 if -self.turned_deg >= self.setting.thread_ends_deg else depth

    def _picture(self, depth: float) -> Frames:
        image, (x, y, turn), relative = self._base, self._at, self.carried.relative
        if self.task == "pull":
            x += relative
        else:  # about the view's middle, where the wrist's axis is: the contact's middle goes along
            cos, sin = math.cos(relative), math.sin(relative)
            x, y, turn = cos * x - sin * y, sin * x + cos * y, turn + relative
        if depth > 0:
            pose = replace(self._scene, path=Path((depth,), (x,), (y,), (turn,)))
            surface = pressed_surface(pose, self._profile)
            image = lit(surface.indentation_mm[0], image, pose.optics)
        return self._recorder.next(image)

    def _own(self, step: float) -> Twist:
        if self.task == "pull":
            return Twist(right_px=step / self.mm_per_px[0])
        return Twist(turn_deg=math.degrees(step))
