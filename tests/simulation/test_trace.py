"""What can be seen of a motion, on pictures whose slopes are known."""

import numpy as np
import pytest

from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.simulation.idle import MEASURED_IDLE
from geotlm_lm.simulation.optics import lit
from geotlm_lm.simulation.randomise import random_scenes
from geotlm_lm.simulation.scene import Body, Optics, Path, Scene
from geotlm_lm.simulation.simulate import simulate
from geotlm_lm.simulation.trace import Contact, image_change, motion_at_contact, shading_change


def scene(**path):
    still = {"depth_mm": (0.5, 0.5), "x_mm": (0, 0), "y_mm": (0, 0), "rotation_rad": (0, 0)}
    return Scene(Body("block"), Path(**still | path), Motion.STILL, optics=Optics(0.1, 0.05))


@pytest.mark.parametrize("turn", [0.3, -0.5])
def test_a_contact_beside_the_middle_is_carried_as_the_rotation_matrix_says(turn):
    contact = np.zeros((224, 224), bool)
    contact[20:60, 150:180] = True  # 2 mm high, 3 mm wide
    here = np.array([(165 - 112) * 0.1, (40 - 112) * 0.05])
    first, last = np.array([1.0, -2.0]), np.array([1.5, -0.5])
    path = {"x_mm": (1.0, 1.5), "y_mm": (-2.0, -0.5), "rotation_rad": (0.4, 0.4 + turn)}
    touched = Contact.of(scene(**path), contact)
    *moved, turn_rad = motion_at_contact(scene(**path), touched.middle_mm, 1)
    arc = turn_rad * touched.radius_mm
    back = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    assert moved == pytest.approx(here - first - back @ (here - last), abs=1e-3)
    assert arc == pytest.approx(turn * np.hypot(2, 3) / 12**0.5, rel=1e-3)


def test_the_estimated_change_is_near_the_pictures():
    scenes = random_scenes(2, 12, objects=("hex_nut", "letter_l"), motions=DIRECTED)
    whole, bare = (simulate(scenes, seed=2, with_frames=wanted) for wanted in (True, False))
    ratios = [
        other.trace_until(3).change_grey / one.trace_until(3).change_grey
        for one, other in zip(whole, bare, strict=True)
    ]
    assert 0.8 < np.median(ratios) < 1.25
    assert min(ratios) > 0.5
    assert max(ratios) < 2.2


@pytest.mark.parametrize("slope", [(0.5, 0.0), (0.3, -0.6), (-1.0, 0.2)])
def test_of_a_plane_on_an_even_gel_the_estimated_change_is_the_pictures(slope):
    optics = Optics(psf_mm=0.0, steep_darkening=0.3, saturation=1.2)
    axis = (np.arange(224) - 111.5).astype(np.float32)
    across, down = axis * optics.mm_per_px_x, axis[:, None] * optics.mm_per_px_y
    depths = np.stack([np.full((224, 224), 0.5), slope[0] * across + slope[1] * down])
    depths = depths.astype(np.float32)
    where = np.zeros((224, 224), bool)
    where[90:130, 90:130] = True
    levels = MEASURED_IDLE[:, 1:-1, 1:-1].mean(axis=(1, 2))[:, None, None]
    even = np.broadcast_to(levels, (3, 224, 224)).astype(np.float32)
    drawn = image_change(*(lit(depth, even, optics) for depth in depths), where)
    estimated = shading_change(optics, depths, np.stack([where, where]), 1)
    assert estimated == pytest.approx(drawn, rel=1e-4)
