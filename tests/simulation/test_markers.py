"""Dots are printed on the gel: they stand where its points have been carried."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.label import patch_means
from geotlm_lm.simulation.markers import resting_px, shade
from geotlm_lm.simulation.presets import preset_named
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import Body, Markers, Mounting, Optics, Path, Scene
from geotlm_lm.simulation.simulate import simulate
from geotlm_lm.simulation.surface import pressed_surface

DOTS = Markers()
MARKED = Optics(markers=DOTS, noise_grey=(0.0,) * 3, drift_grey=0.0)
UNLIT = replace(MARKED, light_gain=(0.0,) * 3, depth_gain=(0.0,) * 3)
PIXEL_MM = np.array([[MARKED.mm_per_px_x], [MARKED.mm_per_px_y]])
SLIDE = Path((0.6, 0.6), (0.0, 0.4), (0.0, 0.15), (0.3, 0.3))


def centroids(dark, near_px, reach=10):
    """Return where the darkness within `reach` of each point has its middle, (2, n)."""
    found = []
    for x, y in near_px.T:
        columns = np.arange(int(x) - reach, int(x) + reach + 2)
        rows = np.arange(int(y) - reach, int(y) + reach + 2)
        window = dark[np.ix_(rows, columns)]
        found.append([window.sum(0) @ columns, window.sum(1) @ rows] / window.sum())
    return np.array(found).T


def between_pixels(field, points):
    """Return a field (2, 224, 224) at points (2, n): bilinear, by OpenCV."""
    x, y = points.astype(np.float32)[:, None]
    planes = [cv2.remap(plane.astype(np.float32), x, y, cv2.INTER_LINEAR) for plane in field]
    return np.concatenate(planes)


def well_inside(points):
    return points[:, (np.abs(points - 111.5) < 90).all(axis=0)]


def test_dots_at_rest_lie_on_the_grid_to_a_hundredth_of_a_pixel():
    rest = well_inside(resting_px(DOTS, MARKED))
    assert rest.shape[1] > 30
    assert np.abs(centroids(1 - shade(DOTS, MARKED), rest) - rest).max() < 0.01


def test_a_dot_is_as_wide_and_as_dark_as_asked_for():
    wide = replace(DOTS, spacing_mm=8.0, diameter_mm=2.0)
    row = 1 - shade(wide, replace(MARKED, mm_per_px_x=0.02, mm_per_px_y=0.02))[111]
    middle = row.max()
    assert middle == pytest.approx(DOTS.darkness * (1 - np.exp(-3)), abs=0.001)
    # Half of what the flat-topped dot swallows at most, counted in pixels of 0.02 mm.
    assert (row > 0.5 * DOTS.darkness).sum() * 0.02 == pytest.approx(2.0, abs=0.05)


def test_in_a_clip_the_dots_go_where_its_truth_says_the_gel_goes():
    scene = Scene(Body("ball_medium"), SLIDE, Motion.RIGHT, optics=UNLIT)
    (made,) = simulate([scene], seed=3, with_drift=True)
    surface = pressed_surface(
        scene, build_profile(scene.body), preset_named("fast"), with_drift=True
    )
    dense = surface.drift_mm[1] / PIXEL_MM[..., None]
    assert np.allclose(np.moveaxis(made.drift_px[1], -1, 0), patch_means(dense), atol=1e-4)
    light = made.clip.background.astype(float)
    # Without light and noise nothing but the dots differs from an unmarked gel.
    plain = replace(scene, optics=replace(UNLIT, markers=None))
    bare = simulate([plain], seed=3)[0].clip.background
    rest = well_inside(resting_px(DOTS, UNLIT))
    expected = between_pixels(dense, rest)
    still = centroids((1 - light / bare).mean(axis=-1).clip(0), rest)
    moved = centroids((1 - made.clip.frames[1] / bare).mean(axis=-1).clip(0), rest + expected)
    moves = np.hypot(*expected) > 1
    assert moves.sum() >= 3
    # Whole grey levels leave a twentieth of a pixel.
    assert np.abs((moved - still) - expected)[:, moves].max() < 0.2


def test_a_dot_between_two_pixels_of_a_uniform_drift_moves_by_exactly_that():
    drift = np.ones((2, 224, 224), np.float32) * np.array([0.137, -0.071])[:, None, None]
    rest = well_inside(resting_px(DOTS, MARKED))
    moved = rest + np.array([[0.137 / MARKED.mm_per_px_x], [-0.071 / MARKED.mm_per_px_y]])
    found = centroids(1 - shade(DOTS, MARKED, drift.astype(np.float32)), moved)
    assert np.abs(found - moved).max() < 0.01


def test_the_grid_turns_clockwise_with_the_pad():
    turned = replace(MARKED, mounting=Mounting(turn_rad=0.05))
    right = (lambda points: points[:, np.argmin(np.abs(points - [[180], [112]]).sum(0))])(
        resting_px(DOTS, turned)
    )
    plain = resting_px(DOTS, MARKED)
    was = plain[:, np.argmin(np.abs(plain - [[180], [112]]).sum(0))]
    arm_mm = (was[0] - 111.5) * MARKED.mm_per_px_x
    assert right[1] - was[1] == pytest.approx(np.sin(0.05) * arm_mm / MARKED.mm_per_px_y, abs=0.05)


def test_a_marked_gel_is_solved_with_friction_and_keeps_its_truth_to_itself():
    marked = Scene(Body("key"), SLIDE, Motion.RIGHT, optics=MARKED)
    bare = replace(marked, optics=replace(MARKED, markers=None))
    one, other = (simulate([scene], seed=1, with_drift=True)[0] for scene in (marked, bare))
    assert "frictional_contact" in simulate([marked], seed=1)[0].stages
    assert simulate([marked], seed=1)[0].drift_px is None
    assert np.array_equal(one.displacement_px, other.displacement_px)
    assert np.array_equal(one.drift_px, other.drift_px)
    assert np.array_equal(one.contact, other.contact)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"spacing_mm": 0.0}, "markers' spacing is 0, expected 0.3 to 100 mm"),
        ({"darkness": 1.5}, "markers' darkness is 1.5, expected 0 to 1"),
        ({"diameter_mm": float("nan")}, "markers' diameter is nan, expected 0.01 to 10 mm"),
    ],
)
def test_dots_that_cannot_be_printed_are_refused(values, says):
    with pytest.raises(ValueError, match=says):
        Markers(**values)
