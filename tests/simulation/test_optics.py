"""Expected colours: measured on a GelSight Mini (flank right green, down blue, up red).

Dots are printed on the gel: they stand where its points have been carried.
"""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.simulation.camera import Recorder
from geotlm_lm.simulation.contact import FAST
from geotlm_lm.simulation.optics import lit, print_shade, resting_dots, turned_lights
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import Body, Markers, Mounting, Optics, Path, Scene
from geotlm_lm.simulation.simulate import simulate
from geotlm_lm.simulation.surface import pressed_surface
from geotlm_lm.simulation.truth import patch_means

AXIS = (np.arange(224) - 111.5).astype(np.float32)
GREY = np.full((3, 224, 224), 100, np.float32)


def ramp(towards_x, towards_y, slope=0.5):
    """Return an indentation that falls towards the given side of the image."""
    optics = Optics()
    x, y = AXIS[None, :] * optics.mm_per_px_x, AXIS[:, None] * optics.mm_per_px_y
    return (10 - slope * (towards_x * x + towards_y * y)).astype(np.float32)


@pytest.mark.parametrize(
    ("side", "expected"),
    [((1, 0), (-6, 24.5, -1.5)), ((0, 1), (-54, 3.5, 28)), ((0, -1), (54, -3.5, -28))],
)
def test_a_flank_takes_the_colour_of_the_light_it_faces(side, expected):
    optics = Optics(saturation=0, depth_gain=(0, 0, 0))
    change = lit(ramp(*side), GREY, optics)[:, 100:120, 100:120].mean(axis=(1, 2)) - 100
    assert change == pytest.approx(expected, abs=0.2)


def test_steep_flanks_saturate_as_the_formula_says():
    optics = Optics(saturation=1.5, depth_gain=(0, 0, 0))
    change = lit(ramp(1, 0, slope=1.0), GREY, optics)[1, 100:120, 100:120].mean() - 100
    assert change == pytest.approx(49 / np.sqrt(1 + 1.5**2), abs=0.2)


def test_a_light_turned_clockwise_from_above_comes_from_the_right():
    lights = turned_lights(Optics(light_turn_rad=(np.pi / 2, 0, 0)))
    assert lights[0] == pytest.approx((1.08, -0.12))
    assert np.array_equal(lights[1:], turned_lights(Optics())[1:])


@pytest.mark.parametrize("from_x", [1, -1])
def test_a_shadow_falls_behind_the_height_that_stands_towards_the_light(from_x):
    # A wall over the half of the image that the light comes from shades the low ground before it.
    wall = (AXIS * from_x > 0).astype(np.float32)
    height = np.tile(wall, (224, 1))
    lights = np.array([[from_x, 0.0]] * 3)
    plain, shaded = (
        lit(height, GREY, Optics(shadow=share, psf_mm=0, depth_gain=(0, 0, 0)), lights=lights)
        for share in (0.0, 0.3)
    )
    dark = (plain - shaded)[0, 112]
    reach_px = 0.6 / Optics().mm_per_px_x
    before = (AXIS * from_x < -1) & (AXIS * from_x > -reach_px)
    assert np.all(dark[before] > 10)
    assert not dark[AXIS * from_x > 2].any()
    assert not dark[AXIS * from_x < -reach_px - 1].any()


def test_bright_light_saturates_instead_of_wrapping():
    image = Recorder(Optics(), generator_for(0, "noise")).next(GREY * 3)
    assert image.min() == 255


DOTS = Markers()
MARKED = Optics(markers=DOTS, noise_grey=(0.0,) * 3, drift_grey=0.0)
UNLIT = replace(MARKED, light_gain=(0.0,) * 3, depth_gain=(0.0,) * 3)
PIXEL_MM = np.array([[MARKED.mm_per_px_x], [MARKED.mm_per_px_y]])
SLIDE = Path((0.6, 0.6), (0.0, 0.4), (0.0, 0.15), (0.3, 0.3))


def centroids(dark, near_px, reach=10):
    """Return where the darkness within `reach` of each point has its middle, (2, n)."""
    middles = []
    for x, y in near_px.T:
        columns = np.arange(int(x) - reach, int(x) + reach + 2)
        rows = np.arange(int(y) - reach, int(y) + reach + 2)
        window = dark[np.ix_(rows, columns)]
        middles.append([window.sum(0) @ columns, window.sum(1) @ rows] / window.sum())
    return np.array(middles).T


def between_pixels(field, points):
    x, y = points.astype(np.float32)[:, None]
    planes = [cv2.remap(plane.astype(np.float32), x, y, cv2.INTER_LINEAR) for plane in field]
    return np.concatenate(planes)


def well_inside(points):
    return points[:, (np.abs(points - 111.5) < 90).all(axis=0)]


def test_dots_at_rest_lie_on_the_grid_to_a_hundredth_of_a_pixel():
    rest = well_inside(resting_dots(DOTS, MARKED)[0])
    assert rest.shape[1] > 30
    assert np.abs(centroids(1 - print_shade(DOTS, MARKED), rest) - rest).max() < 0.01


def test_a_dot_is_as_wide_and_as_dark_as_asked_for():
    wide = replace(DOTS, spacing_mm=8.0, diameter_mm=2.0)
    row = 1 - print_shade(wide, replace(MARKED, mm_per_px_x=0.02, mm_per_px_y=0.02))[111]
    middle = row.max()
    assert middle == pytest.approx(DOTS.darkness * (1 - np.exp(-3)), abs=0.001)
    # Half of what the flat-topped dot swallows at most, counted in pixels of 0.02 mm.
    assert (row > 0.5 * DOTS.darkness).sum() * 0.02 == pytest.approx(2.0, abs=0.05)


def test_in_a_clip_the_dots_go_where_its_truth_says_the_gel_goes():
    scene = Scene(Body("ball_medium"), SLIDE, Motion.RIGHT, optics=UNLIT)
    (made,) = simulate([scene], seed=3, with_drift=True)
    surface = pressed_surface(scene, build_profile(scene.body), FAST, with_drift=True)
    dense = surface.drift_mm[1] / PIXEL_MM[..., None]
    assert np.allclose(np.moveaxis(made.drift_px[1], -1, 0), patch_means(dense), atol=1e-4)
    light = made.clip.background.astype(float)
    # Without light and noise nothing but the dots differs from an unmarked gel.
    plain = replace(scene, optics=replace(UNLIT, markers=None))
    bare = simulate([plain], seed=3)[0].clip.background
    rest = well_inside(resting_dots(DOTS, UNLIT)[0])
    expected = between_pixels(dense, rest)
    still = centroids((1 - light / bare).mean(axis=-1).clip(0), rest)
    moved = centroids((1 - made.clip.frames[1] / bare).mean(axis=-1).clip(0), rest + expected)
    moves = np.hypot(*expected) > 1
    assert moves.sum() >= 3
    # Whole grey levels leave a twentieth of a pixel.
    assert np.abs((moved - still) - expected)[:, moves].max() < 0.2


def test_the_grid_turns_clockwise_with_the_pad():
    turned = replace(MARKED, mounting=Mounting(turn_rad=0.05))
    right, was = (
        points[:, np.argmin(np.abs(points - [[180], [112]]).sum(0))]
        for points in (resting_dots(DOTS, turned)[0], resting_dots(DOTS, MARKED)[0])
    )
    arm_mm = (was[0] - 111.5) * MARKED.mm_per_px_x
    assert right[1] - was[1] == pytest.approx(np.sin(0.05) * arm_mm / MARKED.mm_per_px_y, abs=0.05)


def test_a_marked_gel_is_solved_with_friction_and_keeps_its_truth_to_itself():
    marked = Scene(Body("key"), SLIDE, Motion.RIGHT, optics=MARKED)
    bare = replace(marked, optics=replace(MARKED, markers=None))
    dotted, plain = (simulate([scene], seed=1, with_drift=True)[0] for scene in (marked, bare))
    undrifted = simulate([marked], seed=1)[0]
    assert "frictional_contact" in undrifted.timing_ms
    assert undrifted.drift_px is None
    for name in ("displacement_px", "drift_px", "contact"):
        assert np.array_equal(getattr(dotted, name), getattr(plain, name))
