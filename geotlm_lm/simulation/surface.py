"""Contact solution to the gel's surface at image resolution; knows no light and no label."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.simulation.contact import (
    BOX_MM,
    FAST,
    GridContact,
    Preset,
    dome_mm,
    holds_detail,
    solve_contact,
)
from geotlm_lm.simulation.profile import Profile
from geotlm_lm.simulation.scene import Scene
from geotlm_lm.simulation.solvers import SolverStatus

_TAPS, _PIXELS = np.arange(-1, 3), np.arange(IMAGE_SIDE)[:, None]

_KEYS = np.array(
    [[-0.5, 1.5, -1.5, 0.5], [1.0, -2.5, 2.0, -0.5], [-0.5, 0.0, 0.5, 0.0], [0.0, 1.0, 0.0, 0.0]]
)
"""Weights of the four taps (columns) by power of the place between the inner two, cube first."""

FAR_MM = 1.0
"""Gap beyond which its size does not matter: where there is no body it would spoil cells beside."""

TOUCH_TOLERANCE_MM = 0.020
"""Gap that still counts as contact at image resolution: with it the touched area of nine bodies is
0.71 to 1.47 (median 0.96) of a five times finer grid's, measured."""


@dataclass(frozen=True, eq=False)
class Surface:
    """The gel's surface in every frame, (frames, 224, 224).

    The indentation is smoothed by the coat where nothing touches, and late to rise where the gel
    lags. The drift, (frames, 2, 224, 224), x before y, is the tangential displacement from rest;
    None where it was not asked for.
    """

    indentation_mm: NDArray[np.float32]
    touches: NDArray[np.bool_]
    drift_mm: NDArray[np.float32] | None
    status: SolverStatus


@contextmanager
def timed(timing_ms: dict[str, float], stage: str) -> Iterator[None]:
    """Note how many milliseconds a stage takes; a stage that is missing did not run."""
    started = time.perf_counter()
    yield
    timing_ms[stage] = 1e3 * (time.perf_counter() - started)


def pressed_surface(
    scene: Scene,
    profile: Profile,
    preset: Preset = FAST,
    *,
    with_drift: bool = False,
    timing_ms: dict[str, float] | None = None,
) -> Surface:
    """Return the gel's surface under `profile` in every frame of `scene`.

    Stages: `normal_contact` or `frictional_contact`, `interpolation`, and `fine_profile` where the
    body has detail that the contact grid's cells do not hold. What stands still is pressed once. An
    image without markers does not need the drift.
    """
    timing_ms = {} if timing_ms is None else timing_ms
    drags = with_drift and scene.gel.friction > 0
    count = len(scene.path)
    if len(set(scene.path.poses)) == 1 < count and not drags:
        once = replace(scene, path=scene.path.start)
        first = pressed_surface(once, profile, preset, with_drift=with_drift, timing_ms=timing_ms)
        fields = (first.indentation_mm, first.touches, first.drift_mm)
        repeated = (
            None if field is None else np.broadcast_to(field, (count, *field.shape[1:]))
            for field in fields
        )
        return Surface(*repeated, first.status)
    with timed(timing_ms, "frictional_contact" if drags else "normal_contact"):
        contact = solve_contact(scene, profile, preset, with_drift=with_drift)
    is_smooth = holds_detail(scene, profile, contact.indentation_mm.shape[-1])
    with timed(timing_ms, "interpolation"):
        solved, surface = _interpolated(scene, contact, with_gap=is_smooth)
    if not is_smooth:
        with timed(timing_ms, "fine_profile"):
            frames = contact.touches.nonzero().flatten().tolist()
            _print_through(solved, surface, scene, profile, contact.reach_mm, frames)
    # The gel rises late: a share of what a frame lacks of the one before is still there.
    if scene.gel.lag > 0:
        for before, now in pairwise(surface.indentation_mm):
            now += np.maximum(before - now, 0) * np.float32(scene.gel.lag)
    return surface


def _interpolated(
    scene: Scene, contact: GridContact, *, with_gap: bool
) -> tuple[NDArray[np.float32], Surface]:
    """Return the solution at every pixel, and the surface that the coat makes of it.

    With `with_gap` the cells decide what touches; otherwise nothing touches yet.
    """
    mm_per_px = scene.optics.mm_per_px
    cells = contact.indentation_mm.shape[-1]
    rows, columns = (_cubic_weights(size, cells) for size in mm_per_px[::-1])
    solved = _to_pixels(contact.indentation_mm, rows, columns)
    drift = None if contact.drift_mm is None else _to_pixels(contact.drift_mm, rows, columns)
    coated = solved
    if scene.gel.membrane_mm > 0:
        coat = _gaussian(scene.gel.membrane_mm, cells)
        coated = _to_pixels(contact.indentation_mm, rows @ coat, columns @ coat)
    is_away = ~contact.touches.numpy()
    touches = np.zeros(solved.shape, bool)
    if with_gap:
        gap = (contact.indentation_mm - contact.overlap_mm).clamp_max(FAR_MM)
        pixels = _to_pixels(gap, rows, columns)
        np.less(pixels, np.float32(TOUCH_TOLERANCE_MM), out=touches)
        # The object nowhere reaches through the surface.
        np.maximum(coated, solved - pixels, out=coated)
    touches[is_away] = False
    solved[is_away] = 0
    coated[is_away] = 0
    return solved, Surface(coated, touches, drift, contact.status)


def _print_through(
    solved, surface: Surface, scene: Scene, profile: Profile, reach: float, frames: list[int]
) -> None:
    """Put in, at the pixels of the frames in touch, what of the body is finer than the cells."""
    path, optics = scene.path, scene.optics
    mm_per_px = optics.mm_per_px
    dome = dome_mm(scene.gel, mm_per_px, IMAGE_SIDE, optics.mounting)
    for frame in frames:
        depth, *pose = path.poses[frame]
        window = profile.window(pose, mm_per_px, IMAGE_SIDE, reach)
        inside = window.slices
        elastic, coated = solved[frame][inside], surface.indentation_mm[frame][inside]
        if not elastic.size:
            continue
        rigid = profile.sample(pose, mm_per_px, IMAGE_SIDE, window)
        np.subtract(np.float32(depth) - dome[inside], rigid, out=rigid)
        # Detail finer than a cell prints through wherever the object reaches below the solution.
        surface.touches[frame][inside] = rigid > elastic - np.float32(TOUCH_TOLERANCE_MM)
        np.maximum(coated, rigid, out=coated)


def _gaussian(sigma_mm: float, cells: int) -> Tensor:
    """Return weights (cells, cells) of a periodic Gaussian; it keeps a volume exactly.

    On the contact grid: what is narrower than a third of a cell (0.18 mm with the fast preset)
    smooths nothing.
    """
    away = np.arange(cells)
    away = np.minimum(away, cells - away) * BOX_MM / cells
    line = np.exp(-0.5 * (away / sigma_mm) ** 2)
    line /= line.sum()
    index = (np.arange(cells)[:, None] - np.arange(cells)) % cells
    return torch.from_numpy(line[index].astype(np.float32))


def _to_pixels(values: Tensor, rows: Tensor, columns: Tensor) -> NDArray[np.float32]:
    # Cells beyond the view have no weight: they are half of all.
    tall, wide = _used(rows), _used(columns)
    rows, columns = rows[:, tall].contiguous(), columns[:, wide].contiguous()
    flat = values.float().reshape(-1, *values.shape[-2:])[:, tall, wide]
    across = flat.reshape(-1, flat.shape[-1]) @ columns.T
    # One matrix at a time: a batch of small products costs half as much again.
    pixels = torch.empty(len(flat), IMAGE_SIDE, IMAGE_SIDE)
    for cells, out in zip(across.split(flat.shape[1]), pixels, strict=True):
        torch.mm(rows, cells, out=out)
    return pixels.reshape(*values.shape[:-2], IMAGE_SIDE, IMAGE_SIDE).numpy()


def _used(weights: Tensor) -> slice:
    """Return the cells from the first to the last that any pixel takes from."""
    used = np.flatnonzero(weights.numpy().any(axis=0))
    return slice(int(used[0]), int(used[-1]) + 1)


def _cubic_weights(mm_per_px: float, cells: int) -> Tensor:
    """Return weights (224, cells) of cubic convolution (Keys, a = -1/2) from cells to pixels."""
    where = (np.arange(IMAGE_SIDE) - (IMAGE_SIDE - 1) / 2) * mm_per_px * cells / BOX_MM
    where += (cells - 1) / 2
    first = np.floor(where)
    taps = first.astype(int)[:, None] + _TAPS
    weights = np.zeros((IMAGE_SIDE, cells), np.float32)
    # Distinct taps of a pixel: no weight is added to another.
    weights[_PIXELS, taps % cells] = np.vander(where - first, 4) @ _KEYS
    return torch.from_numpy(weights)
