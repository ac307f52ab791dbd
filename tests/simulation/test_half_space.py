"""Expected values: Love's and Cerruti's closed forms (Johnson, Contact Mechanics, 3.2 and 3.6)."""

import numpy as np
import pytest
import torch

from geotlm_lm.simulation.half_space import HalfSpaceOperator
from geotlm_lm.simulation.march import cell_centres

SIDE, BOX = 33, 6.6


def operator(nu):
    return HalfSpaceOperator(SIDE, BOX, poisson_ratio=nu)


def square(width_cells):
    load = torch.zeros(1, SIDE, SIDE, dtype=torch.float64)
    low = (SIDE - width_cells) // 2
    load[:, low : low + width_cells, low : low + width_cells] = 1
    return load


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_a_uniform_square_sinks_as_love_says(nu):
    # In the middle of a square of side L: (1 - nu) p / (2 pi G) * 4 L ln(1 + sqrt 2).
    width = 11 * BOX / SIDE
    sunk = operator(nu).press(square(11))[0, SIDE // 2, SIDE // 2]
    expected = (1 - nu) / (2 * np.pi) * 4 * width * np.log(1 + np.sqrt(2))
    assert float(sunk) == pytest.approx(expected, rel=1e-12)


def test_far_from_a_load_only_its_force_counts():
    nu, cell = 0.3, BOX / SIDE
    force = cell**2
    x, y = cell_centres(SIDE, cell, torch.float64)
    r = torch.hypot(x, y)
    far = r > 15 * cell
    load = square(1)
    sunk = operator(nu).press(load)[0][far]
    assert sunk.numpy() == pytest.approx(
        ((1 - nu) * force / (2 * np.pi * r[far])).numpy(), rel=2e-3
    )
    drawn = operator(nu).spread(load)[0, 0][far]
    expected = -(1 - 2 * nu) * force * x[far] / (4 * np.pi * r[far] ** 2)
    assert drawn.numpy() == pytest.approx(expected.numpy(), rel=2e-3, abs=1e-9)
    drag = torch.stack([load, 0 * load], dim=1)
    along = operator(nu).shear(drag)[0, 0][far]
    expected = force / (2 * np.pi * r[far]) * ((1 - nu) + nu * x[far] ** 2 / r[far] ** 2)
    assert along.numpy() == pytest.approx(expected.numpy(), rel=2e-3)


def test_what_drag_lifts_pressure_spreads():
    generator = torch.Generator().manual_seed(0)
    pressure = torch.randn(1, SIDE, SIDE, generator=generator, dtype=torch.float64)
    traction = torch.randn(1, 2, SIDE, SIDE, generator=generator, dtype=torch.float64)
    lifted = (operator(0.2).bulge(traction) * pressure).sum()
    spread = (operator(0.2).spread(pressure) * traction).sum()
    assert float(lifted) == pytest.approx(float(spread), rel=1e-10)


def test_an_incompressible_half_space_does_not_couple():
    assert float(operator(0.5).spread(square(5)).abs().max()) < 1e-15
