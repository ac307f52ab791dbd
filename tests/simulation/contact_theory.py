"""Closed forms of contact mechanics for the problems of `contact_problems`; solves nothing.

Lengths are in mm and tractions in units of the shear modulus G, so that forces are in mm^2 and
moments in mm^3. a is the contact's radius, R the ball's, d the approach, nu Poisson's ratio, mu
Coulomb's coefficient, P the normal force. The chapters are those of Johnson, Contact Mechanics.
"""

import math

import torch
from scipy.integrate import quad
from scipy.special import ellipe, ellipk
from torch import Tensor

from tests.simulation.contact_problems import CONTACT, DEPTH, DISC_DEPTH, MU, RADIUS


def hertz_force(nu: float) -> float:
    """Return P = 4/3 E* sqrt(R) d^(3/2) with E* = 2 G / (1 - nu) (Hertz; chapter 4)."""
    return 4 / 3 * 2 / (1 - nu) * math.sqrt(RADIUS) * DEPTH**1.5


def hertz_pressure(distance_mm: Tensor, nu: float) -> Tensor:
    """Return p = 3 P / (2 pi a^2) sqrt(1 - r^2 / a^2) at some distances from the axis."""
    return 3 * hertz_force(nu) / (2 * math.pi * CONTACT**2) * _dome(distance_mm, CONTACT)


def punch_force(radius_mm: float, nu: float) -> float:
    """Return P = 2 E* a d of a flat disc (Boussinesq; chapter 3)."""
    return 2 * 2 / (1 - nu) * radius_mm * DISC_DEPTH


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


def sliding_moment(nu: float) -> float:
    """Return M = 3 pi mu P a / 16 of a turned ball that slips all over."""
    return 3 * math.pi * MU * hertz_force(nu) * CONTACT / 16


def stuck_moment(radius_mm: float, angle_rad: float) -> float:
    """Return M = 16/3 G a^3 theta of a turned disc without slip (Reissner and Sagoci 1944)."""
    return 16 / 3 * radius_mm**3 * angle_rad


def stuck_drag(radius_mm: float, travel_mm: float, nu: float) -> float:
    """Return Q = 8 G a x / (2 - nu) of a slid disc without slip (Mindlin 1949)."""
    return 8 * radius_mm * travel_mm / (2 - nu)


COMPRESSIBLE_DEPTH = CONTACT**2 / (2 * RADIUS)
"""Approach d = a^2 / (2 R) of a ball on a compressible layer with h << a."""

INCOMPRESSIBLE_DEPTH = CONTACT**2 / (4 * RADIUS)
"""Approach d = a^2 / (4 R) of a ball on an incompressible layer with h << a."""


def compressible_layer_force(thickness_mm: float, nu: float) -> float:
    """Return P = pi R d^2 / h * 2 G (1 - nu) / (1 - 2 nu), h << a (chapter 5)."""
    stiffness = 2 * (1 - nu) / (1 - 2 * nu) / thickness_mm
    return math.pi * RADIUS * COMPRESSIBLE_DEPTH**2 * stiffness


def incompressible_layer_force(thickness_mm: float) -> float:
    """Return P = 2 pi G R^2 d^3 / h^3, h << a (chapter 5).

    From -h^3 / (3 G) laplacian(p) = d - r^2 / (2 R) with p = p' = 0 at r = a.
    """
    return 2 * math.pi * RADIUS**2 * (INCOMPRESSIBLE_DEPTH / thickness_mm) ** 3


def _dome(distance_mm: Tensor, radius_mm: float) -> Tensor:
    return torch.sqrt((1 - (distance_mm / radius_mm) ** 2).clamp_min(0))
