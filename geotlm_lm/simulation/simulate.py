"""The room's seam: scenes to clips with their truth; the same seed, index and scene, same bytes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import GRID_SIDE
from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.core.twist import Component, Twist
from geotlm_lm.simulation.idle import idle_frame
from geotlm_lm.simulation.label import (
    ComponentTruth,
    components_of,
    label_for,
    patch_displacement,
    patch_means,
    twist_of,
)
from geotlm_lm.simulation.markers import shade
from geotlm_lm.simulation.normal_contact import SolverStatus
from geotlm_lm.simulation.optics import lit, turned_lights
from geotlm_lm.simulation.presets import Preset, PresetName, preset_named
from geotlm_lm.simulation.profile import Profile, build_profile
from geotlm_lm.simulation.recording import Recorder
from geotlm_lm.simulation.scene import Scene
from geotlm_lm.simulation.stopwatch import Stopwatch
from geotlm_lm.simulation.surface import Surface, pressed_surface
from geotlm_lm.simulation.trace import Trace, change_since_first, shading_change, trace_of

CAMERA_FPS = 25.0
"""Frames per second of a GelSight Mini's camera (gs_sdk)."""


@dataclass(frozen=True, eq=False)
class SimulatedClip:
    """A clip and the truth about it.

    Args:
        clip: Four (or the path's number of) frames of 224x224 and their idle frame; None where only
            labels and true fields were asked for.
        trace_until: Frame number -> what there is to see of the motion since the first frame; only
            what is asked for is worked out.
        object_name: Name of the body.
        scene: What was simulated.
        displacement_px: float32 (frames, 14, 14, 2), the object's travel since frame 0 at each
            patch centre in pixels of the image (x right, y down), 0 without contact.
        contact: float32 (frames, 14, 14), share of each patch in contact.
        depth_mm: float32 (frames, 14, 14), mean indentation of the surface.
        drift_px: float32 (frames, 14, 14, 2), mean tangential displacement of the gel's surface
            from rest in pixels (x right, y down); None where it was not asked for.
        mm_per_px: Pixel size (x, y).
        status: The contact solver's account.
        timing_ms: Milliseconds of each stage that ran, in order; a stage that is missing was not
            needed.
    """

    clip: Clip | None
    trace_until: Callable[[int], Trace]
    object_name: str
    scene: Scene
    displacement_px: NDArray[np.float32]
    contact: NDArray[np.float32]
    depth_mm: NDArray[np.float32]
    drift_px: NDArray[np.float32] | None
    mm_per_px: tuple[float, float]
    status: SolverStatus
    timing_ms: dict[str, float]

    @property
    def stages(self) -> tuple[str, ...]:
        """What ran, in order."""
        return tuple(self.timing_ms)

    @property
    def label(self) -> MotionLabel:
        """What the object does from the first frame to the last."""
        return self.label_until(len(self.scene.path) - 1)

    @property
    def twist(self) -> Twist:
        """The same with all its components."""
        return twist_of(self.label)

    @property
    def components(self) -> dict[Component, ComponentTruth]:
        """What is true of turn, slide and press each."""
        return components_of(self.label)

    def label_until(self, last: int) -> MotionLabel:
        """Return what the object does from the first frame to frame `last`."""
        fraction = self.contact[: last + 1].mean(axis=(1, 2))
        return label_for(self.scene, fraction, self.trace_until(last), last)


def simulate(
    scenes: Sequence[Scene],
    *,
    seed: int,
    first_index: int = 0,
    preset: PresetName = "fast",
    with_drift: bool = False,
    with_frames: bool = True,
) -> list[SimulatedClip]:
    """Return one clip per scene.

    Clip i depends only on (seed, first_index + i, its scene), the preset, and whether drift is
    wanted: drag lifts and sinks the surface a little, by up to 27 um in a slide of 0.5 mm.

    A clip's frames are solved as one batch of fixed size, never together with another clip's:
    float32 transforms round differently in differently sized batches.

    Args:
        scenes: What to simulate.
        seed: Root of the noise.
        first_index: Number of the first scene in the seed's series.
        preset: How finely and tightly the contact is solved.
        with_drift: Whether the gel's tangential displacement is wanted. Frictional contact is left
            out otherwise: the imprint of a rigid object moves with it whether it sticks or slips,
            and drag changes a markerless image by less than noise (at most 0.7 grey levels RMS,
            measured). A gel with markers is always drawn with friction: it carries the dots.
        with_frames: Whether pictures are wanted; the true fields do not depend on it. Without them
            a label's `is_readable` rests on `trace.shading_change`, an estimate of the picture's
            change.

    Raises:
        UsageError: If there is no such preset.
    """
    effort = preset_named(preset)
    return [
        _simulate_one(scene, seed, first_index + i, effort, with_drift, with_frames)
        for i, scene in enumerate(scenes)
    ]


def _simulate_one(
    scene: Scene, seed: int, index: int, preset: Preset, with_drift: bool, with_frames: bool
) -> SimulatedClip:
    watch, surface, profile = Stopwatch(), None, None
    moves_gel = with_drift or (with_frames and scene.optics.markers is not None)
    if max(scene.path.depth_mm) > 0:
        with watch("profile"):
            profile = build_profile(scene.body)
        surface = pressed_surface(scene, profile, preset, with_drift=moves_gel, watch=watch)
    clip = clean = None
    if with_frames:
        with watch("optics"):
            idle = idle_frame(scene.optics.idle, scene.optics.mounting)
            rng = generator_for(seed, "clip", index)
            frames, background, clean = _render(scene, surface, idle, rng)
        name = f"{scene.body.name}-{seed}-{index}"
        clip = Clip(frames, fps=CAMERA_FPS, background=background, name=name)
    with watch("truth"):
        truth = _truth(scene, profile, surface, clean, with_drift)
    return SimulatedClip(
        clip=clip,
        object_name=scene.body.name,
        scene=scene,
        mm_per_px=(scene.optics.mm_per_px_x, scene.optics.mm_per_px_y),
        status=surface.status if surface is not None else SolverStatus(0.0, 0, True, preset.name),
        timing_ms=watch.milliseconds,
        **truth,
    )


def _truth(
    scene: Scene,
    profile: Profile | None,
    surface: Surface | None,
    clean: list[NDArray[np.float32]] | None,
    with_drift: bool,
) -> dict[str, Any]:
    """Return the dense truth of every frame, and what each frame shows of the motion."""
    count = len(scene.path)
    contact = np.zeros((count, GRID_SIDE, GRID_SIDE), np.float32)
    depth, drift = np.zeros_like(contact), np.zeros((count, GRID_SIDE, GRID_SIDE, 2), np.float32)
    touches = np.zeros((count, 1, 1), bool) if surface is None else surface.touches
    if surface is not None:
        contact, depth = patch_means(surface.touches), patch_means(surface.indentation_mm)
        if with_drift:
            pixel = (scene.optics.mm_per_px_x, scene.optics.mm_per_px_y)
            for axis in range(2):
                drift[..., axis] = patch_means(surface.drift_mm[:, axis]) / pixel[axis]
    if clean is None and surface is not None:
        change = partial(shading_change, scene.optics, surface.indentation_mm, touches)
    else:
        change = partial(change_since_first, clean, touches)
    return {
        "trace_until": partial(trace_of, scene, profile, change, touches),
        "displacement_px": patch_displacement(scene, contact),
        "contact": contact,
        "depth_mm": depth,
        "drift_px": drift if with_drift else None,
    }


def _render(
    scene: Scene, surface: Surface | None, idle: NDArray[np.float32], rng: np.random.Generator
) -> tuple[NDArray[np.uint8], NDArray[np.uint8], list[NDArray[np.float32]]]:
    """Return frames (t, 224, 224, 3), the idle frame, and planar frames without noise."""
    optics, recorder = scene.optics, Recorder(scene.optics, rng)
    lights, markers = turned_lights(optics), optics.markers
    background = recorder.background(idle if markers is None else idle * shade(markers, optics))
    base = idle * (1 + np.asarray(optics.light_change, np.float32))[:, None, None]
    clean, frames = [], np.empty((len(scene.path), *background.shape), np.uint8)
    is_drawn_once = surface is not None and surface.is_repeated and markers is None
    # Each frame is recorded while what was just drawn is still in the processor's cache.
    for frame, seen in enumerate(frames):
        image = base
        if frame > 0 and is_drawn_once:
            image = clean[0]
        elif surface is not None and surface.indentation_mm[frame].any():
            image = lit(surface.indentation_mm[frame], base, optics, lights=lights)
        if markers is not None:
            drift = None if surface is None else surface.drift_mm[frame]
            image = image * shade(markers, optics, drift)
        clean.append(image)
        seen[:] = recorder.next(image)
    return frames, background, clean
