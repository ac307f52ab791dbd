"""Laws of a pressed surface, and the closed form of cubic interpolation."""

import numpy as np
import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation import surface
from geotlm_lm.simulation.contact import BOX_MM
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import Body, Gel, Optics, Path, Scene
from geotlm_lm.simulation.surface import _cubic_weights, pressed_surface

OPTICS = Optics()


def pressed(body="letter_l", depth=(0.6,), x=0.0, dome=1.0):
    body, count = Body(body, variant=2), len(depth)
    path = Path(depth, (x,) * count, (0.0,) * count, (0.3,) * count)
    profile = build_profile(body)
    return pressed_surface(Scene(body, path, Motion.PRESS, Gel(dome=dome), OPTICS), profile)


def rigid(depth, x=0.0):
    """Return how deep the object reaches below a flat pad, at every pixel."""
    pixels = (OPTICS.mm_per_px_x, OPTICS.mm_per_px_y)
    profile, pose = build_profile(Body("letter_l", variant=2)), (x, 0.0, 0.3)
    height = profile.sample(pose, pixels, 224)
    # As it is sampled for the surface: on a wall, a part is up to 40 um off the whole.
    window = profile.window(pose, pixels, 224, 1.4 * depth + 0.05)
    height[window.slices] = profile.sample(pose, pixels, 224, window)
    return depth - height


def test_the_surface_lies_on_the_object_exactly_where_it_touches_and_never_behind():
    made = pressed(dome=0.0)
    assert np.all(made.indentation_mm[0] >= rigid(0.6) - 1e-5)
    gap = made.indentation_mm[0] - rigid(0.6)
    assert gap[made.touches[0]].max() <= 0.0201
    assert gap[~made.touches[0]].min() >= 0.0199
    assert 0.01 < made.touches.mean() < 0.5


def test_a_smooth_body_needs_no_finer_profile_than_the_cells_hold(monkeypatch):
    smooth = pressed("ball_medium")
    monkeypatch.setattr(surface, "holds_detail", lambda *_: False)
    fine = pressed("ball_medium")
    assert not np.array_equal(smooth.indentation_mm, fine.indentation_mm)
    assert np.abs(smooth.indentation_mm - fine.indentation_mm).max() < 0.006
    differ = (smooth.touches != fine.touches).sum()
    assert differ < 0.03 * fine.touches.sum()


def test_a_frame_before_the_touch_is_exactly_flat():
    made = pressed(depth=(-0.1, 0.0, 0.5))
    assert not made.indentation_mm[:2].any()
    assert not made.touches[:2].any()
    assert made.touches[2].any()


@pytest.mark.parametrize(("power", "count"), [(0, 32), (1, 48), (2, 129)])
def test_from_cells_to_pixels_a_parabola_stays_exact(power, count):
    # Cubic convolution with a = -1/2 reproduces polynomials up to the second degree (Keys 1981).
    cells = (np.arange(count) - (count - 1) / 2) * BOX_MM / count
    pixels = (np.arange(224) - 111.5) * OPTICS.mm_per_px_x
    values = _cubic_weights(OPTICS.mm_per_px_x, count).numpy() @ cells**power
    assert values == pytest.approx(pixels**power, abs=1e-4)


def gel_with(depth, **values):
    body = Body("letter_l", variant=2)
    path = Path(depth, *((at,) * len(depth) for at in (0.0, 0.0, 0.3)))
    scene = Scene(body, path, Motion.PRESS, Gel(dome=0.0, **values), OPTICS)
    return pressed_surface(scene, build_profile(body))


def test_the_coat_smooths_the_gel_beside_the_object_and_neither_contact_nor_volume():
    plain, smooth = gel_with((0.6,)), gel_with((0.6,), membrane_mm=0.3)
    assert np.array_equal(plain.touches, smooth.touches)
    assert np.all(smooth.indentation_mm[0] >= rigid(0.6) - 1e-5)
    change = np.abs(smooth.indentation_mm - plain.indentation_mm)[0]
    assert change[~plain.touches[0]].max() > 0.02
    # Where it stays on the object the surface is the object's, to the tolerance of touching.
    held = plain.touches[0] & (rigid(0.6) >= smooth.indentation_mm[0] - 1e-6)
    assert held.sum() > 0.3 * plain.touches[0].sum()
    assert change[held].max() <= 0.0201


def test_a_gel_that_lags_keeps_its_share_of_what_the_object_left():
    depth, lag = (0.6, -1.0, -1.0, 0.6), 0.25
    late, at_once = gel_with(depth, lag=lag), gel_with(depth)
    first = at_once.indentation_mm[0]
    raised = first > 0
    assert np.array_equal(late.indentation_mm[0], first)
    for frame, share in ((1, lag), (2, lag**2)):
        assert not at_once.indentation_mm[frame].any()
        # Where the gel is pushed up it springs back at once: only what is pressed in stays.
        assert np.allclose(late.indentation_mm[frame][raised], share * first[raised], atol=1e-6)
    assert np.all(late.indentation_mm[3] >= first)
    assert np.array_equal(late.touches, at_once.touches)
