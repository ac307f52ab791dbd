"""Simulated recordings of several motions in a row, each with its exact beginning, end and amount.

Idle gel, touch, then turns and slides with rests between them or none, release, idle gel.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.numbers import generator_for, seed_for
from geotlm_lm.core.twist import Component, Twist

if TYPE_CHECKING:
    from geotlm_lm.simulation.scene import Path, Scene

IDLE, PRESSING = 12, 8
"""Frames before and after contact, and frames in which an object is pressed in or lifted."""

CLEAR_MM = 0.3
"""Height above the gel at which nothing touches."""

TURN_DEG, SLIDE_MM, MOVING, RESTING = (15.0, 60.0), (0.8, 2.2), (12, 28), (9, 16)
"""Least and most of a turn, a slide, and of the frames that a motion and a rest take."""

PLANS: tuple[tuple[str, ...], ...] = (
    ("rest", "turn", "rest"),
    ("turn", "rest", "slide", "rest"),
    ("turn", "back", "rest"),
    ("slide", "rest", "turn", "rest", "back"),
    ("rest", "slide", "rest"),
)
"""What happens between touch and release; "back" is a turn the other way."""


@dataclass(frozen=True)
class Planned:
    """A motion of a stream.

    Args:
        component: What it is of.
        begin: Frame after which it moves.
        end: Last frame in which it has moved.
        twist: The motion between these, of the middle of the contact.
        is_readable: Whether the picture shows it and it counts.
    """

    component: Component
    begin: int
    end: int
    twist: Twist
    is_readable: bool


@dataclass(frozen=True, eq=False)
class Stream:
    """A recording and what happens in it.

    Args:
        clip: All its frames; its idle gel is in its first ones.
        planned: Its turns and slides in order.
        touched: First and last frame in contact.
        object_name: What touches.
    """

    clip: Clip
    planned: tuple[Planned, ...]
    touched: tuple[int, int]
    object_name: str


def streams(count: int, seed: int) -> Iterator[Stream]:
    """Yield simulated streams of objects that no weight was trained on."""
    from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS
    from geotlm_lm.simulation.randomise import random_scene
    from geotlm_lm.simulation.simulate import simulate

    root = seed_for(seed, "evaluation", "streams")
    for index in range(count):
        rng = generator_for(root, "stream", index)
        name = EVERYDAY_OBJECTS[int(rng.integers(len(EVERYDAY_OBJECTS)))]
        scene = random_scene(rng, object_name=name, motion=Motion.CLOCKWISE)
        path, spans = _path(rng, scene, PLANS[index % len(PLANS)])
        made = simulate([replace(scene, path=path)], seed=root, first_index=index)[0]
        touching = np.flatnonzero(made.contact.any(axis=(1, 2)))
        planned = tuple(_planned(replace(scene, path=path), *span) for span in spans)
        clip = replace(made.clip, background=None)
        yield Stream(clip, planned, (int(touching[0]), int(touching[-1])), name)


def _path(
    rng: np.random.Generator, scene: Scene, plan: tuple[str, ...]
) -> tuple[Path, list[tuple[Component, int, int]]]:
    """Return the poses, and of each motion its component and its first and last pose."""
    from geotlm_lm.simulation.scene import Path

    middle = len(scene.path) // 2
    deep = scene.path.depth_mm[middle]
    # Depth, x, y, turn: where each stretch of the path ends, after so many frames.
    ends = [((-CLEAR_MM, scene.path.x_mm[middle], scene.path.y_mm[middle], 0.0), IDLE)]
    spans: list[tuple[Component, int, int]] = []

    def go(frames: int, depth: float = 0.0, x: float = 0.0, y: float = 0.0, turn: float = 0.0):
        here = ends[-1][0]
        ends.append((tuple(np.add(here, (depth, x, y, turn))), frames))

    go(PRESSING, depth=deep + CLEAR_MM)
    turned = float(rng.uniform(*TURN_DEG) * rng.choice([-1, 1]))
    # Slides lead towards the middle of the view, so that the contact stays in it.
    angle = np.arctan2(-scene.path.y_mm[middle], -scene.path.x_mm[middle]) + rng.normal(0, 0.5)
    for what in plan:
        since = sum(frames for _, frames in ends) - 1
        frames = int(rng.integers(*(RESTING if what == "rest" else MOVING)))
        if what == "slide":
            far = rng.uniform(*SLIDE_MM)
            go(frames, x=far * np.cos(angle), y=far * np.sin(angle))
            spans.append((Component.SLIDE, since, since + frames))
        elif what == "rest":
            go(frames)
        else:
            turned = turned if what == "turn" else -0.7 * turned
            go(frames, turn=np.radians(turned))
            spans.append((Component.TURN, since, since + frames))
    go(PRESSING, depth=-deep - CLEAR_MM)
    go(IDLE)
    poses = [np.tile(ends[0][0], (IDLE, 1))]
    for (begin, _), (end, frames) in zip(ends[:-1], ends[1:], strict=True):
        share = np.arange(1, frames + 1)[:, None] / frames
        poses.append(np.array(begin) + share * np.subtract(end, begin))
    return Path(*(tuple(row.tolist()) for row in np.concatenate(poses).T)), spans


def _planned(scene: Scene, component: Component, begin: int, end: int) -> Planned:
    """Return what is true of one stretch, by itself."""
    from geotlm_lm.simulation.scene import Path
    from geotlm_lm.simulation.simulate import simulate

    rows = (scene.path.depth_mm, scene.path.x_mm, scene.path.y_mm, scene.path.rotation_rad)
    path = Path(*((row[begin], row[end]) for row in rows))
    made = simulate([replace(scene, path=path)], seed=0, with_frames=False)[0]
    truth = made.components[component]
    return Planned(component, begin, end, made.twist, bool(truth.counts) and truth.is_visible)
