"""The contact solver against every closed form it has: errors at each size, and their order.

Orders come from theory: 2 for forces of a pressure that ends smoothly, 1 for fields and for what is
singular at an edge, the next term of S_zz for thin layers. The largest errors are a quarter above
those measured; a rim is a staircase of cells, and counts as right within half of one.

Lengths are in mm and tractions in units of the shear modulus G, so that forces are in mm^2 and
moments in mm^3. a is the contact's radius, R the ball's, d the approach, nu Poisson's ratio, mu
Coulomb's coefficient, P the normal force. The chapters are those of Johnson, Contact Mechanics.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
import pytest
import torch
from scipy.integrate import quad
from scipy.special import ellipe, ellipk
from torch import Tensor

from tests.simulation.contact_problems import (
    BOX,
    CONTACT,
    DEPTH,
    DISC_DEPTH,
    MU,
    RADIUS,
    Solved,
    ball,
    disc,
    lopsided,
    marched,
    pad,
    slide,
    thin_layer,
    turn,
)


def hertz_force(nu: float) -> float:
    """Return P = 4/3 E* sqrt(R) d^(3/2) with E* = 2 G / (1 - nu) (Hertz; chapter 4)."""
    return 4 / 3 * 2 / (1 - nu) * math.sqrt(RADIUS) * DEPTH**1.5


def hertz_pressure(distance_mm: Tensor, nu: float) -> Tensor:
    """Return p = 3 P / (2 pi a^2) sqrt(1 - r^2 / a^2) at some distances from the axis."""
    return 3 * hertz_force(nu) / (2 * math.pi * CONTACT**2) * _dome(distance_mm, CONTACT)


def punch_force(radius_mm: float) -> float:
    """Return P = 2 E* a d of a flat disc (Boussinesq; chapter 3)."""
    return 2 * 2 / (1 - NU) * radius_mm * DISC_DEPTH


def mindlin_travel(share: float, nu: float) -> float:
    """Return the slide at which the drag is `share` of mu P (Cattaneo, Mindlin; chapter 7).

    3 mu P (2 - nu) / (16 G a) (1 - (1 - share)^(2/3)).
    """
    reach = 3 * MU * hertz_force(nu) * (2 - nu) / (16 * CONTACT)
    return reach * (1 - (1 - share) ** (2 / 3))


def mindlin_stick_radius(share: float) -> float:
    """Return c = a (1 - share)^(1/3), inside which a slid ball sticks."""
    return CONTACT * (1 - share) ** (1 / 3)


def mindlin_traction(distance_mm: Tensor, share: float, nu: float) -> Tensor:
    """Return q = mu p_0 (sqrt(1 - r^2 / a^2) - c / a sqrt(1 - r^2 / c^2)), along the slide.

    Exact for nu = 0 only: otherwise the slip has a part across the slide, which this leaves out.
    """
    stick = mindlin_stick_radius(share)
    stuck = stick / CONTACT * _dome(distance_mm, stick)
    peak = 3 * hertz_force(nu) / (2 * math.pi * CONTACT**2)
    return MU * peak * (_dome(distance_mm, CONTACT) - stuck)


def lubkin_angle(stick_mm: float, nu: float) -> float:
    """Return the turn 3 mu P / (4 pi G a^2) (K - E) at which a ball sticks inside c = `stick`.

    Complete elliptic integrals of k^2 = 1 - c^2 / a^2 (Lubkin 1951; Jaeger 1995).
    """
    m = 1 - (stick_mm / CONTACT) ** 2
    return 3 * MU * hertz_force(nu) / (4 * math.pi * CONTACT**2) * float(ellipk(m) - ellipe(m))


def lubkin_moment(stick_mm: float, nu: float) -> float:
    """Return M = 16/3 G (c^3 theta(c) + 3 int_c^a s^2 theta(s) ds) at that turn."""
    ring = quad(lambda s: s**2 * lubkin_angle(s, nu), stick_mm, CONTACT)[0]
    return 16 / 3 * (stick_mm**3 * lubkin_angle(stick_mm, nu) + 3 * ring)


def stuck_moment(radius_mm: float, angle_rad: float) -> float:
    """Return M = 16/3 G a^3 theta of a turned disc without slip (Reissner and Sagoci 1944)."""
    return 16 / 3 * radius_mm**3 * angle_rad


def stuck_drag(radius_mm: float, travel_mm: float) -> float:
    """Return Q = 8 G a x / (2 - nu) of a slid disc without slip (Mindlin 1949)."""
    return 8 * radius_mm * travel_mm / (2 - NU)


# Approach d of a ball on a layer with h << a.
COMPRESSIBLE_DEPTH, INCOMPRESSIBLE_DEPTH = CONTACT**2 / (2 * RADIUS), CONTACT**2 / (4 * RADIUS)


def compressible_layer_force(thickness_mm: float) -> float:
    """Return P = pi R d^2 / h * 2 G (1 - nu) / (1 - 2 nu), h << a (chapter 5)."""
    stiffness = 2 * (1 - NU) / (1 - 2 * NU) / thickness_mm
    return math.pi * RADIUS * COMPRESSIBLE_DEPTH**2 * stiffness


def incompressible_layer_force(thickness_mm: float) -> float:
    """Return P = 2 pi G R^2 d^3 / h^3, h << a (chapter 5).

    From -h^3 / (3 G) laplacian(p) = d - r^2 / (2 R) with p = p' = 0 at r = a.
    """
    return 2 * math.pi * RADIUS**2 * (INCOMPRESSIBLE_DEPTH / thickness_mm) ** 3


def _dome(distance_mm: Tensor, radius_mm: float) -> Tensor:
    return torch.sqrt((1 - (distance_mm / radius_mm) ** 2).clamp_min(0))


NU = 0.3  # Poisson's ratio, where the answer holds for any
STICK = 0.6  # radius that still sticks, in parts of the contact's: slip has come half way in
SHARE = 1 - STICK**3  # drag in parts of the friction at which a slid ball sticks inside that
THERE, BACK = 0.6, 0.5  # drag in parts of the friction that a ball is slid with and loses again
FRICTION = MU * hertz_force(0.0)
SLIDING_MOMENT = 3 * math.pi * MU * hertz_force(NU) * CONTACT / 16  # of a ball that slips all over
CELLS = (16, 32, 64)  # per side, where nothing else is said
# Contact radii per thickness of a thin layer: the formulas are for a >> h, and keep the first term
# of S_zz, whose next is (k h)^2 smaller.
RADII = (16, 32, 64)
EDGE = (0.04, 0.019, 9.4e-3)  # largest errors of forces on a disc, whose edge is singular


@dataclass(frozen=True)
class Quantity:
    """Solution -> signed relative error; the largest allowed at each size; the order expected.

    `at_least` where the staircase of the rim rules coarse grids: its part falls with order 2.5.
    """

    error_of: Callable[[Solved], float]
    largest: tuple[float, ...]
    order: float | None = None
    at_least: bool = False


@dataclass(frozen=True)
class Problem:
    """Size -> numerical solution, and what is held against a closed form."""

    solve: Callable[[int], Solved]
    quantities: dict[str, Quantity]
    sizes: tuple[int, ...] = CELLS


def of(name, exact, *largest, order=2, at_least=False):
    """Hold one number of a solution against a closed form, or one that depends on the solution."""

    def error(solved):
        expected = exact(solved) if callable(exact) else exact
        return getattr(solved, name) / expected - 1

    return {name: Quantity(error, largest, order, at_least)}


def radius(name, exact):
    return of(name, exact, *(BOX / cells / 2 / exact for cells in CELLS), order=None)


def off(found, exact):
    return float((found - exact).norm() / exact.norm())


def traction_error(share, solved):
    along = mindlin_traction(solved.distance_mm, share, 0.0)
    return off(solved.end.traction[0], torch.stack([along, torch.zeros_like(along)]))


def slid_ball(share, drag, traction):
    return Problem(
        lambda cells: ball(cells, slide(mindlin_travel(share, 0.0)), nu=0.0),
        of("drag", FRICTION * share, *drag, at_least=True)
        | {"traction": Quantity(partial(traction_error, share), traction, 1)}
        | radius("stick_radius", mindlin_stick_radius(share)),
    )


def twisted_ball(nu):
    exact = lubkin_moment(STICK, nu)
    return Problem(
        lambda cells: ball(cells, turn(lubkin_angle(STICK, nu)), nu=nu),
        of("moment", exact, 0.032, 3.5e-3, 8.5e-4, at_least=True) | radius("stick_radius", STICK),
    )


def returning_ball(cells):
    """Slide there and back; turned back, a new ring slips at twice the friction, inwards."""
    there, back = mindlin_travel(THERE, 0.0), 2 * mindlin_travel(BACK / 2, 0.0)
    return ball(cells, slide(there), slide(-back), nu=0.0)


def pressure_error(solved):
    return off(solved.end.pressure[0], hertz_pressure(solved.distance_mm, NU))


@cache
def twisted_body(increments):
    layer = pad()
    return marched(layer, lopsided(layer), *[turn(0.16 / increments)] * increments)


def path_error(solved):
    """Hold a path against twice as many increments: no closed form knows this history."""
    return off(solved.end.drift_mm, twisted_body(2 * (len(solved.steps) - 1)).end.drift_mm)


PROBLEMS = {
    "pressed ball, Hertz": Problem(
        lambda cells: ball(cells, nu=NU),
        of("force", hertz_force(NU), 8.2e-3, 2e-3, 4.3e-4)
        | {"pressure": Quantity(pressure_error, (0.052, 0.025, 0.011), 1)}
        | radius("contact_radius", CONTACT),
    ),
    "flat punch, Boussinesq": Problem(
        lambda cells: disc(cells, nu=NU),
        of("force", lambda s: punch_force(s.contact_radius), *EDGE, order=1),
    ),
    "slid ball, c = 0.6 a": slid_ball(SHARE, (0.014, 1.5e-3, 3.5e-4), (0.072, 0.037, 0.019)),
    "slid ball, Q = 0.3 mu P": slid_ball(0.3, (0.024, 2.2e-3, 6.2e-4), (0.22, 0.12, 0.048)),
    "ball slid and back, Mindlin and Deresiewicz": Problem(
        returning_ball, of("drag", FRICTION * (THERE - BACK), 0.093, 0.02, 3e-3, at_least=True)
    ),
    "twisted ball, nu 0, Lubkin": twisted_ball(0.0),
    "twisted ball, nu 0.49, Lubkin": twisted_ball(0.49),
    "ball that slips all over": Problem(
        lambda cells: ball(cells, turn(50 * lubkin_angle(STICK, NU)), nu=NU),
        of("moment", SLIDING_MOMENT, 0.013, 2.8e-3, 4.2e-4, at_least=True),
    ),
    "stuck disc, turned, Reissner and Sagoci": Problem(
        lambda cells: disc(cells, turn(0.01), nu=NU),
        of("moment", lambda s: stuck_moment(s.contact_radius, 0.01), 0.11, 0.052, 0.024, order=1),
    ),
    "stuck disc, slid, Mindlin": Problem(
        lambda cells: disc(cells, slide(0.01), nu=NU),
        of("drag", lambda s: stuck_drag(s.contact_radius, 0.01), *EDGE, order=1),
    ),
    "thin layer, nu 0.3": Problem(
        lambda radii: thin_layer(CONTACT / radii, COMPRESSIBLE_DEPTH, nu=NU),
        of("force", lambda s: compressible_layer_force(s.thickness_mm), 1.2e-3, 3.3e-4, 8.2e-5),
        sizes=RADII,
    ),
    "thin layer, nu 0.5": Problem(
        lambda radii: thin_layer(CONTACT / radii, INCOMPRESSIBLE_DEPTH, nu=0.5),
        of("force", lambda s: incompressible_layer_force(s.thickness_mm), 0.094, 0.025, 6.4e-3),
        sizes=RADII,
    ),
    "lopsided body twisted on a pad": Problem(
        twisted_body, {"drift": Quantity(path_error, (1.3e-3, 7.7e-4, 4e-4), 1)}, sizes=(4, 8, 16)
    ),
}


@cache
def solutions(name):
    return [PROBLEMS[name].solve(size) for size in PROBLEMS[name].sizes]


def measured_order(sizes, errors):
    return -float(np.polyfit(np.log(sizes), np.log(np.abs(errors)), 1)[0])


QUANTITIES = [
    (name, quantity) for name, problem in PROBLEMS.items() for quantity in problem.quantities
]


@pytest.mark.parametrize(("name", "quantity"), QUANTITIES)
def test_every_closed_form_is_met_at_each_size_and_at_its_order(name, quantity):
    own = PROBLEMS[name].quantities[quantity]
    errors = [own.error_of(solved) for solved in solutions(name)]
    assert all(abs(error) <= most for error, most in zip(errors, own.largest, strict=True)), errors
    if own.order is not None:
        order = measured_order(PROBLEMS[name].sizes, errors)
        assert order > own.order - (0.1 if own.at_least else 0.3)
        assert order < own.order + (math.inf if own.at_least else 0.3)


@pytest.mark.parametrize("name", PROBLEMS)
def test_no_residual_is_near_the_error_it_measures(name):
    for solved in solutions(name):
        residuals = solved.residuals()
        assert residuals.pop("tension") == 0
        assert residuals.pop("penetration_um") <= 1e-4
        assert residuals.pop("cone_excess") < 1e-12
        assert max(residuals.values()) <= 1e-7
