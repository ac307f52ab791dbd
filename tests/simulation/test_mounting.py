"""Law: turning the camera turns image and truth together; a quarter turn is exact on the grid."""

from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.contact import dome_drop_mm, dome_mm
from geotlm_lm.simulation.idle import idle_frame
from geotlm_lm.simulation.optics import lit
from geotlm_lm.simulation.presets import preset_named
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.randomise_optics import random_optics
from geotlm_lm.simulation.scene import Body, Gel, Mounting, Optics, Path, Scene
from geotlm_lm.simulation.simulate import simulate
from geotlm_lm.simulation.surface import pressed_surface

SQUARE = Optics(mm_per_px_x=0.08, mm_per_px_y=0.08, shadow=0.0)
QUARTER = np.pi / 2
PLAIN = Scene(
    Body("ball_medium"),
    Path((0.6, 0.6), (1.0, 1.5), (-0.4, 0.2), (0.2, 0.35)),
    Motion.RIGHT,
    optics=SQUARE,
)


def turned(scene):
    """Return the scene a quarter turn clockwise in the image: x to y, y to -x."""
    path = scene.path
    path = replace(
        path,
        x_mm=tuple(-y for y in path.y_mm),
        y_mm=path.x_mm,
        rotation_rad=tuple(turn + QUARTER for turn in path.rotation_rad),
    )
    optics = replace(scene.optics, mounting=Mounting(turn_rad=QUARTER))
    return replace(scene, path=path, optics=optics)


def clockwise(images):
    return np.rot90(images, -1, axes=(-2, -1))


def test_truth_turns_with_the_camera():
    one, other = simulate([PLAIN, turned(PLAIN)], seed=1)
    # Measured: 3e-7 mm, by float32 transforms of a turned grid.
    assert np.allclose(clockwise(one.depth_mm), other.depth_mm, atol=1e-5)
    assert np.abs(clockwise(one.contact) - other.contact).max() < 0.005
    both = (clockwise(one.contact) > 0) & (other.contact > 0)
    moved = clockwise(np.moveaxis(one.displacement_px, -1, 0))
    assert both[1].sum() > 5
    assert np.allclose(-moved[1][both], other.displacement_px[..., 0][both], atol=1e-3)
    assert np.allclose(moved[0][both], other.displacement_px[..., 1][both], atol=1e-3)


def test_shading_turns_with_the_camera():
    grey = np.full((3, 224, 224), 100, np.float32)
    one, other = (
        pressed_surface(scene, build_profile(scene.body), preset_named("fast")).indentation_mm[1]
        for scene in (PLAIN, turned(PLAIN))
    )
    bright, again = lit(one, grey, SQUARE), lit(other, grey, turned(PLAIN).optics)
    change = np.abs(clockwise(bright) - again)
    assert np.abs(bright - 100).max() > 30
    assert change.max() < 0.01


def test_the_crown_turns_and_shifts_with_the_pad():
    gel, size = Gel(), (0.1, 0.1)
    plain = dome_mm(gel, size, 101)
    quarter = dome_mm(gel, size, 101, Mounting(turn_rad=QUARTER))
    assert np.allclose(quarter, np.rot90(plain, -1), atol=1e-6)
    shifted = dome_mm(gel, size, 101, Mounting(x_mm=0.5, y_mm=-0.3))
    assert np.unravel_index(shifted.argmin(), shifted.shape) == (47, 55)
    both = Mounting(turn_rad=0.4, x_mm=0.5, y_mm=-0.3)
    assert dome_drop_mm(gel, 2.0, 1.0, both) == pytest.approx(
        float(dome_mm(gel, size, 101, both)[60, 70]), abs=1e-6
    )


def test_the_idle_light_moves_with_the_pad():
    plain, right, low = (
        idle_frame(4, mounting)[0] for mounting in (None, Mounting(x_mm=0.8), Mounting(y_mm=0.8))
    )
    # Red is brightest inside the view: the side that the pad moves to brightens.
    assert (right - plain)[:, 112:].mean() > 1 > -1 > (right - plain)[:, :112].mean()
    assert (low - plain)[:112].mean() < -1


def test_the_mounting_of_a_flat_gel_changes_its_picture_and_nothing_of_its_truth():
    flat = replace(PLAIN, gel=Gel(dome=0.0))
    mounting = Mounting(turn_rad=np.radians(3), x_mm=0.5, y_mm=-0.5)
    other = replace(flat, optics=replace(SQUARE, mounting=mounting))
    one, two = simulate([flat], seed=2)[0], simulate([other], seed=2)[0]
    # The lights turn with the pad, and with them what they show of each component.
    assert replace(one.label, visible_grey=two.label.visible_grey) == two.label
    assert one.label.visible_grey == pytest.approx(two.label.visible_grey, rel=0.05)
    for name in ("displacement_px", "contact", "depth_mm"):
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes()
    assert np.any(one.clip.frames != two.clip.frames)


def test_appearance_changes_nothing_of_the_truth():
    for seed in range(4):
        drawn = random_optics(np.random.default_rng(seed))
        same = {"mm_per_px_x": 0.08, "mm_per_px_y": 0.08, "mounting": Mounting()}
        one, two = (
            simulate([PLAIN], seed=2)[0],
            simulate([replace(PLAIN, optics=replace(drawn, **same))], seed=2)[0],
        )
        for name in ("displacement_px", "contact", "depth_mm"):
            assert getattr(one, name).tobytes() == getattr(two, name).tobytes()
        seen = {"is_readable": True, "visible_grey": (0.0, 0.0, 0.0)}
        assert replace(one.label, **seen) == replace(two.label, **seen)
