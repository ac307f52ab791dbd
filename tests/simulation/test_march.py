"""Laws of the march along a path: mirrors, scales, work, and release."""

import numpy as np
import pytest
import torch

from geotlm_lm.simulation.march import TIGHT, Increment, cell_centres, march, rigid_travel
from tests.simulation.contact_problems import MU, lopsided, marched, pad, turn

MIRROR = torch.tensor([-1.0, 1.0], dtype=torch.float64).view(1, 2, 1, 1)
"""What a mirror left to right does to a vector."""


def deviation(found, exact):
    return float((found - exact).abs().max() / exact.abs().max())


def twisted(modulus=1.0, scale=1.0):
    layer = pad(scale=scale, shear_modulus=modulus)
    return marched(layer, lopsided(layer, scale), turn(0.05)).end


def test_a_mirrored_twist_leaves_the_mirrored_surface():
    layer, plain = pad(), twisted()
    mirrored = marched(layer, lopsided(layer).flip(2), turn(-0.05)).end
    assert deviation(mirrored.drift_mm.flip(3) * MIRROR, plain.drift_mm) < 1e-6
    assert deviation(mirrored.indentation_mm.flip(2), plain.indentation_mm) < 1e-6


def test_a_twist_clockwise_takes_the_top_to_the_right_and_the_right_down():
    layer = pad()
    centres = cell_centres(32, layer.cell_mm, torch.float64)
    zero = torch.zeros(1, dtype=torch.float64)
    travel = rigid_travel(
        centres, torch.zeros(1, 2).double(), zero + 0.03, torch.zeros(1, 2).double()
    )
    step = marched(layer, lopsided(layer), lambda _: travel).end
    touched = step.pressure[0] > 0
    x, y = centres
    drift = step.drift_mm[0]
    assert float(drift[0][touched & (y < 0)].mean()) > 0
    assert float(drift[0][touched & (y > 0)].mean()) < 0
    assert float(drift[1][touched & (x > 0)].mean()) > 0


@pytest.mark.parametrize("modulus", [1e-6, 1e4])
def test_a_softer_or_stiffer_gel_moves_alike(modulus):
    """Under displacement control the modulus drops out of what is seen."""
    assert deviation(twisted(modulus=modulus).drift_mm, twisted().drift_mm) < 1e-6


def test_a_larger_gel_moves_in_proportion():
    # The solver stops at lengths of its own, so that only its tolerance, 1e-7, is common.
    assert deviation(twisted(scale=2.5).drift_mm / 2.5, twisted().drift_mm) < 1e-5


def test_work_is_stored_or_rubbed_away_and_none_comes_from_nothing():
    layer = pad()
    turns = [turn(angle) for angle in (0.01,) * 6 + (-0.01,) * 6]
    steps = marched(layer, lopsided(layer), *turns).steps
    spent = np.cumsum([float(step.work) for step in steps])
    stored = np.array([float(step.energy) for step in steps])
    rubbed = spent - stored
    assert rubbed[0] == pytest.approx(0, abs=2e-2 * stored[0])
    assert np.diff(rubbed).min() > -1e-3 * stored.max()
    assert rubbed[-1] > 0


def test_a_cell_that_leaves_the_contact_is_released():
    layer = pad()
    centres = cell_centres(32, layer.cell_mm, torch.float64)
    pressed = lopsided(layer)
    rest = torch.zeros(1, 2, 32, 32, dtype=torch.float64)
    path = [Increment(pressed, rest), Increment(pressed, turn(0.05)(centres))]
    path.append(Increment(pressed - 10, rest))
    *_, end = march(path, layer, friction_coefficient=MU, effort=TIGHT)
    assert not end.traction.any()
    assert float(end.drift_mm.abs().max()) < 1e-12
    assert float(end.indentation_mm.abs().max()) < 1e-12
