"""Every closed form at the sizes a test can afford, and the formulas against other sources.

Orders of convergence come from theory: 2 for forces of a pressure that ends smoothly, 1 for fields
and for what is singular at an edge, the difference of two terms of S_zz for thin layers.
"""

import math
from dataclasses import replace

import pytest
import torch
from scipy.integrate import quad
from scipy.special import ellipe, ellipk

from geotlm_lm.experiments import contact_theory as theory
from geotlm_lm.experiments.closed_forms import LAWS, closed_forms, measured_order
from geotlm_lm.experiments.contact_cases import problems
from geotlm_lm.experiments.contact_problems import CONTACT, MU, ball
from geotlm_lm.reports.simulator import closed_forms_table

PROBLEMS = problems()
QUANTITIES = [(name, one) for name, problem in PROBLEMS.items() for one in problem.quantities]
LARGEST = {"cells per side": 64, "contact radii per thickness": 64, "increments": 16}
MARGINS = {"exactly": (-0.3, 0.3), "at least": (-0.1, math.inf), "about": (-0.5, 1.0)}
"""Room for the order, by how the expected one is to be read; two thirds are used, measured."""


@pytest.fixture(scope="module")
def record():
    chosen = {
        name: replace(problem, sizes=[n for n in problem.sizes if n <= LARGEST[problem.unit]])
        for name, problem in PROBLEMS.items()
    }
    return closed_forms(chosen=chosen, laws={name: lambda: 1e-9 for name in LAWS})


def row(record, problem, quantity):
    rows = record.numbers["rows"]
    return next(r for r in rows if (r["problem"], r["quantity"]) == (problem, quantity))


@pytest.mark.parametrize(("problem", "quantity"), QUANTITIES)
def test_every_closed_form_is_met_at_the_expected_order(record, problem, quantity):
    own = row(record, problem, quantity)
    low, high = MARGINS[own["reading"]]
    assert low < own["order"] - own["expected_order"] < high


@pytest.mark.parametrize("problem", PROBLEMS)
def test_no_residual_is_near_the_error_it_measures(record, problem):
    residuals = next(r for r in record.numbers["rows"] if r["problem"] == problem)["residuals"]
    assert residuals["tension"] == 0
    assert residuals["penetration_um"] <= 1e-4
    assert residuals["complementarity"] < 1e-7
    assert residuals["gradient_share"] <= 1e-7
    assert residuals["cone_excess"] < 1e-12
    assert residuals["gained_work"] < 1e-7


RADII = [(name, one) for name, one in QUANTITIES if one.endswith("radius")]


@pytest.mark.parametrize(("problem", "quantity"), RADII)
def test_a_rim_is_where_it_should_be_within_half_a_cell(record, problem, quantity):
    own = row(record, problem, quantity)
    for size, error in zip(own["sizes"], own["errors"], strict=True):
        assert abs(error) * CONTACT < 2.0 / size


def test_every_quantity_and_law_has_its_line_in_the_table(record):
    text = closed_forms_table(record)
    for problem, quantity in QUANTITIES:
        assert text.count(f"| {problem}: {quantity} ") == 1
    for law in LAWS:
        assert f"| {law} " in text
    assert " >= 2 |" in text


@pytest.mark.parametrize("law", LAWS)
def test_every_law_holds(law):
    assert LAWS[law]() < 1e-5


def test_the_order_is_the_slope_whatever_the_sign():
    sizes = (8, 12, 30)
    assert measured_order(sizes, [-3.0 * size**-1.5 for size in sizes]) == pytest.approx(1.5)


def test_a_solution_has_no_residuals_and_what_pulls_or_presses_on_air_has():
    solved = ball(16)
    assert max(solved.residuals().values()) < 1e-9

    def residuals(more):
        step = replace(solved.end, pressure=solved.end.pressure + more)
        return replace(solved, steps=[step]).residuals()

    assert residuals(-0.1)["tension"] > 0.01
    assert residuals(0.1)["complementarity"] > 0.01


@pytest.mark.parametrize("s", [0.01, 0.3, 0.6, 1.0])
def test_lubkins_shape_is_the_difference_of_the_elliptic_integrals(s):
    expected = ellipk(1 - s * s) - ellipe(1 - s * s)
    assert theory.lubkin_shape(s) == pytest.approx(expected, rel=1e-11, abs=1e-14)


def test_lubkins_moment_ends_at_the_sliding_moment():
    # The integral of s^2 H(s) from 0 to 1 is pi^2 / 64.
    assert theory.lubkin_moment(0.01, 0.3) == pytest.approx(theory.sliding_moment(0.3), rel=1e-4)


def test_a_barely_slipping_ball_resists_a_turn_as_a_stuck_disc():
    # A turn too small to slip: M = 16/3 G a^3 theta of Reissner and Sagoci, shared by both.
    stick = 0.99
    stuck = theory.stuck_moment(CONTACT, theory.lubkin_angle(stick, 0.3))
    assert theory.lubkin_moment(stick, 0.3) == pytest.approx(stuck, rel=0.02)


def over_the_disc(field):
    """Integrate a field of the distance from the axis over the contact."""
    of = lambda r: float(field(torch.tensor(r, dtype=torch.float64)))  # noqa: E731
    return quad(lambda r: 2 * math.pi * r * of(r), 0, CONTACT, limit=200)[0]


def test_hertz_pressure_adds_up_to_the_force():
    total = over_the_disc(lambda r: theory.hertz_pressure(r, 0.3))
    assert total == pytest.approx(theory.hertz_force(0.3), rel=1e-6)


@pytest.mark.parametrize("share", [0.3, 0.784])
def test_mindlins_traction_adds_up_to_its_share_of_the_friction(share):
    total = over_the_disc(lambda r: theory.mindlin_traction(r, share, 0.0))
    assert total == pytest.approx(share * MU * theory.hertz_force(0.0), rel=1e-6)


def test_the_thin_film_pressure_adds_up_to_the_incompressible_layers_force():
    # p = a^4 / (32 R) 3 G / h^3 (1 - r^2 / a^2)^2 solves the thin-film equation.
    thickness, radius = 0.1, 4.0
    peak = CONTACT**4 / (32 * radius) * 3 / thickness**3
    total = over_the_disc(lambda r: peak * (1 - r**2 / CONTACT**2) ** 2)
    assert total == pytest.approx(theory.incompressible_layer_force(thickness), rel=1e-9)
