"""Closed forms of contact mechanics on the half-space, and the orders of the grid's convergence.

Hertz, Cattaneo-Mindlin, Lubkin and Jaeger, Reissner-Sagoci: Johnson, Contact Mechanics, 4 and 7.
"""

import math

import numpy as np
import pytest
import torch
from scipy.integrate import quad
from scipy.special import ellipe, ellipk

from geotlm_lm.simulation.elastic import LayerOperator
from geotlm_lm.simulation.half_space import HalfSpaceOperator
from geotlm_lm.simulation.march import TIGHT, Increment, cell_centres, march, rigid_travel

RADIUS, CONTACT, BOX, MU = 4.0, 1.0, 4.0, 0.5
DEPTH = CONTACT**2 / RADIUS
GRIDS = (16, 32, 64)


class Uncoupled(HalfSpaceOperator):
    """The half-space without the cross terms that the closed forms leave out."""

    def bulge(self, traction):
        return torch.zeros_like(traction[:, 0])

    def spread(self, pressure):
        return torch.zeros_like(pressure)[:, None].expand(-1, 2, -1, -1)


def hertz_force(nu):
    return 4 / 3 * 2 / (1 - nu) * math.sqrt(RADIUS) * DEPTH**1.5


def ball(side, body=Uncoupled, nu=0.3):
    response = body(side, BOX, poisson_ratio=nu)
    x, y = centres = cell_centres(side, response.cell_mm, torch.float64)
    overlap = (DEPTH - (x**2 + y**2) / (2 * RADIUS))[None]
    return response, centres, overlap


def turning(centres, angle):
    x, y = centres
    return torch.stack([-angle * y, angle * x])[None]


def sliding(centres, travel):
    return torch.stack([torch.full_like(centres[0], travel), torch.zeros_like(centres[0])])[None]


def marched(response, overlap, *travels, mu=MU):
    rest = torch.zeros(1, 2, *overlap.shape[1:], dtype=overlap.dtype)
    increments = [Increment(overlap, travel) for travel in (rest, *travels)]
    return list(march(increments, response, friction_coefficient=mu, effort=TIGHT))


def order(errors):
    """Return the mean order of convergence over successive doublings."""
    return math.log2(abs(errors[0] / errors[-1])) / (len(errors) - 1)


def test_hertz_force_converges_with_order_two():
    errors = []
    for side in GRIDS:
        response, _, overlap = ball(side)
        (step,) = marched(response, overlap)
        errors.append(float(step.force(response.cell_mm)[0, 2]) / hertz_force(0.3) - 1)
    assert abs(errors[-1]) < 5e-4
    assert order(errors) > 1.7


def test_hertz_pressure_converges_with_order_one():
    errors = []
    for side in GRIDS:
        response, (x, y), overlap = ball(side)
        (step,) = marched(response, overlap)
        peak = 3 * hertz_force(0.3) / (2 * math.pi * CONTACT**2)
        exact = peak * (1 - (x**2 + y**2) / CONTACT**2).clamp_min(0).sqrt()
        errors.append(float((step.pressure[0] - exact).norm() / exact.norm()))
    assert errors[-1] < 0.012
    assert order(errors) > 0.9


def test_flat_punch_force_converges_with_order_one():
    errors = []
    for side in GRIDS:
        response = Uncoupled(side, BOX, poisson_ratio=0.3)
        x, y = cell_centres(side, response.cell_mm, torch.float64)
        inside = x**2 + y**2 <= CONTACT**2
        overlap = torch.where(inside, 0.1, -1e3)[None].double()
        (step,) = marched(response, overlap)
        radius = response.cell_mm * math.sqrt(float(inside.sum()) / math.pi)
        exact = 2 * 2 / (1 - 0.3) * radius * 0.1
        errors.append(float(step.force(response.cell_mm)[0, 2]) / exact - 1)
    assert abs(errors[-1]) < 0.012
    assert order(errors) > 0.8


@pytest.mark.parametrize("share", [0.3, 0.784])
def test_a_sheared_ball_follows_cattaneo_and_mindlin(share):
    nu, errors = 0.0, []
    force = hertz_force(nu)
    travel = 3 * MU * force * (2 - nu) / (16 * CONTACT) * (1 - (1 - share) ** (2 / 3))
    for side in GRIDS:
        response, centres, overlap = ball(side, nu=nu)
        step = marched(response, overlap, sliding(centres, travel))[-1]
        errors.append(float(step.force(response.cell_mm)[0, 0]) / (MU * force * share) - 1)
        stick = response.cell_mm * math.sqrt(float(step.sticks.sum()) / math.pi)
        assert stick == pytest.approx((1 - share) ** (1 / 3) * CONTACT, abs=response.cell_mm)
    assert abs(errors[-1]) < 1e-3
    assert order(errors) > 1.7


def test_unloading_follows_mindlin_and_deresiewicz():
    """Going back by the whole travel slips a new ring, at twice the friction, inwards."""
    nu, share = 0.0, 0.6
    force = hertz_force(nu)

    def travel(part):
        return 3 * MU * force * 2 / (16 * CONTACT) * (1 - (1 - part) ** (2 / 3))

    response, centres, overlap = ball(48, nu=nu)
    back = 0.5
    # Drag after turning back by 2 * travel(back / 2): Q = share - back, in parts of mu P.
    path = (sliding(centres, travel(share)), sliding(centres, -2 * travel(back / 2)))
    step = marched(response, overlap, *path)[-1]
    drag = float(step.force(response.cell_mm)[0, 0]) / (MU * force)
    assert drag == pytest.approx(share - back, abs=3e-3)


def half_stuck_turn(nu, stick):
    """Return angle and moment at which a twisted ball sticks inside `stick` (Lubkin; Jaeger)."""
    force = hertz_force(nu)

    def shape(s):
        return ellipk(1 - s * s) - ellipe(1 - s * s)

    def angle(s):
        return 3 * MU * force / (4 * math.pi * CONTACT**2) * shape(s / CONTACT)

    ring, _ = quad(lambda s: s * s * angle(s), stick, CONTACT)
    return angle(stick), 16 / 3 * (stick**3 * angle(stick) + 3 * ring)


@pytest.mark.parametrize("nu", [0.0, 0.49])
def test_a_twisted_ball_follows_lubkin(nu):
    errors = []
    angle, moment = half_stuck_turn(nu, 0.6)
    for side in GRIDS:
        response, centres, overlap = ball(side, nu=nu)
        step = marched(response, overlap, turning(centres, angle))[-1]
        found = step.moment(response.cell_mm, torch.zeros(1, 2, dtype=torch.float64))
        errors.append(float(found) / moment - 1)
    assert abs(errors[-1]) < 1e-3
    assert order(errors) > 1.7


def test_a_ball_that_slips_all_over_resists_with_the_full_moment():
    errors = []
    angle, _ = half_stuck_turn(0.3, 0.6)
    for side in GRIDS:
        response, centres, overlap = ball(side)
        step = marched(response, overlap, turning(centres, 50 * angle))[-1]
        found = step.moment(response.cell_mm, torch.zeros(1, 2, dtype=torch.float64))
        errors.append(float(found) / (3 * math.pi * MU * hertz_force(0.3) * CONTACT / 16) - 1)
    assert abs(errors[-1]) < 1e-3
    assert order(errors) > 1.5


def test_a_stuck_disc_resists_a_turn_as_reissner_and_sagoci_say():
    errors, angle = [], 0.01
    for side in GRIDS:
        response = Uncoupled(side, BOX, poisson_ratio=0.3)
        x, y = centres = cell_centres(side, response.cell_mm, torch.float64)
        inside = x**2 + y**2 <= CONTACT**2
        overlap = torch.where(inside, 0.1, -1e3)[None].double()
        step = marched(response, overlap, turning(centres, angle), mu=1e6)[-1]
        found = step.moment(response.cell_mm, torch.zeros(1, 2, dtype=torch.float64))
        radius = response.cell_mm * math.sqrt(float(inside.sum()) / math.pi)
        errors.append(float(found) / (16 / 3 * radius**3 * angle) - 1)
    assert abs(errors[-1]) < 0.025


def pad(side=32, **options):
    size = {"thickness_mm": 4.0, "poisson_ratio": 0.48, "dtype": torch.float64}
    return LayerOperator(side, 16.0, **size | options)


def uneven(centres):
    x, y = centres
    return (0.5 - (x - 0.4) ** 2 / 12 - (y + 0.2) ** 2 / 7 + 0.05 * torch.cos(3 * x))[None]


def test_a_mirrored_twist_leaves_the_mirrored_surface():
    layer = pad()
    centres = cell_centres(32, layer.cell_mm, torch.float64)
    overlap, travel = uneven(centres), turning(centres, 0.05)
    sign = torch.tensor([-1.0, 1.0], dtype=torch.float64).view(1, 2, 1, 1)
    plain = marched(layer, overlap, travel)[-1]
    mirrored = marched(layer, overlap.flip(2), travel.flip(3) * sign)[-1]
    assert torch.allclose(mirrored.drift_mm.flip(3) * sign, plain.drift_mm, atol=1e-6)
    assert torch.allclose(mirrored.indentation_mm.flip(2), plain.indentation_mm, atol=1e-6)


def test_a_twist_clockwise_takes_the_top_to_the_right_and_the_right_down():
    layer = pad()
    centres = cell_centres(32, layer.cell_mm, torch.float64)
    zero = torch.zeros(1, dtype=torch.float64)
    travel = rigid_travel(
        centres, torch.zeros(1, 2).double(), zero + 0.03, torch.zeros(1, 2).double()
    )
    step = marched(layer, uneven(centres), travel)[-1]
    touched = step.pressure[0] > 0
    x, y = centres
    drift = step.drift_mm[0]
    assert float(drift[0][touched & (y < 0)].mean()) > 0
    assert float(drift[0][touched & (y > 0)].mean()) < 0
    assert float(drift[1][touched & (x > 0)].mean()) > 0


def test_a_stiffer_gel_moves_alike():
    """Under displacement control the modulus drops out of what is seen."""
    drifts = []
    for modulus in (1e-6, 1.0, 1e4):
        layer = pad(shear_modulus=modulus)
        centres = cell_centres(32, layer.cell_mm, torch.float64)
        drifts.append(marched(layer, uneven(centres), turning(centres, 0.05))[-1].drift_mm)
    for drift in drifts[1:]:
        assert torch.allclose(drift, drifts[0], atol=1e-5)


def test_work_is_stored_or_rubbed_away_and_none_comes_from_nothing():
    layer = pad()
    centres = cell_centres(32, layer.cell_mm, torch.float64)
    turns = [turning(centres, angle) for angle in (0.01,) * 6 + (-0.01,) * 6]
    steps = marched(layer, uneven(centres), *turns)
    spent = np.cumsum([float(step.work) for step in steps])
    stored = np.array([float(step.energy) for step in steps])
    rubbed = spent - stored
    assert rubbed[0] == pytest.approx(0, abs=2e-2 * stored[0])
    assert np.diff(rubbed).min() > -1e-3 * stored.max()
    assert rubbed[-1] > 0


def test_shorter_steps_converge_with_order_one():
    layer = pad()
    centres = cell_centres(32, layer.cell_mm, torch.float64)
    ends = []
    for count in (2, 4, 8, 32):
        turns = [turning(centres, 0.16 / count)] * count
        ends.append(marched(layer, uneven(centres), *turns)[-1].drift_mm)
    errors = [float((end - ends[-1]).norm() / ends[-1].norm()) for end in ends[:-1]]
    # Half a step halves the error; the finest one, no more than a reference, adds a little.
    assert order(errors) > 0.8


def test_a_cell_that_leaves_the_contact_is_released():
    layer = pad()
    centres = cell_centres(32, layer.cell_mm, torch.float64)
    pressed = uneven(centres)
    rest = torch.zeros(1, 2, 32, 32, dtype=torch.float64)
    path = [Increment(pressed, rest), Increment(pressed, turning(centres, 0.05))]
    path.append(Increment(pressed - 10, rest))
    *_, end = march(path, layer, friction_coefficient=MU, effort=TIGHT)
    assert not end.traction.any()
    assert float(end.drift_mm.abs().max()) < 1e-12
    assert float(end.indentation_mm.abs().max()) < 1e-12
