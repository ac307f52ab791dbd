"""Surface response of the elastic half-space on a free grid: for verification only.

A unit traction, even over one square cell, moves every other cell by the integrals of Boussinesq
and Cerruti (Love 1929; Johnson, Contact Mechanics, 3.2 and 3.6), convolved by FFT on a grid of
twice the side, so that nothing is periodic. The pad is a layer 4 mm thick: a half-space is wrong by
68 to 172 um RMS in its height under a press of 0.6 mm, measured.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor


class HalfSpaceOperator:
    """The half-space's response; methods and shapes as `LayerOperator`, unit shear modulus.

    Args:
        side: Cells per side.
        box_mm: Side of the square that may be loaded.
        poisson_ratio: Poisson's ratio.
        dtype: torch.float32 or torch.float64.
    """

    def __init__(
        self, side: int, box_mm: float, *, poisson_ratio: float, dtype: torch.dtype = torch.float64
    ) -> None:
        self.side, self.cell_mm = side, box_mm / side
        nu, cell = poisson_ratio, self.cell_mm
        offset = (np.arange(2 * side) + side) % (2 * side) - side
        x, y = np.meshgrid(offset * cell, offset * cell)
        whole = _over_cell(_inverse_distance, x, y, cell)
        along_x = _over_cell(_x_squared, x, y, cell)
        along_y = _over_cell(lambda a, b: _x_squared(b, a), x, y, cell)
        mixed = _over_cell(_x_y, x, y, cell)
        slope_x = _over_cell(_x_over_square, x, y, cell)
        slope_y = _over_cell(lambda a, b: _x_over_square(b, a), x, y, cell)
        kernels = {
            "zz": (1 - nu) * whole / (2 * np.pi),
            "xx": ((1 - nu) * whole + nu * along_x) / (2 * np.pi),
            "yy": ((1 - nu) * whole + nu * along_y) / (2 * np.pi),
            "xy": nu * mixed / (2 * np.pi),
            "zx": (1 - 2 * nu) * slope_x / (4 * np.pi),
            "zy": (1 - 2 * nu) * slope_y / (4 * np.pi),
        }
        self.shear_diagonal = float(kernels["xx"][0, 0])
        self._spectra = {
            name: torch.fft.rfft2(torch.from_numpy(kernel).to(dtype))
            for name, kernel in kernels.items()
        }

    def press(self, pressure: Tensor) -> Tensor:
        """Return the indentation under a pressure."""
        return self._moved({"zz": pressure})

    def bulge(self, traction: Tensor) -> Tensor:
        """Return the indentation that a tangential traction causes."""
        return self._moved({"zx": traction[:, 0], "zy": traction[:, 1]})

    def spread(self, pressure: Tensor) -> Tensor:
        """Return the tangential displacement that a pressure causes."""
        return -torch.stack([self._moved({"zx": pressure}), self._moved({"zy": pressure})], dim=1)

    def shear(self, traction: Tensor) -> Tensor:
        """Return the tangential displacement under a tangential traction."""
        x, y = traction.unbind(dim=1)
        return torch.stack(
            [self._moved({"xx": x, "xy": y}), self._moved({"xy": x, "yy": y})], dim=1
        )

    def _moved(self, loads: dict[str, Tensor]) -> Tensor:
        double = (2 * self.side, 2 * self.side)
        spectrum = sum(
            torch.fft.rfft2(load, s=double) * self._spectra[name] for name, load in loads.items()
        )
        return torch.fft.irfft2(spectrum, s=double)[..., : self.side, : self.side]


def _over_cell(antiderivative, x, y, cell_mm: float):
    """Integrate over the cell around the origin, seen from (x, y)."""
    half = cell_mm / 2
    return (
        antiderivative(x + half, y + half)
        - antiderivative(x - half, y + half)
        - antiderivative(x + half, y - half)
        + antiderivative(x - half, y - half)
    )


def _log_sum(a, b):
    """Return ln(a + hypot(a, b)) without cancellation where a < 0; a cell's corners have b != 0."""
    r = np.hypot(a, b)
    return np.where(a >= 0, np.log(np.abs(a) + r), np.log(b**2) - np.log(r + np.abs(a)))


def _inverse_distance(x, y):
    """Antiderivative of 1 / r."""
    return x * _log_sum(y, x) + y * _log_sum(x, y)


def _x_squared(x, y):
    """Antiderivative of x^2 / r^3."""
    return y * _log_sum(x, y)


def _x_y(x, y):
    """Antiderivative of x y / r^3."""
    return -np.hypot(x, y)


def _x_over_square(x, y):
    """Antiderivative of x / r^2."""
    return 0.5 * y * np.log(x**2 + y**2) + x * np.arctan(y / x)
