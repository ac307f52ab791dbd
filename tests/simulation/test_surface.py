"""Laws of a pressed surface."""

import numpy as np

from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation import surface
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import Body, Gel, Optics, Path, Scene
from geotlm_lm.simulation.surface import pressed_surface

OPTICS = Optics()


def pressed(depth=(0.6,), body="letter_l", dome=0.0, **gel):
    body = Body(body, variant=2)
    path = Path(depth, *((at,) * len(depth) for at in (0.0, 0.0, 0.3)))
    scene = Scene(body, path, Motion.PRESS, Gel(dome=dome, **gel), OPTICS)
    return pressed_surface(scene, build_profile(body))


def rigid(depth):
    """Return how deep the object reaches below a flat pad, at every pixel."""
    pixels = (OPTICS.mm_per_px_x, OPTICS.mm_per_px_y)
    profile, pose = build_profile(Body("letter_l", variant=2)), (0.0, 0.0, 0.3)
    height = profile.sample(pose, pixels, 224)
    # As it is sampled for the surface: on a wall, a part is up to 40 um off the whole.
    window = profile.window(pose, pixels, 224, 1.4 * depth + 0.05)
    height[window.slices] = profile.sample(pose, pixels, 224, window)
    return depth - height


def test_the_surface_lies_on_the_object_exactly_where_it_touches_and_never_behind():
    made = pressed()
    assert np.all(made.indentation_mm[0] >= rigid(0.6) - 1e-5)
    gap = made.indentation_mm[0] - rigid(0.6)
    assert gap[made.touches[0]].max() <= 0.0201
    assert gap[~made.touches[0]].min() >= 0.0199
    assert 0.01 < made.touches.mean() < 0.5


def test_a_smooth_body_needs_no_finer_profile_than_the_cells_hold(monkeypatch):
    smooth = pressed(body="ball_medium", dome=1.0)
    monkeypatch.setattr(surface, "holds_detail", lambda *_: False)
    fine = pressed(body="ball_medium", dome=1.0)
    assert not np.array_equal(smooth.indentation_mm, fine.indentation_mm)
    assert np.abs(smooth.indentation_mm - fine.indentation_mm).max() < 0.006
    differ = (smooth.touches != fine.touches).sum()
    assert differ < 0.03 * fine.touches.sum()


def test_the_coat_smooths_the_gel_beside_the_object_and_neither_contact_nor_volume():
    plain, smooth = pressed(), pressed(membrane_mm=0.3)
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
    late, at_once = pressed(depth, lag=lag), pressed(depth)
    first = at_once.indentation_mm[0]
    raised = first > 0
    assert np.array_equal(late.indentation_mm[0], first)
    for frame, share in ((1, lag), (2, lag**2)):
        assert not at_once.indentation_mm[frame].any()
        # Where the gel is pushed up it springs back at once: only what is pressed in stays.
        assert np.allclose(late.indentation_mm[frame][raised], share * first[raised], atol=1e-6)
    assert np.all(late.indentation_mm[3] >= first)
    assert np.array_equal(late.touches, at_once.touches)
