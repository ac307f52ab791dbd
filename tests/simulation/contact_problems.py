"""Contact problems set up on the simulator's grid, and what is read off their solution.

A ball or a flat disc on an elastic half-space, a ball on a thin bonded layer, and a lopsided body
twisted on a pad. Lengths are in mm and tractions in units of the shear modulus, so that forces are
in mm^2 and moments in mm^3. Knows no closed form.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from geotlm_lm.simulation.elastic import HalfSpaceOperator, LayerOperator
from geotlm_lm.simulation.solvers import Effort, Response, Step, cell_centres, march

RADIUS = 4.0  # the ball's R: the contact's is a quarter of it, and the profile a parabola
CONTACT = 1.0  # radius a of the ball's contact and of the disc
DEPTH = CONTACT**2 / RADIUS  # approach d of the ball, a^2 = R d (Hertz)
DISC_DEPTH = 0.1  # approach of the disc; everything is in proportion to it
BOX = 4.0  # side of the square that the grid covers, for the half-space
# Side of the periodic box of a thin layer, which is at rest some thicknesses beyond the contact,
# and its cells per side; twice as many change the force by 2e-5, measured.
LAYER_BOX, LAYER_CELLS = 3.0, 256
MU = 0.5  # Coulomb's coefficient, where anything can slip
ENDLESS = 1e6  # a coefficient under which nothing slips
OUTSIDE = -1e3  # overlap beyond the disc's rim: far away from any contact


# For verification: grid error dominates everything else.
TIGHT = Effort((50, 100, 400, 1000), 2000, passes=3, penetration_um=1e-4, gradient_share=1e-7)


class Uncoupled(HalfSpaceOperator):
    """The half-space without the cross terms that the closed forms leave out."""

    def bulge(self, traction: Tensor) -> Tensor:
        return torch.zeros_like(traction[:, 0])

    def spread(self, pressure: Tensor) -> Tensor:
        return torch.zeros_like(pressure)[:, None].expand(-1, 2, -1, -1)


@dataclass(frozen=True, eq=False)
class Solved:
    """A numerical solution: overlap (1, side, side), the gel after the press and each travel."""

    response: Response
    overlap_mm: Tensor
    steps: Sequence[Step]
    friction: float
    thickness_mm: float = math.inf

    @property
    def end(self) -> Step:
        return self.steps[-1]

    @property
    def distance_mm(self) -> Tensor:
        """Distance of every cell from the axis, (side, side)."""
        return torch.hypot(*_centres(self.response))

    @property
    def force(self) -> float:
        return float(self.end.pressure.sum()) * self.response.cell_mm**2

    @property
    def drag(self) -> float:
        """Tangential force Q along x."""
        return float(self.end.traction[0, 0].sum()) * self.response.cell_mm**2

    @property
    def moment(self) -> float:
        """Moment M about the axis."""
        (x, y), (along, down) = _centres(self.response), self.end.traction[0]
        return float((x * down - y * along).sum()) * self.response.cell_mm**2

    @property
    def contact_radius(self) -> float:
        """Radius of the circle as large as all cells in contact."""
        return self._radius(self.end.pressure > 0)

    @property
    def stick_radius(self) -> float:
        """Radius of the circle as large as all cells that stick."""
        limit = self.friction * self.end.pressure
        inside = self.end.traction.norm(dim=1) < (1 - 1e-6) * limit
        return self._radius((self.end.pressure > 0) & inside)

    def _radius(self, cells: Tensor) -> float:
        return self.response.cell_mm * math.sqrt(float(cells.sum()) / math.pi)

    def residuals(self) -> dict[str, float]:
        """Return how far the worst step is from a solution; all are 0 for an exact one.

        Tension and cone excess are relative to the highest pressure and the widest friction disc,
        complementarity |p g| to force times approach, gained work to the energy stored.
        """
        worst: dict[str, float] = {}
        energy = 0.0
        for step in self.steps:
            pressure, gap = step.pressure, step.indentation_mm - self.overlap_mm
            highest, approach = float(pressure.max()), self.overlap_mm.max()
            excess = float((step.traction.norm(dim=1) - self.friction * pressure).max())
            lost, energy = float(step.work) - (float(step.energy) - energy), float(step.energy)
            own = {
                "tension": -float(pressure.min()) / highest,
                "penetration_um": float(step.penetration_um),
                "complementarity": float(_mean(pressure * gap) / (_mean(pressure) * approach)),
                "gradient_share": float(step.gradient_share),
                "cone_excess": excess / (self.friction * highest) if self.friction else 0.0,
                "gained_work": -lost / energy,
            }
            worst = {name: max(worst.get(name, 0.0), value) for name, value in own.items()}
        return worst


Travel = Callable[[Tensor], Tensor]
"""Cell centres (2, side, side) -> travel over each cell, (1, 2, side, side)."""


def turn(angle_rad: float) -> Travel:
    """Return a small turn about the axis, positive from x towards y."""
    return lambda centres: angle_rad * torch.stack([-centres[1], centres[0]])[None]


def slide(travel_mm: float) -> Travel:
    """Return a slide along x."""
    along = torch.tensor([travel_mm, 0.0], dtype=torch.float64).view(1, 2, 1, 1)
    return lambda centres: along.expand(-1, -1, *centres.shape[1:])


def marched(response: Response, overlap_mm: Tensor, *travels: Travel, friction=MU) -> Solved:
    """Press, then travel, as tightly as the solver goes; the overlap is the same all along."""
    centres = _centres(response)
    paths = [torch.zeros_like(centres)[None], *(travel(centres) for travel in travels)]
    increments = [(overlap_mm, path) for path in paths]
    steps = list(march(increments, response, TIGHT, friction_coefficient=friction))
    return Solved(response, overlap_mm, steps, friction)


def ball(side: int, *travels: Travel, nu: float = 0.3) -> Solved:
    """Press a ball into the half-space, then move it."""
    response = Uncoupled(side, BOX, poisson_ratio=nu)
    return marched(response, _parabola(response, DEPTH), *travels)


def disc(side: int, *travels: Travel, nu: float = 0.3) -> Solved:
    """Press a flat disc into the half-space, then move it without any slip.

    Its rim follows the cells: hold it against a disc of its own `contact_radius`.
    """
    response = Uncoupled(side, BOX, poisson_ratio=nu)
    x, y = _centres(response)
    overlap = torch.where(x**2 + y**2 <= CONTACT**2, DISC_DEPTH, OUTSIDE)[None].double()
    return marched(response, overlap, *travels, friction=ENDLESS)


def thin_layer(thickness_mm: float, depth_mm: float, *, nu: float) -> Solved:
    """Press a slippery ball into a bonded layer thinner than the contact is wide."""
    size = {"thickness_mm": thickness_mm, "poisson_ratio": nu, "dtype": torch.float64}
    response = LayerOperator(LAYER_CELLS, LAYER_BOX, **size)
    solved = marched(response, _parabola(response, depth_mm), friction=0.0)
    return replace(solved, thickness_mm=thickness_mm)


def pad(scale: float = 1.0) -> LayerOperator:
    """Return a GelSight pad's layer on a box of 16 mm, all its lengths times `scale`."""
    size = {"thickness_mm": 4.0 * scale, "poisson_ratio": 0.48, "dtype": torch.float64}
    return LayerOperator(32, 16.0 * scale, **size)


def lopsided(response: Response, scale: float = 1.0) -> Tensor:
    """Return the overlap of a body without any symmetry, (1, side, side)."""
    x, y = _centres(response) / scale
    return scale * (0.5 - (x - 0.4) ** 2 / 12 - (y + 0.2) ** 2 / 7 + 0.05 * torch.cos(3 * x))[None]


def _parabola(response: Response, depth_mm: float) -> Tensor:
    x, y = _centres(response)
    return (depth_mm - (x**2 + y**2) / (2 * RADIUS))[None]


def _mean(field: Tensor) -> Tensor:
    return field.abs().mean()


def _centres(response: Response) -> Tensor:
    return cell_centres(response.side, response.cell_mm, torch.float64)
