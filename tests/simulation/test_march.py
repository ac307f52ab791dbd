"""Closed forms of contact mechanics on the half-space, and the orders of the grid's convergence.

The formulas and their set-up are the closed-forms report's own; laws are stated here.
"""

import numpy as np
import pytest
import torch

from geotlm_lm.experiments.closed_forms import (
    measured_order,
    mirrored_twist,
    other_length,
    other_modulus,
)
from geotlm_lm.experiments.contact_cases import problems
from geotlm_lm.experiments.contact_problems import MU, lopsided, marched, pad, turn
from geotlm_lm.simulation.march import TIGHT, Increment, cell_centres, march, rigid_travel

GRIDS = (16, 32, 64)
PROBLEMS = problems()


def errors(name, quantity, sizes=GRIDS):
    problem = PROBLEMS[name]
    return [problem.quantities[quantity].error_of(problem.solve(size)) for size in sizes]


def order(errors):
    return measured_order(GRIDS, errors)


def test_hertz_force_converges_with_order_two():
    found = errors("pressed ball", "force")
    assert abs(found[-1]) < 5e-4
    assert order(found) > 1.7


def test_hertz_pressure_converges_with_order_one():
    found = errors("pressed ball", "pressure, L2")
    assert found[-1] < 0.012
    assert order(found) > 0.9


def test_flat_punch_force_converges_with_order_one():
    found = errors("flat punch", "force")
    assert abs(found[-1]) < 0.012
    assert order(found) > 0.8


@pytest.mark.parametrize("share", ["c = 0.6 a", "Q = 0.3 mu P"])
def test_a_slid_ball_follows_cattaneo_and_mindlin(share):
    problem = PROBLEMS[f"slid ball, {share}"]
    solutions = [problem.solve(side) for side in GRIDS]
    drag, stick = (problem.quantities[name].error_of for name in ("drag", "stick radius"))
    for solved in solutions:
        assert abs(stick(solved)) < solved.response.cell_mm / 2
    found = [drag(solved) for solved in solutions]
    assert abs(found[-1]) < 1e-3
    assert order(found) > 1.7


def test_unloading_follows_mindlin_and_deresiewicz():
    """Going back by the whole travel slips a new ring, at twice the friction, inwards."""
    (left,) = errors("ball slid and back", "drag / mu P", (48,))
    assert abs(left) < 3e-3


@pytest.mark.parametrize("nu", ["nu 0", "nu 0.49"])
def test_a_twisted_ball_follows_lubkin(nu):
    found = errors(f"twisted ball, c = 0.6 a, {nu}", "moment")
    assert abs(found[-1]) < 1e-3
    assert order(found) > 1.7


def test_a_ball_that_slips_all_over_resists_with_the_full_moment():
    found = errors("ball that slips all over", "moment")
    assert abs(found[-1]) < 1e-3
    assert order(found) > 1.5


def test_a_stuck_disc_resists_a_turn_as_reissner_and_sagoci_say():
    found = errors("stuck disc, turned", "moment")
    assert abs(found[-1]) < 0.025
    assert order(found) > 0.9


def test_a_mirrored_twist_leaves_the_mirrored_surface():
    assert mirrored_twist() < 1e-6


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


def test_a_stiffer_gel_moves_alike():
    """Under displacement control the modulus drops out of what is seen."""
    assert other_modulus() < 1e-6


def test_a_larger_gel_moves_in_proportion():
    # The solver stops at lengths of its own, so that only its tolerance, 1e-7, is common.
    assert other_length() < 1e-5


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


def test_shorter_steps_converge_with_order_one():
    counts = (4, 8, 16)
    found = errors("lopsided body twisted on a pad", "drift, L2", counts)
    assert measured_order(counts, found) > 0.8


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
