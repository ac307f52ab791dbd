"""What is held against a closed form, problem by problem, and how fast it should converge.

Each problem is solved at several sizes, which are cells per side, contact radii per layer
thickness, or increments of a path. Knows the expected orders, and no pass mark.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal

import torch
from torch import Tensor

from geotlm_lm.experiments import contact_theory as theory
from geotlm_lm.experiments.contact_problems import (
    CONTACT,
    LAYER_CELLS,
    MU,
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

NU = 0.3
"""Poisson's ratio, where the answer holds for any."""

STICK = 0.6
"""Radius that still sticks, in parts of the contact's: slip has come half way in."""

SHARE = 1 - STICK**3
"""Drag in parts of the friction there is at which a slid ball sticks inside `STICK`."""

THERE, BACK = 0.6, 0.5
"""Drag, in parts of the friction there is, that a ball is slid with and then loses again."""

PATH_TURN = 0.16
"""Angle in rad over which the lopsided body is twisted, in many increments or few."""


@dataclass(frozen=True)
class Quantity:
    """One number of a solution beside what it should be.

    Args:
        error_of: Solution -> signed relative error.
        order: Expected order of convergence; negative for what grows without bound.
        reading: The order is exactly that; at least that, where coarse grids are ruled by the rim's
            staircase, whose part scatters from grid to grid and falls with order 2.5, measured; or
            about that, where nothing but this scatter is left.
    """

    error_of: Callable[[Solved], float]
    order: float
    reading: Literal["exactly", "at least", "about"] = "exactly"


@dataclass(frozen=True)
class Problem:
    """One problem at several sizes.

    Args:
        source: Who solved it.
        solve: Size -> numerical solution.
        quantities: What is held against the closed form, by name.
        sizes: Sizes of the full report.
        unit: What a size counts.
    """

    source: str
    solve: Callable[[int], Solved]
    quantities: Mapping[str, Quantity]
    sizes: Sequence[int] = (16, 24, 32, 48, 64, 96, 128)
    unit: str = "cells per side"


def problems() -> dict[str, Problem]:
    """Return every problem by name."""
    return {
        "pressed ball": _hertz(),
        "flat punch": _flat_punch(),
        "slid ball, c = 0.6 a": _slid_ball(SHARE),
        "slid ball, Q = 0.3 mu P": _slid_ball(0.3),
        "ball slid and back": _returning_ball(),
        "twisted ball, c = 0.6 a, nu 0": _twisted_ball(0.0),
        "twisted ball, c = 0.6 a, nu 0.49": _twisted_ball(0.49),
        "ball that slips all over": _spun_ball(),
        "stuck disc, turned": _stuck_disc_turned(),
        "stuck disc, slid": _stuck_disc_slid(),
        "thin layer, nu 0.3": _compressible_layer(),
        "thin layer, nu 0.5": _incompressible_layer(),
        "lopsided body twisted on a pad": _path(),
    }


def _field_error(found: Tensor, exact: Tensor) -> float:
    return float((found - exact).norm() / exact.norm())


def _hertz() -> Problem:
    def pressure(solved: Solved) -> float:
        return _field_error(solved.end.pressure[0], theory.hertz_pressure(solved.distance_mm, NU))

    return Problem(
        "Hertz (Johnson, ch. 4)",
        lambda side: ball(side, nu=NU),
        {
            "force": Quantity(lambda s: s.force / theory.hertz_force(NU) - 1, 2),
            "pressure, L2": Quantity(pressure, 1),
            "contact radius": Quantity(lambda s: s.contact_radius / CONTACT - 1, 1, "about"),
        },
    )


def _flat_punch() -> Problem:
    def peak(solved: Solved) -> float:
        pressure = solved.end.pressure
        return float(pressure.max() / pressure[pressure > 0].mean())

    return Problem(
        "Boussinesq (Johnson, ch. 3)",
        lambda side: disc(side, nu=NU),
        {
            "force": Quantity(lambda s: s.force / theory.punch_force(s.contact_radius, NU) - 1, 1),
            # The edge's pressure is infinite, and grows as its cells shrink.
            "peak / mean pressure (not an error)": Quantity(peak, -0.5),
        },
    )


def _slid_ball(share: float) -> Problem:
    stick, friction = theory.mindlin_stick_radius(share), MU * theory.hertz_force(0.0)

    def traction(solved: Solved) -> float:
        along = theory.mindlin_traction(solved.distance_mm, share, 0.0)
        exact = torch.stack([along, torch.zeros_like(along)])
        return _field_error(solved.end.traction[0], exact)

    return Problem(
        "Cattaneo, Mindlin (Johnson, ch. 7)",
        lambda side: ball(side, slide(theory.mindlin_travel(share, 0.0)), nu=0.0),
        {
            "drag": Quantity(lambda s: s.drag / (friction * share) - 1, 2, "at least"),
            "traction, L2": Quantity(traction, 1),
            "stick radius": Quantity(lambda s: s.stick_radius / stick - 1, 1, "about"),
        },
    )


def _returning_ball() -> Problem:
    """Turn back: a new ring slips at twice the friction, inwards; drag in parts of mu P."""
    there, back = theory.mindlin_travel(THERE, 0.0), 2 * theory.mindlin_travel(BACK / 2, 0.0)
    friction = MU * theory.hertz_force(0.0)
    drag = Quantity(lambda s: s.drag / friction - (THERE - BACK), 2, "at least")
    return Problem(
        "Mindlin, Deresiewicz (Johnson, ch. 7)",
        lambda side: ball(side, slide(there), slide(-back), nu=0.0),
        {"drag / mu P": drag},
    )


def _twisted_ball(nu: float) -> Problem:
    angle, exact = theory.lubkin_angle(STICK, nu), theory.lubkin_moment(STICK, nu)
    return Problem(
        "Lubkin 1951, Jaeger 1995",
        lambda side: ball(side, turn(angle), nu=nu),
        {
            "moment": Quantity(lambda s: s.moment / exact - 1, 2, "at least"),
            "stick radius": Quantity(lambda s: s.stick_radius / STICK - 1, 1, "about"),
        },
    )


def _spun_ball() -> Problem:
    angle, exact = 50 * theory.lubkin_angle(STICK, NU), theory.sliding_moment(NU)
    moment = Quantity(lambda s: s.moment / exact - 1, 2, "at least")
    return Problem(
        "Lubkin 1951, Jaeger 1995", lambda side: ball(side, turn(angle), nu=NU), {"moment": moment}
    )


def _stuck_disc_turned(angle: float = 0.01) -> Problem:
    def moment(solved: Solved) -> float:
        return solved.moment / theory.stuck_moment(solved.contact_radius, angle) - 1

    return Problem(
        "Reissner, Sagoci 1944",
        lambda side: disc(side, turn(angle), nu=NU),
        {"moment": Quantity(moment, 1)},
    )


def _stuck_disc_slid(travel: float = 0.01) -> Problem:
    def drag(solved: Solved) -> float:
        return solved.drag / theory.stuck_drag(solved.contact_radius, travel, NU) - 1

    return Problem(
        "Mindlin 1949", lambda side: disc(side, slide(travel), nu=NU), {"drag": Quantity(drag, 1)}
    )


def _thin_layer(nu: float, depth: float, force: Callable[[float], float]) -> Problem:
    """Expect order 2: the formulas keep the first term of S_zz, whose next is (k h)^2 smaller."""

    def solve(radii: int) -> Solved:
        return thin_layer(CONTACT / radii, depth, nu=nu, side=LAYER_CELLS)

    error = Quantity(lambda s: s.force / force(s.thickness_mm) - 1, 2)
    sizes = (8, 16, 32, 64)  # The formulas are for a >> h.
    return Problem("Johnson, ch. 5", solve, {"force": error}, sizes, "contact radii per thickness")


def _compressible_layer() -> Problem:
    depth = theory.compressible_layer_depth()
    return _thin_layer(NU, depth, lambda h: theory.compressible_layer_force(h, NU))


def _incompressible_layer() -> Problem:
    depth = theory.incompressible_layer_depth()
    return _thin_layer(0.5, depth, theory.incompressible_layer_force)


def _path() -> Problem:
    """Hold a path of few increments against twice as many: no closed form knows this history."""

    def error(solved: Solved) -> float:
        twice_as_many = _twisted_body(2 * (len(solved.steps) - 1))
        return _field_error(solved.end.drift_mm, twice_as_many.end.drift_mm)

    return Problem(
        "twice as many increments",
        _twisted_body,
        {"drift, L2": Quantity(error, 1)},
        sizes=(4, 8, 16, 32, 64),
        unit="increments",
    )


@cache
def _twisted_body(increments: int) -> Solved:
    layer = pad()
    return marched(layer, lopsided(layer), *[turn(PATH_TURN / increments)] * increments)
