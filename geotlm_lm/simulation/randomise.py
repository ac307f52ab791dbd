"""Random scenes: which body, how it moves, on which gel, seen how; draws from measured ranges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.core.labels import ROTATIONS, Motion
from geotlm_lm.core.numbers import generator_for, log_uniform
from geotlm_lm.simulation.contact import dome_drop_mm
from geotlm_lm.simulation.gels import GELS, GelKind, random_kind, random_markers, random_print
from geotlm_lm.simulation.indenters import INDENTERS
from geotlm_lm.simulation.motions import (
    STEADY,
    UNSTEADY,
    dominant_motion,
    longest_mm,
    mixed_path,
    random_path,
)
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import (
    GELSIGHT_MINI,
    Body,
    Gel,
    Lamps,
    Mounting,
    Optics,
    Path,
    Scene,
    Three,
    VideoCodec,
)
from geotlm_lm.simulation.shapes import Indenter

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

MIXED_DOMINANCE = 2.0
"""How many times longer one path must be than the other for a mixed motion to have one name."""

TEXTURE_SCALE_MM = (0.1, 1.0)
"""Correlation length of an object's texture; from the size of a pixel on, since real imprints hold
detail that fine: gradients at 1 px are 1.7 to 2.0 times those at 3 px."""

ZOOM = (0.6, 1.15)
"""Pixel size relative to a GelSight Mini's 20.3 x 15.2 mm view; small views see single details."""

ASPECT = (0.95, 1.08)
"""Pixel width over height, relative to square ones (two cameras measured)."""

WIDE_ASPECT, WIDE_ASPECT_SHARE = (0.75, 1.35), 0.4
"""The same of sensors of any make, in a share of the clips whose kind of gel is drawn. Assumed:
views from 0.9 to 1.6 times as wide as high, squeezed into a square."""

MOUNTING_TURN_DEG = 3.0
"""Largest turn of the camera about its axis."""

MOUNTING_SHIFT_MM = 0.85
"""Farthest the pad's middle lies off the view's: half of what the view of 20.3 mm that readers crop
exceeds the 18.6 mm of the data sheet."""

LIGHT_TURN_DEG = 15.0
"""Farthest a light's direction lies from its usual one."""

STRENGTH = (0.4, 2.1)
"""Shading relative to the measured unit, drawn evenly on a log scale; real units go up to 2.3."""

CHANNEL_STRENGTH = ((0.65, 1.3), (0.8, 1.9), (0.65, 1.35))
"""Further factor per light, R, G, B; a second unit's is 2.3, 3.1 and 2.1 times the first's."""

LIGHT_SLOPE = 0.35
"""Largest relative growth of a light's shading from the middle to a border."""

SATURATION = (0.0, 2.0)
"""Softness of steep slopes; 1 to 2 fit one ball press."""

DEPTH_SHARE = ((0.4, 2.2), (0.4, 2.2), (0.0, 1.6))
"""Factor on the lamps' brightening with depth, R, G, B."""

SHADOW = (-0.3, 0.3)
"""Shadow behind flanks per unit slope, none below 0."""

PSF_MM = (0.0, 0.07)
"""Blur of the camera; real images hold signal up to 0.35 cycles per pixel."""

NOISE_GREY = (1.7, 1.24, 2.0)
"""Standard deviation of one frame's noise, R, G, B, measured on an uncompressed camera."""

NOISE_SHARE = (0.15, 1.8)
"""Factor on that, drawn evenly on a log scale: down to a recording that was averaged or scaled."""

DRIFT_GREY = (0.02, 0.6)
"""Spread of the white balance between frames, drawn evenly on a log scale; 0.07 to 0.11 in videos,
up to 1 grey level where a camera sets it by itself."""

SESSION_SHARE = 0.3
"""Share of clips whose idle frame was taken in another session."""

SESSION_CHANGE = 0.02
"""Spread of the light from one session to another, relative."""

VIDEO_SHARE = 0.5
"""Share of clips that come out of a lossy video, as all 237 real recordings at hand do."""

VIDEO_STRENGTH = (0.75, 1.5)
"""Its noise relative to the measured videos', drawn evenly on a log scale."""

VIDEO_FRAMES_APART = 12
"""Most frames of a video between two of a clip; drawn evenly on a log scale from 1."""

JPEG_SHARE = 0.12
"""Share of clips stored as single JPEG images."""

JPEG_QUALITY = (60, 96)

FAST = (0.05, 1.0)
"""How much of its motion a clip of a fast camera shows, drawn evenly on a log scale: 120 frames per
second beside 8 to 25."""


def random_scenes(
    seed: int,
    count: int,
    *,
    objects: Sequence[str],
    first_index: int = 0,
    motions: Sequence[Motion] | None = None,
    gels: Mapping[str, float] | None = None,
    **shares: float,
) -> list[Scene]:
    """Return scenes `first_index` .. of the endless series of `seed`; equally many of each motion.

    A scene depends only on its place in the series. Shares are those of `random_scene`; without
    `motions` all ten are drawn.
    """
    kinds = tuple(motions) if motions is not None else tuple(Motion)
    scenes = []
    for index in range(first_index, first_index + count):
        rng = generator_for(seed, "scene", index)
        name = objects[int(rng.integers(len(objects)))]
        motion = kinds[_order(seed, index // len(kinds), len(kinds))[index % len(kinds)]]
        scenes.append(random_scene(rng, object_name=name, motion=motion, gels=gels, **shares))
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
    marker_share: float = 0.0,
    unsteady_share: float = 0.0,
    mixed_share: float = 0.0,
    fast_share: float = 0.0,
    gels: Mapping[str, float] | None = None,
) -> Scene:
    """Return a scene of an object doing `motion`, everything else drawn from `rng`.

    The shares are probabilities: of markers on the gel, on which the rest does not depend; of an
    unsteady hand; of a path that turns, slides and presses freely instead; of a camera so fast that
    it sees little of the motion. `gels` are shares of kinds of gel, instead of markers; without
    them it is a GelSight Mini. A shape of the caller's own keeps its size, and may have any name.
    """
    # Nothing is drawn where no scene is mixed: plain series stay what they were.
    is_mixed = mixed_share > 0 and motion is not Motion.NONE and rng.random() < mixed_share
    optics, gel, gel_kind = _random_sensor(rng, gels)
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
        path = mixed_path(rng, depths, centre)
    else:
        path = random_path(rng, depths, centre, motion, UNSTEADY if is_unsteady else STEADY)
    if fast_share > 0 and rng.random() < fast_share:
        path = path.shortened(log_uniform(rng, FAST))
    if gel_kind.most_px is not None:
        most_mm = gel_kind.most_px * rng.uniform() * min(optics.mm_per_px)
        path = path.shortened(min(1.0, most_mm / max(longest_mm(path), 1e-6)))
    motion = dominant_motion(path) if is_mixed else motion
    path = with_history(rng, path)
    # Drawn last: a scene with markers is the same scene.
    if rng.random() < marker_share:
        gel_kind = GELS["mini, dots"]
        optics = replace(optics, markers=random_markers(rng))
    dominance = MIXED_DOMINANCE if is_mixed else 1.0
    return Scene(body, path, motion, gel, optics, dominance, gel_kind.name)


def _random_sensor(
    rng: np.random.Generator, gels: Mapping[str, float] | None
) -> tuple[Optics, Gel, GelKind]:
    if gels is None:
        return random_optics(rng), random_gel(rng), GELS["mini"]
    kind = random_kind(rng, gels)
    aspect = WIDE_ASPECT if rng.random() < WIDE_ASPECT_SHARE else ASPECT
    # A Mini's picture is always the same way up.
    turn = int(rng.integers(4))
    lamps = kind.lamps if kind.lamps is GELSIGHT_MINI else kind.lamps.turned(turn)
    optics = random_optics(rng, lamps, aspect)
    gel, is_flat = random_gel(rng), rng.random() < kind.flat_share
    markers = random_print(rng, kind.printed)
    return replace(optics, markers=markers), replace(gel, dome=0.0) if is_flat else gel, kind


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


def random_optics(
    rng: np.random.Generator,
    lamps: Lamps = GELSIGHT_MINI,
    aspect: tuple[float, float] = ASPECT,
) -> Optics:
    """Return a camera, lights and noise within the ranges real units were measured in."""
    zoom, ratio = rng.uniform(*ZOOM), rng.uniform(*aspect)
    strength = log_uniform(rng, STRENGTH)
    turns = np.radians(lamps.usual_turn_deg + rng.uniform(-1, 1, 3) * LIGHT_TURN_DEG)

    def alike(values) -> Three:
        """White light is the same in all channels."""
        return _three([values[0]] * 3 if lamps.is_white else values)

    is_other_session = rng.random() < SESSION_SHARE
    how = rng.random()
    return Optics(
        mm_per_px_x=20.3 / 224 * zoom * ratio**0.5,
        mm_per_px_y=15.2 / 224 * zoom / ratio**0.5,
        light_turn_rad=alike(turns),
        light_gain=alike([strength * rng.uniform(*span) for span in CHANNEL_STRENGTH]),
        light_slope_x=alike(rng.uniform(-LIGHT_SLOPE, LIGHT_SLOPE, 3)),
        light_slope_y=alike(rng.uniform(-LIGHT_SLOPE, LIGHT_SLOPE, 3)),
        common_light=tuple(strength * rng.normal(0, lamps.common_light) for _ in range(2)),
        steep_darkening=strength * rng.uniform(*lamps.steep_darkening),
        saturation=rng.uniform(*SATURATION),
        depth_gain=alike(
            [gain * rng.uniform(*s) for gain, s in zip(lamps.depth_gain, DEPTH_SHARE, strict=True)]
        ),
        shadow=max(rng.uniform(*SHADOW), 0.0),
        psf_mm=rng.uniform(*PSF_MM),
        noise_grey=_three(np.array(NOISE_GREY) * log_uniform(rng, NOISE_SHARE)),
        drift_grey=log_uniform(rng, DRIFT_GREY),
        light_change=_three(rng.normal(0, SESSION_CHANGE, 3) * is_other_session),
        jpeg_quality=int(rng.integers(*JPEG_QUALITY)) if how > 1 - JPEG_SHARE else None,
        video=_random_video(rng) if how < VIDEO_SHARE else None,
        idle=int(rng.integers(2**31)),
        mounting=_random_mounting(rng),
        lamps=lamps,
    )


def _random_mounting(rng: np.random.Generator) -> Mounting:
    turn, x, y = rng.uniform(-1, 1, 3).tolist()
    turn_rad = float(np.radians(turn * MOUNTING_TURN_DEG))
    return Mounting(turn_rad, x * MOUNTING_SHIFT_MM, y * MOUNTING_SHIFT_MM)


def _random_video(rng: np.random.Generator) -> VideoCodec:
    strength, usual = log_uniform(rng, VIDEO_STRENGTH), VideoCodec()
    return VideoCodec(
        whole_grey=_three(strength * np.array(usual.whole_grey)),
        predicted_grey=_three(strength * np.array(usual.predicted_grey)),
        frames_apart=round(log_uniform(rng, (1, VIDEO_FRAMES_APART))),
    )


def _three(values: Sequence[float] | np.ndarray) -> Three:
    first, second, third = (float(value) for value in values)
    return first, second, third
