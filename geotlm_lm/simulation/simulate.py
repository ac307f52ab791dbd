"""The room's seam: scenes to clips with their truth; the same seed, index and scene, same bytes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import GRID_SIDE
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.core.twist import Component, Twist
from geotlm_lm.simulation.camera import Recorder, idle_frame
from geotlm_lm.simulation.contact import Preset, PresetName, preset_named
from geotlm_lm.simulation.optics import lit, print_shade, turned_lights
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.randomise import random_scenes
from geotlm_lm.simulation.scene import Optics, Scene
from geotlm_lm.simulation.solvers import SolverStatus
from geotlm_lm.simulation.surface import Surface, pressed_surface, timed
from geotlm_lm.simulation.truth import (
    ComponentTruth,
    Trace,
    components_of,
    label_for,
    patch_displacement,
    patch_means,
    trace_of,
    twist_of,
)

CAMERA_FPS = 25.0
"""Frames per second of a GelSight Mini's camera (gs_sdk)."""

SERIES_VERSION = 9
"""Raised when the same seed gives other clips than before."""


@dataclass(frozen=True, eq=False)
class SimulatedClip:
    """A clip and the truth about it; fields are (frames, 14, 14), vectors (frames, 14, 14, 2)."""

    clip: Clip | None  # None where only labels and true fields were asked for
    # Frame number -> what there is to see of the motion since the first, worked out when asked for.
    trace_until: Callable[[int], Trace]
    scene: Scene
    # The object's travel since frame 0 at each patch's centre, pixels of the image; 0 out of touch.
    displacement_px: NDArray[np.float32]
    contact: NDArray[np.float32]  # share of each patch
    depth_mm: NDArray[np.float32]  # mean indentation
    # Mean tangential displacement of the gel's surface from rest; None where not asked for.
    drift_px: NDArray[np.float32] | None
    status: SolverStatus
    timing_ms: dict[str, float]  # of each stage that ran, in order

    @property
    def object_name(self) -> str:
        """Name of the body."""
        return self.scene.body.name

    @property
    def gel_name(self) -> str:
        """Name of the kind of gel, in `gels.GELS`."""
        return self.scene.gel_name

    @property
    def mm_per_px(self) -> tuple[float, float]:
        """Pixel size (x, y)."""
        return self.scene.optics.mm_per_px

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
    """Return one clip per scene; an unknown preset is a `UsageError`.

    Clip i depends only on (seed, first_index + i, its scene), the preset, and whether drift is
    wanted: drag lifts and sinks the surface a little, by up to 27 um in a slide of 0.5 mm.

    A clip's frames are solved as one batch of fixed size, never together with another clip's:
    float32 transforms round differently in differently sized batches.

    Frictional contact is left out where no drift is wanted: the imprint of a rigid object moves
    with it whether it sticks or slips, and drag changes a markerless image by less than noise (at
    most 0.7 grey levels RMS, measured). A gel with markers is always drawn with friction: it
    carries the dots. True fields do not depend on whether frames are wanted; without these a
    label's `is_readable` rests on `truth.shading_change`, an estimate of the picture's change.
    """
    effort = preset_named(preset)
    return [
        _simulated(scene, seed, index, effort, with_drift, with_frames)
        for index, scene in enumerate(scenes, first_index)
    ]


def simulate_series(
    seed: int,
    count: int,
    *,
    objects: Sequence[str],
    first_index: int = 0,
    motions: Sequence[Motion] | None = None,
    preset: PresetName = "fast",
    with_drift: bool = False,
    with_frames: bool = True,
    gels: Mapping[str, float] | None = None,
    **shares: float,
) -> Iterator[SimulatedClip]:
    """Yield clips `first_index` .. of the endless series of `seed`, as `random_scenes` draws them.

    Each scene is drawn right before it is simulated: the profile of its body, a third of the cost,
    is then still at hand and not built a second time.
    """
    options = {"preset": preset, "with_drift": with_drift, "with_frames": with_frames}
    for index in range(first_index, first_index + count):
        place = {"seed": seed, "first_index": index}
        scenes = random_scenes(
            count=1, objects=objects, motions=motions, gels=gels, **place, **shares
        )
        yield from simulate(scenes, **place, **options)


def _simulated(
    scene: Scene, seed: int, index: int, preset: Preset, with_drift: bool, with_frames: bool
) -> SimulatedClip:
    timing_ms: dict[str, float] = {}
    surface = profile = clip = clean = None
    if max(scene.path.depth_mm) > 0:
        with timed(timing_ms, "profile"):
            profile = build_profile(scene.body)
        moves_gel = with_drift or (with_frames and _carries(scene.optics))
        options = {"with_drift": moves_gel, "timing_ms": timing_ms}
        surface = pressed_surface(scene, profile, preset, **options)
    if with_frames:
        with timed(timing_ms, "optics"):
            rng = generator_for(seed, "clip", index)
            frames, background, clean = _render(scene, surface, rng)
        name = f"{scene.body.name}-{seed}-{index}"
        clip = Clip(frames, fps=CAMERA_FPS, background=background, name=name)
    with timed(timing_ms, "truth"):
        contact, depth, drift = _patch_fields(scene, surface, with_drift)
        displacement = patch_displacement(scene, contact)
    return SimulatedClip(
        clip=clip,
        trace_until=partial(trace_of, scene, profile, surface, clean),
        scene=scene,
        displacement_px=displacement,
        contact=contact,
        depth_mm=depth,
        drift_px=drift,
        status=surface.status if surface is not None else SolverStatus(0.0, True, preset.name),
        timing_ms=timing_ms,
    )


def _carries(optics: Optics) -> bool:
    return optics.markers is not None and optics.markers.is_carried


def _patch_fields(
    scene: Scene, surface: Surface | None, with_drift: bool
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32] | None]:
    """Return contact, depth and drift of every patch, as `SimulatedClip` keeps them."""
    shape = (len(scene.path), GRID_SIDE, GRID_SIDE)
    contact, depth = np.zeros((2, *shape), np.float32)
    drift = np.zeros((*shape, 2), np.float32) if with_drift else None
    if surface is not None:
        contact, depth = patch_means(surface.touches), patch_means(surface.indentation_mm)
        for axis, size in enumerate(scene.optics.mm_per_px if with_drift else ()):
            drift[..., axis] = patch_means(surface.drift_mm[:, axis]) / size
    return contact, depth, drift


def _render(
    scene: Scene, surface: Surface | None, rng: np.random.Generator
) -> tuple[NDArray[np.uint8], NDArray[np.uint8], list[NDArray[np.float32]]]:
    """Return frames (t, 224, 224, 3), the idle frame, and planar frames without noise."""
    optics, recorder = scene.optics, Recorder(scene.optics, rng)
    lights, markers = turned_lights(optics), optics.markers
    idle = idle_frame(optics.idle, optics.mounting, optics.lamps)
    at_rest = None if markers is None else print_shade(markers, optics)
    marked = idle if at_rest is None else idle * at_rest
    background = recorder.background(marked)
    base = idle * (1 + np.asarray(optics.light_change, np.float32))[:, None, None]
    clean, frames = [], np.empty((len(scene.path), *background.shape), np.uint8)
    is_repeated = surface is not None and surface.indentation_mm.strides[0] == 0
    is_drawn_once = is_repeated and not _carries(optics)
    # Each frame is recorded while what was just drawn is still in the processor's cache.
    for frame, recorded in enumerate(frames):
        image = base
        if frame > 0 and is_drawn_once:
            clean.append(clean[0])
            recorded[:] = recorder.next(clean[0])
            continue
        if surface is not None and surface.indentation_mm[frame].any():
            image = lit(surface.indentation_mm[frame], base, optics, lights=lights)
        if _carries(optics) and surface is not None:
            image = image * print_shade(markers, optics, surface.drift_mm[frame])
        elif at_rest is not None:
            image = image * at_rest
        clean.append(image)
        recorded[:] = recorder.next(image)
    return frames, background, clean
