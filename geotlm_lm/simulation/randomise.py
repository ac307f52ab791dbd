"""Random scenes: which body, how it moves, through which camera; draws from measured ranges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.core.labels import ROTATIONS, Motion
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.simulation.contact import dome_drop_mm
from geotlm_lm.simulation.indenter import Indenter
from geotlm_lm.simulation.indenters import INDENTERS
from geotlm_lm.simulation.motions import random_path
from geotlm_lm.simulation.optics import LIGHTS
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import Body, Gel, Optics, Scene

DEPTH_MM = (0.2, 1.2)
"""Approach a hand gives a GelSight Mini; a measured ball press has a contact radius of 2 mm."""

LEAST_CONTACT = 0.015
"""Share of the view that a claimed motion has in contact, by design, in every frame."""

ELASTIC_SHARE = 0.35
"""Elastic contact area over geometric overlap: measured 0.57 to 0.77 for smooth bodies in full
view, less for textured ones and near the border."""

CENTRE_MM = 5.0
"""Farthest the contact's middle lies from the view's middle, along each axis."""


def random_scenes(
    seed: int,
    count: int,
    *,
    objects: Sequence[str],
    first_index: int = 0,
    motions: Sequence[Motion] | None = None,
) -> list[Scene]:
    """Return scenes `first_index` .. of the endless series of `seed`; equally many of each motion.

    Args:
        seed: Root seed.
        count: How many scenes.
        objects: Names to draw from.
        first_index: Where in the series to begin; a scene depends only on its place.
        motions: Motions to draw from; all ten by default.
    """
    kinds = tuple(motions) if motions is not None else tuple(Motion)
    scenes = []
    for index in range(first_index, first_index + count):
        rng = generator_for(seed, "scene", index)
        order = generator_for(seed, "motions", index // len(kinds)).permutation(len(kinds))
        name = objects[int(rng.integers(len(objects)))]
        motion = kinds[order[index % len(kinds)]]
        scenes.append(random_scene(rng, object_name=name, motion=motion))
    return scenes


def random_scene(
    rng: np.random.Generator, *, object_name: str, motion: Motion, indenter: Indenter | None = None
) -> Scene:
    """Return a scene of an object doing `motion`, everything else drawn from `rng`.

    Args:
        rng: Source of everything random.
        object_name: A name in `indenters.INDENTERS`, or any name beside an `indenter`.
        motion: What the object does.
        indenter: A shape of the caller's own; it keeps its size.
    """
    optics = random_optics(rng)
    gel = Gel(
        thickness_mm=rng.uniform(3.0, 4.8),
        poisson_ratio=rng.uniform(0.45, 0.499),
        dome=rng.uniform(0.0, 1.3),
    )
    body = random_body(rng, object_name)
    kind = indenter or INDENTERS[object_name]
    if indenter is not None:
        body = replace(body, indenter=indenter, size=1.0)
    if kind.is_axisymmetric and motion in ROTATIONS:
        body = replace(body, texture_um=rng.uniform(15, 40), texture_scale_mm=rng.uniform(0.3, 0.8))
    half_x, half_y = (side * IMAGE_SIDE / 2 for side in (optics.mm_per_px_x, optics.mm_per_px_y))
    # A corner of the contact stays in view: the middle is kept inside the border.
    centre = (
        rng.uniform(-1, 1) * min(CENTRE_MM, 0.65 * half_x),
        rng.uniform(-1, 1) * min(CENTRE_MM, 0.65 * half_y),
    )
    # Away from its middle the domed pad lies lower: the approach grows by as much.
    drop = dome_drop_mm(gel, *centre)
    least = 0.0
    if motion != Motion.NONE:
        least_area = LEAST_CONTACT * 4 * half_x * half_y / ELASTIC_SHARE
        least = build_profile(body).depth_for_area(least_area)
    low = min(max(DEPTH_MM[0], least), DEPTH_MM[1]) + drop
    path = random_path(
        rng,
        motion,
        depth_range_mm=(low, DEPTH_MM[1] + drop),
        centre_mm=centre,
    )
    return Scene(body, path, motion, gel, optics)


def random_body(rng: np.random.Generator, name: str) -> Body:
    """Return a body of the kind `name` with its own size, lean, texture and features."""
    lean, towards = np.tan(np.radians(rng.uniform(0, 8))), rng.uniform(-np.pi, np.pi)
    return Body(
        name,
        variant=int(rng.integers(2**31)),
        size=rng.uniform(0.75, 1.3),
        tilt_x=float(lean * np.cos(towards)),
        tilt_y=float(lean * np.sin(towards)),
        texture_um=float(max(rng.uniform(-15, 40), 0.0)),
        texture_scale_mm=rng.uniform(0.2, 1.0),
    )


def random_optics(rng: np.random.Generator) -> Optics:
    """Return a camera, lights and noise within the ranges real units were measured in."""
    zoom, ratio = rng.uniform(0.6, 1.15), rng.uniform(0.95, 1.08)
    strength = np.exp(rng.uniform(np.log(0.35), np.log(1.8)))
    gains = strength * rng.uniform(0.65, 1.3, 3)
    noise = np.exp(rng.uniform(np.log(0.15), np.log(1.8)))
    return Optics(
        mm_per_px_x=20.3 / 224 * zoom * ratio**0.5,
        mm_per_px_y=15.2 / 224 * zoom / ratio**0.5,
        light_turn_rad=_three(rng.uniform(-1, 1, len(LIGHTS)) * np.radians(15)),
        light_gain=_three(gains),
        light_slope_x=_three(rng.uniform(-0.35, 0.35, 3)),
        light_slope_y=_three(rng.uniform(-0.35, 0.35, 3)),
        common_light=(rng.normal(0, 0.2) * strength, rng.normal(0, 0.2) * strength),
        steep_darkening=strength * rng.uniform(0, 0.35),
        saturation=rng.uniform(0, 2),
        depth_gain=_three(np.array([0.066, 0.037, 0.083]) * rng.uniform(0, 1.8)),
        shadow=max(rng.uniform(-0.3, 0.3), 0.0),
        psf_mm=rng.uniform(0, 0.1),
        noise_grey=_three(np.array([1.7, 1.24, 2.0]) * noise),
        drift_grey=rng.uniform(0, 1),
        light_change=_three(rng.normal(0, 0.02, 3) if rng.random() < 0.3 else np.zeros(3)),
        jpeg_quality=int(rng.integers(60, 96)) if rng.random() < 0.3 else None,
        idle=int(rng.integers(2**31)),
    )


def _three(values: np.ndarray) -> tuple[float, float, float]:
    first, second, third = (float(value) for value in values)
    return first, second, third
