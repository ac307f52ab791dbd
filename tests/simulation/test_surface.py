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


def test_the_object_nowhere_reaches_through_the_surface():
    made = pressed(dome=0.0)
    assert np.all(made.indentation_mm[0] >= rigid(0.6) - 1e-5)


def test_the_surface_lies_on_the_object_exactly_where_it_touches():
    made = pressed(dome=0.0)
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


def test_pressing_deeper_touches_more():
    shares = pressed("ball_medium", depth=(0.2, 0.5, 0.9)).touches.mean(axis=(1, 2))
    assert np.all(np.diff(shares) > 0)


def test_a_crowned_pad_is_touched_less_away_from_its_crown():
    flat, crowned = (pressed("ball_medium", x=6.0, dome=dome).touches.mean() for dome in (0.0, 1.3))
    assert crowned < 0.9 * flat


@pytest.mark.parametrize("count", [32, 48, 129])
@pytest.mark.parametrize("power", [0, 1, 2])
def test_from_cells_to_pixels_a_parabola_stays_exact(power, count):
    # Cubic convolution with a = -1/2 reproduces polynomials up to the second degree (Keys 1981).
    cells = (np.arange(count) - (count - 1) / 2) * BOX_MM / count
    pixels = (np.arange(224) - 111.5) * OPTICS.mm_per_px_x
    values = _cubic_weights(OPTICS.mm_per_px_x, count).numpy() @ cells**power
    assert values == pytest.approx(pixels**power, abs=1e-4)
