"""What is true of a clip, and what can be seen of it, on pictures whose slopes are known."""

import numpy as np
import pytest

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.simulation.motions import path_of
from geotlm_lm.simulation.optics import lit
from geotlm_lm.simulation.scene import GELSIGHT_MINI, Body, Gel, Optics, Path, Scene
from geotlm_lm.simulation.shapes import Indenter
from geotlm_lm.simulation.simulate import simulate
from geotlm_lm.simulation.truth import (
    READABLE_GREY,
    Trace,
    components_of,
    contact_of,
    image_change,
    is_readable,
    label_for,
    motion_at_contact,
    patch_displacement,
    shading_change,
    twist_of,
)

TOUCHED = np.ones((2, 14, 14), np.float32)


def scene(**path):
    still = {"depth_mm": (0.5, 0.5), "x_mm": (0, 0), "y_mm": (0, 0), "rotation_rad": (0, 0)}
    return Scene(Body("block"), Path(**still | path), Motion.STILL, optics=Optics(0.1, 0.05))


def test_a_patch_moves_as_the_rotation_matrix_says():
    angle, centre = 0.3, (1.0, -0.7)
    path = {"x_mm": (1.0, 1.0), "y_mm": (-0.7, -0.7), "rotation_rad": (0.0, angle)}
    moved = patch_displacement(scene(**path), TOUCHED)[1, 4, 11]
    here = np.array([(11.5 * 16 - 112) * 0.1, (4.5 * 16 - 112) * 0.05])
    back = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    was = np.array(centre) + back @ (here - centre)
    assert moved == pytest.approx((here - was) / (0.1, 0.05), abs=1e-3)


@pytest.mark.parametrize(
    ("motion", "contact", "trace", "expected"),
    [
        (Motion.CLOCKWISE, 0.1, Trace(1.9, turn_mm=1.0), False),
        (Motion.CLOCKWISE, 0.1, Trace(2.1, turn_mm=1.0), True),
        (Motion.CLOCKWISE, 0.1, Trace(9.0, turn_mm=1.0, slide_mm=1.1), False),
        (Motion.LEFT, 0.1, Trace(9.0, turn_mm=1.0, slide_mm=1.1), True),
        (Motion.LEFT, 0.1, Trace(9.0, turn_mm=1.0, slide_mm=0.9), False),
        (Motion.LEFT, 0.001, Trace(9.0, slide_mm=1.0), False),
        (Motion.PRESS, 0.1, Trace(9.0), True),
        (Motion.STILL, 0.1, Trace(), True),
        (Motion.NONE, 0.0, Trace(), True),
    ],
)
def test_a_motion_is_readable_when_it_beats_the_noise_and_the_lesser_one(
    motion, contact, trace, expected
):
    assert is_readable(motion, np.full(4, contact), trace) is expected


def test_a_label_until_an_earlier_frame_counts_to_that_frame():
    path = {"x_mm": (0.0, 1.0, 2.0), "y_mm": (0, 0, 0), "rotation_rad": (0.0, 0.1, 0.2)}
    moving = scene(depth_mm=(0.5, 0.4, 0.3), **path)
    label = label_for(moving, np.full(2, 0.1), Trace(), last=1)
    assert (label.slide_x_mm, label.depth_change_mm) == pytest.approx((1.0, -0.1))
    assert label.rotation_deg == pytest.approx(np.degrees(0.1))


def test_a_label_says_what_each_component_does_and_what_counts_of_it():
    path = {"x_mm": (0.2, -0.1), "rotation_rad": (0.3, 0.1), "depth_mm": (0.4, 0.6)}
    trace = Trace(travel_px=(-3.0, 4.0), radius_px=20.0, visible_grey=(9.0, 1.0, 0.0))
    label = label_for(scene(**path), np.full(2, 0.1), trace)
    components = components_of(label)
    assert [part.moves for part in components.values()] == [True, True, True]
    assert [part.is_visible for part in components.values()] == [True, False, False]
    ways = [part.way for part in components.values()]
    assert ways == [Motion.COUNTERCLOCKWISE, Motion.DOWN, Motion.PRESS]


def test_what_moves_the_imprint_by_less_than_noise_is_at_rest():
    label = MotionLabel(Motion.STILL, rotation_deg=0.1, travel_px=(0.1, 0.0), radius_px=10.0)
    counting = {name: part.moves for name, part in components_of(label).items()}
    assert counting == {Component.TURN: False, Component.SLIDE: None, Component.PRESS: False}
    with pytest.raises(ValueError, match="tells no twist"):
        twist_of(MotionLabel(Motion.LEFT, slide_x_mm=-1.0))


@pytest.mark.parametrize("turn", [0.3, -0.5])
def test_a_contact_beside_the_middle_is_carried_as_the_rotation_matrix_says(turn):
    contact = np.zeros((224, 224), bool)
    contact[20:60, 150:180] = True  # 2 mm high, 3 mm wide
    here = np.array([(165 - 112) * 0.1, (40 - 112) * 0.05])
    first, last = np.array([1.0, -2.0]), np.array([1.5, -0.5])
    path = {"x_mm": (1.0, 1.5), "y_mm": (-2.0, -0.5), "rotation_rad": (0.4, 0.4 + turn)}
    touched = contact_of(scene(**path), contact)
    *moved, turn_rad = motion_at_contact(scene(**path), touched.middle_mm, 1)
    arc = turn_rad * touched.radius_mm
    back = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    assert moved == pytest.approx(here - first - back @ (here - last), abs=1e-3)
    assert arc == pytest.approx(turn * np.hypot(2, 3) / 12**0.5, rel=1e-3)


@pytest.mark.parametrize("slope", [(0.5, 0.0), (0.3, -0.6), (-1.0, 0.2)])
def test_of_a_plane_on_an_even_gel_the_estimated_change_is_the_pictures(slope):
    optics = Optics(psf_mm=0.0, steep_darkening=0.3, saturation=1.2)
    axis = (np.arange(224) - 111.5).astype(np.float32)
    across, down = axis * optics.mm_per_px_x, axis[:, None] * optics.mm_per_px_y
    depths = np.stack([np.full((224, 224), 0.5), slope[0] * across + slope[1] * down])
    depths = depths.astype(np.float32)
    where = np.zeros((224, 224), bool)
    where[90:130, 90:130] = True
    levels = GELSIGHT_MINI.levels[:, 1:-1, 1:-1].mean(axis=(1, 2))[:, None, None]
    even = np.broadcast_to(levels, (3, 224, 224)).astype(np.float32)
    drawn = image_change(*(lit(depth, even, optics) for depth in depths), where)
    estimated = shading_change(optics, *depths, where)
    assert estimated == pytest.approx(drawn, rel=1e-4)


BALL = Indenter(lambda x, y, rng: (x * x + y * y) / 10)
EDGE = Indenter(lambda x, y, rng: np.abs(0.6 * x + 0.8 * y) / 2, is_extended=True)
BLOCK = Indenter(lambda x, y, rng: np.maximum(np.abs(x) - 3, np.abs(y) - 2).clip(0) * 4)

MOVE = {"turn_deg": 15.0, "right_mm": 0.5, "down_mm": 0.3, "inward_mm": 0.3}


def visible(indenter, dome=1.0, texture_um=0.0, **move):
    body = Body("own", indenter=indenter, texture_um=texture_um)
    scene = Scene(body, path_of(**move), Motion.STILL, Gel(dome=dome))
    label = simulate([scene], seed=0, with_frames=False)[0].label
    return dict(zip(COMPONENTS, label.visible_grey, strict=True))


@pytest.mark.parametrize("dome", [0.0, 1.0])
@pytest.mark.parametrize(("indenter", "hidden"), [(BALL, Component.TURN), (EDGE, Component.SLIDE)])
def test_a_smooth_ball_hides_its_turn_and_an_edge_how_far_it_goes_along_itself(
    indenter, hidden, dome
):
    seen = visible(indenter, dome, **MOVE)
    assert seen.pop(hidden) < READABLE_GREY / 2
    assert min(seen.values()) > 2 * READABLE_GREY


def test_a_block_hides_nothing_and_a_texture_shows_a_balls_turn():
    assert min(visible(BLOCK, **MOVE).values()) > 2 * READABLE_GREY
    assert visible(BALL, texture_um=30.0, **MOVE)[Component.TURN] > 2 * READABLE_GREY


def test_nothing_is_seen_of_what_does_not_happen_and_twice_of_twice_as_much():
    assert visible(BLOCK)[Component.PRESS] == 0
    seen = visible(BLOCK, turn_deg=4.0)
    assert seen[Component.SLIDE] < READABLE_GREY / 2
    assert seen[Component.PRESS] == 0
    assert visible(BLOCK, turn_deg=8.0)[Component.TURN] == pytest.approx(
        2 * seen[Component.TURN], rel=0.1
    )
