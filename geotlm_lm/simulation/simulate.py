"""The room's seam: scenes to clips with their truth; the same seed, index and scene, same bytes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import GRID_SIDE, IMAGE_SIDE
from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.simulation.idle import idle_frame
from geotlm_lm.simulation.label import label_for, patch_displacement, patch_means
from geotlm_lm.simulation.normal_contact import SolverStatus
from geotlm_lm.simulation.optics import NOMINAL_VIEW_MM, lit, recorded, turned_lights
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import Optics, Scene
from geotlm_lm.simulation.surface import Surface, pressed_surface
from geotlm_lm.simulation.trace import Trace, trace_of

IMAGE_STAGES = ("profile", "normal_contact", "optics", "truth")
"""What a touched clip runs; the frictional problem is left out, since the imprint of a rigid object
moves with it whether it sticks or slips, and shear changes a markerless image by less than noise
(at most 0.7 grey levels RMS, measured)."""

IDLE_STAGES = ("optics", "truth")
"""What a clip without contact runs."""

BACKGROUND_NOISE = 0.45
"""Noise of an idle frame averaged over about five frames, relative to one frame's."""

CAMERA_FPS = 25.0
"""Frames per second of a GelSight Mini's camera (gs_sdk)."""


@dataclass(frozen=True, eq=False)
class SimulatedClip:
    """A clip and the truth about it.

    Args:
        clip: Four (or the path's number of) frames of 224x224 and their idle frame.
        traces: What there is to see of the motion between the first and each frame.
        object_name: Name of the body.
        scene: What was simulated.
        displacement_px: float32 (frames, 14, 14, 2), the object's travel since frame 0 at each
            patch centre in pixels of the image (x right, y down), 0 without contact.
        contact: float32 (frames, 14, 14), share of each patch in contact.
        depth_mm: float32 (frames, 14, 14), mean indentation of the surface.
        mm_per_px: Pixel size (x, y).
        status: The contact solver's account.
        stages: What ran, in order.
    """

    clip: Clip
    traces: tuple[Trace, ...]
    object_name: str
    scene: Scene
    displacement_px: NDArray[np.float32]
    contact: NDArray[np.float32]
    depth_mm: NDArray[np.float32]
    mm_per_px: tuple[float, float]
    status: SolverStatus
    stages: tuple[str, ...]

    @property
    def label(self) -> MotionLabel:
        """What the object does from the first frame to the last."""
        return self.label_until(len(self.traces) - 1)

    def label_until(self, last: int) -> MotionLabel:
        """Return what the object does from the first frame to frame `last`."""
        fraction = self.contact[: last + 1].mean(axis=(1, 2))
        return label_for(self.scene, fraction, self.traces[last], last)


def simulate(scenes: Sequence[Scene], *, seed: int, first_index: int = 0) -> list[SimulatedClip]:
    """Return one clip per scene; clip i depends only on (seed, first_index + i, its scene).

    A clip's frames are solved as one batch of fixed size, never together with another clip's:
    float32 transforms round differently in differently sized batches.
    """
    return [_simulate_one(scene, seed, first_index + i) for i, scene in enumerate(scenes)]


def _simulate_one(scene: Scene, seed: int, index: int) -> SimulatedClip:
    rng = generator_for(seed, "clip", index)
    is_touched = max(scene.path.depth_mm) > 0
    surface = pressed_surface(scene, build_profile(scene.body)) if is_touched else None
    view = scene.optics.mm_per_px_x * IMAGE_SIDE / NOMINAL_VIEW_MM
    idle = idle_frame(scene.optics.idle, view)
    frames, background, traces = _render(scene, surface, idle, rng)
    count = len(scene.path)
    contact = np.zeros((count, GRID_SIDE, GRID_SIDE), np.float32)
    depth = np.zeros_like(contact)
    if surface is not None:
        contact = patch_means(surface.touches)
        depth = patch_means(surface.indentation_mm)
    return SimulatedClip(
        clip=Clip(
            frames, fps=CAMERA_FPS, background=background, name=f"{scene.body.name}-{seed}-{index}"
        ),
        traces=traces,
        object_name=scene.body.name,
        scene=scene,
        displacement_px=patch_displacement(scene, contact),
        contact=contact,
        depth_mm=depth,
        mm_per_px=(scene.optics.mm_per_px_x, scene.optics.mm_per_px_y),
        status=surface.status if surface is not None else SolverStatus(0.0, 0, True),
        stages=IMAGE_STAGES if is_touched else IDLE_STAGES,
    )


def _render(
    scene: Scene, surface: Surface | None, idle: NDArray[np.float32], rng: np.random.Generator
) -> tuple[NDArray[np.uint8], NDArray[np.uint8], tuple[Trace, ...]]:
    """Return frames (t, 224, 224, 3), the idle frame, and what each frame shows of the motion."""
    optics = scene.optics
    lights = turned_lights(optics)
    background = recorded(idle, optics, rng, noise_share=BACKGROUND_NOISE)
    base = idle * (1 + np.asarray(optics.light_change, np.float32))[:, None, None]
    clean = []
    for frame in range(len(scene.path)):
        if surface is None or not surface.touches[frame].any():
            clean.append(base)
        else:
            clean.append(lit(surface.indentation_mm[frame], base, optics, lights=lights))
    traces = (Trace(),) * len(clean)
    if surface is not None:
        later = range(1, len(clean))
        traces = (Trace(), *(trace_of(scene, clean, surface.touches, last) for last in later))
    frames = np.stack([_with_drift(image, optics, rng) for image in clean])
    return frames, background, traces


def _with_drift(
    image: NDArray[np.float32], optics: Optics, rng: np.random.Generator
) -> NDArray[np.uint8]:
    drift = np.clip(rng.normal(0, optics.drift_grey, 3), -1, 1).astype(np.float32)
    return recorded(image + drift[:, None, None], optics, rng)
