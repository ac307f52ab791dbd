"""Random scenes: which body, how it moves, on which gel; draws from measured ranges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.core.labels import ROTATIONS, Motion
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.simulation.contact import dome_drop_mm
from geotlm_lm.simulation.indenter import Indenter
from geotlm_lm.simulation.indenters import INDENTERS
from geotlm_lm.simulation.motions import (
    STEADY,
    UNSTEADY,
    dominant_motion,
    mixed_path,
    random_path,
)
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.randomise_optics import random_markers, random_optics
from geotlm_lm.simulation.scene import Body, Gel, Path, Scene

DEPTH_MM = (0.2, 1.2)
"""Approach a hand gives a GelSight Mini; a measured ball press has a contact radius of 2 mm."""

LEAST_CONTACT = 0.015
"""Share of the view that a claimed motion has in contact, by design, in every frame."""

ELASTIC_SHARE = 0.35
"""Elastic contact area over geometric overlap: measured 0.57 to 0.77 for smooth bodies in full
view, less for textured ones and near the border."""

CENTRE_MM = 5.0
"""Farthest the contact's middle lies from the view's middle, along each axis."""

FRICTION = (0.3, 1.5)
"""Coulomb's coefficient between object and gel, about the 1.0 of FEATS and Taccel; it is felt only
where friction is solved."""

MEMBRANE_MM = (-0.3, 0.3)
"""Smoothing by the coat, none below 0; up to where one measured ball press is fitted."""

LAG = (-0.4, 0.35)
"""Share of an indentation left one frame after the object is gone, none below 0: the gel's creep
lasts one to three frames. Assumed: no recording tells it from the hand's own motion."""

PRE_SLIDE_MM = 0.4
PRE_TURN_DEG = 4.0
"""Largest shear and twist that the gel brings along from before the first frame: about a step of a
handling; felt only where friction is solved."""

PRE_SHARE = 0.5
"""Share of clips whose gel is sheared or twisted already."""

MARKER_SHARE = 0.0
"""Share of clips on a gel with markers."""

UNSTEADY_SHARE = 0.0
"""Share of clips made by an unsteady hand."""

MIXED_SHARE = 0.0
"""Share of clips whose motion is freely mixed."""

MIXED_DOMINANCE = 2.0
"""How many times longer one path must be than the other for a mixed motion to have one name."""

TEXTURE_SCALE_MM = (0.1, 1.0)
"""Correlation length of an object's texture; from the size of a pixel on, since real imprints hold
detail that fine: gradients at 1 px are 1.7 to 2.0 times those at 3 px."""


def random_scenes(
    seed: int,
    count: int,
    *,
    objects: Sequence[str],
    first_index: int = 0,
    motions: Sequence[Motion] | None = None,
    marker_share: float = MARKER_SHARE,
    unsteady_share: float = UNSTEADY_SHARE,
    mixed_share: float = MIXED_SHARE,
) -> list[Scene]:
    """Return scenes `first_index` .. of the endless series of `seed`; equally many of each motion.

    Args:
        seed: Root seed.
        count: How many scenes.
        objects: Names to draw from.
        first_index: Where in the series to begin; a scene depends only on its place.
        motions: Motions to draw from; all ten by default.
        marker_share: Share of scenes on a gel with markers; the rest of a scene does not depend
            on it.
        unsteady_share: Share of scenes made by `motions.UNSTEADY`.
        mixed_share: Share of scenes that turn, slide and press at once, as they may.
    """
    kinds = tuple(motions) if motions is not None else tuple(Motion)
    scenes = []
    for index in range(first_index, first_index + count):
        rng = generator_for(seed, "scene", index)
        order = _order(seed, index // len(kinds), len(kinds))
        name = objects[int(rng.integers(len(objects)))]
        motion = kinds[order[index % len(kinds)]]
        scene = random_scene(
            rng,
            object_name=name,
            motion=motion,
            marker_share=marker_share,
            unsteady_share=unsteady_share,
            mixed_share=mixed_share,
        )
        scenes.append(scene)
    return scenes


@lru_cache(maxsize=4)
def _order(seed: int, block: int, count: int) -> tuple[int, ...]:
    """Return the order of `count` motions in a block of as many scenes."""
    return tuple(generator_for(seed, "motions", block).permutation(count).tolist())


def random_scene(
    rng: np.random.Generator,
    *,
    object_name: str,
    motion: Motion,
    indenter: Indenter | None = None,
    marker_share: float = MARKER_SHARE,
    unsteady_share: float = UNSTEADY_SHARE,
    mixed_share: float = MIXED_SHARE,
) -> Scene:
    """Return a scene of an object doing `motion`, everything else drawn from `rng`.

    Args:
        rng: Source of everything random.
        object_name: A name in `indenters.INDENTERS`, or any name beside an `indenter`.
        motion: What the object does.
        indenter: A shape of the caller's own; it keeps its size.
        marker_share: Probability of markers on the gel.
        unsteady_share: Probability of an unsteady hand.
        mixed_share: Probability that it turns, slides and presses freely instead.
    """
    # Nothing is drawn where no scene is mixed: plain series stay what they were.
    is_mixed = mixed_share > 0 and motion is not Motion.NONE and rng.random() < mixed_share
    optics, gel = random_optics(rng), random_gel(rng)
    body = random_body(rng, object_name)
    kind = indenter or INDENTERS[object_name]
    if indenter is not None:
        body = replace(body, indenter=indenter, size=1.0)
    if kind.is_axisymmetric and motion in ROTATIONS and not is_mixed:
        body = replace(body, texture_um=rng.uniform(15, 40), texture_scale_mm=rng.uniform(0.3, 0.8))
    half_x, half_y = (side * IMAGE_SIDE / 2 for side in (optics.mm_per_px_x, optics.mm_per_px_y))
    # A corner of the contact stays in view: the middle is kept inside the border.
    centre = (
        rng.uniform(-1, 1) * min(CENTRE_MM, 0.65 * half_x),
        rng.uniform(-1, 1) * min(CENTRE_MM, 0.65 * half_y),
    )
    # Away from its middle the domed pad lies lower: the approach grows by as much.
    drop = dome_drop_mm(gel, *centre, optics.mounting)
    least = 0.0
    if motion != Motion.NONE:
        least_area = LEAST_CONTACT * 4 * half_x * half_y / ELASTIC_SHARE
        least = build_profile(body).depth_for_area(least_area)
    low = min(max(DEPTH_MM[0], least), DEPTH_MM[1]) + drop
    # Nothing is drawn where all hands are steady: series without unsteady ones stay what they were.
    is_unsteady = unsteady_share > 0 and rng.random() < unsteady_share
    depths = (low, DEPTH_MM[1] + drop)
    if is_mixed:
        path = mixed_path(rng, depth_range_mm=depths, centre_mm=centre)
        motion = dominant_motion(path)
    else:
        hand = UNSTEADY if is_unsteady else STEADY
        path = random_path(rng, motion, depth_range_mm=depths, centre_mm=centre, hand=hand)
    path = with_history(rng, path)
    # Drawn last: a scene with markers is the same scene.
    if rng.random() < marker_share:
        optics = replace(optics, markers=random_markers(rng))
    return Scene(body, path, motion, gel, optics, MIXED_DOMINANCE if is_mixed else 1.0)


def random_gel(rng: np.random.Generator) -> Gel:
    """Return a pad within the ranges of the products and models it is known from."""
    return Gel(
        thickness_mm=rng.uniform(3.0, 4.8),
        poisson_ratio=rng.uniform(0.45, 0.499),
        dome=rng.uniform(0.0, 1.3),
        friction=rng.uniform(*FRICTION),
        membrane_mm=max(rng.uniform(*MEMBRANE_MM), 0.0),
        lag=max(rng.uniform(*LAG), 0.0),
    )


def with_history(rng: np.random.Generator, path: Path) -> Path:
    """Return the path, in some clips after a slide and a turn that sheared the gel before it."""
    towards, far = rng.uniform(-np.pi, np.pi), rng.uniform(0, PRE_SLIDE_MM)
    turn, is_handled = rng.uniform(-PRE_TURN_DEG, PRE_TURN_DEG), rng.random() < PRE_SHARE
    if not is_handled:
        return path
    slide = (float(far * np.cos(towards)), float(far * np.sin(towards)))
    return replace(path, pre_slide_mm=slide, pre_turn_rad=float(np.radians(turn)))


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
        texture_scale_mm=float(np.exp(rng.uniform(*np.log(TEXTURE_SCALE_MM)))),
    )
