"""Surface responses of elastic bodies to tractions: the bonded layer, the half-space; no contact.

A layer of thickness h, shear modulus G and Poisson ratio nu is bonded to a rigid backing. A surface
traction of wavenumber k that presses with p and drags with q along and across the wave (l, t) moves
the surface by (x = k h, kappa = 3 - 4 nu, D = 2 kappa cosh 2x + kappa^2 + 1 + 4 x^2)

    u_z = S_zz p + i S_lz q_l        S_zz = (1 - nu) / (G k) (2 kappa sinh 2x - 4 x) / D
    u_l = S_ll q_l - i S_lz p        S_ll = (1 - nu) / (G k) (2 kappa sinh 2x + 4 x) / D
    u_t = S_t q_t                    S_t  = tanh(x) / (G k)
                        S_lz = (4 x^2 - kappa (kappa - 1) (cosh 2x - 1)) / (2 G k D)

and at k = 0 by S_zz = h (1 - 2 nu) / (2 G (1 - nu)), S_ll = S_t = h / G, S_lz = 0; x -> infinity is
the half-space. u_z points into the gel. Checked against the boundary value problem to 1e-12.

The half-space on a free grid serves as a check: a unit traction, even over one square cell, moves
every other cell by the integrals of Boussinesq and Cerruti (Love 1929; Johnson, Contact Mechanics,
3.2 and 3.6), convolved by FFT on a grid of twice the side, so that nothing is periodic. The pad is
a layer 4 mm thick: a half-space is wrong by 68 to 172 um RMS in its height under a press of 0.6 mm,
measured.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

FloatArray = NDArray[np.floating]


class LayerSpectra(NamedTuple):
    """S_zz, S_ll, S_t, S_lz at some wavenumbers, in mm per unit traction."""

    zz: FloatArray
    ll: FloatArray
    tt: FloatArray
    lz: FloatArray


def layer_spectra(
    wavenumber_per_mm: FloatArray, *, thickness_mm: float, poisson_ratio: float
) -> LayerSpectra:
    """Return the four response functions at |k| >= 0 in radians per mm, any shape.

    nu is in [0, 0.5], where 0.5 (incompressible) is regular; tractions are in units of G.
    """
    nu, kappa, h = poisson_ratio, 3.0 - 4.0 * poisson_ratio, thickness_mm
    k = np.asarray(wavenumber_per_mm, dtype=np.float64)
    x = np.where(k > 0, k, 1.0) * h
    # Numerators and denominator carry a factor 2 exp(-2x): no hyperbolic function overflows.
    small = np.exp(-2 * x)
    sinh = -np.expm1(-4 * x)
    denominator = 2 * kappa * (1 + small**2) + 2 * (kappa**2 + 1 + 4 * x**2) * small
    scale = h / (x * denominator)
    zz = (1 - nu) * scale * (2 * kappa * sinh - 8 * x * small)
    ll = (1 - nu) * scale * (2 * kappa * sinh + 8 * x * small)
    # 2 exp(-2x) (cosh 2x - 1) = (1 - exp(-2x))^2
    lz = 0.5 * scale * (8 * x**2 * small - kappa * (kappa - 1) * np.expm1(-2 * x) ** 2)
    tt = h * np.tanh(x) / x
    still = k == 0
    at_rest = (h * (1 - 2 * nu) / (2 * (1 - nu)), h, h, 0.0)
    waves = zip(at_rest, (zz, ll, tt, lz), strict=True)
    return LayerSpectra(*(np.where(still, rest, values) for rest, values in waves))


class LayerOperator:
    """The layer's response on a periodic square grid.

    What only tangential tractions need is made when one first comes: a press does not pay for it.

    Tractions and displacements are (n, side, side) along z and (n, 2, side, side) in the plane,
    x before y, on `side` cells per side of a periodic box. A box of the pad's size is within 2.7 um
    of one twice as large. Tractions are in units of the shear modulus: images do not depend on it.
    """

    def __init__(
        self,
        side: int,
        box_mm: float,
        *,
        thickness_mm: float,
        poisson_ratio: float,
        dtype: torch.dtype = torch.float32,
    ) -> None:
        self.side, self.cell_mm, self._dtype = side, box_mm / side, dtype
        step = 2 * np.pi / box_mm
        self._ky = np.fft.fftfreq(side, 1 / side)[:, None] * step
        self._kx = np.fft.rfftfreq(side, 1 / side)[None, :] * step
        k = np.hypot(self._kx, self._ky)
        self._spectra = layer_spectra(k, thickness_mm=thickness_mm, poisson_ratio=poisson_ratio)
        self._zz = torch.from_numpy(self._spectra.zz).to(dtype)

    @cached_property
    def _tangential(self) -> tuple[Tensor, Tensor, Tensor]:
        """Spectra xx, yy and xy."""
        (cx, cy), spectra = self._direction, self._spectra
        at_rest = (self._kx == 0) & (self._ky == 0)
        along = (
            np.where(at_rest, spectra.tt, cx**2 * spectra.ll + cy**2 * spectra.tt),
            np.where(at_rest, spectra.tt, cy**2 * spectra.ll + cx**2 * spectra.tt),
            cx * cy * (spectra.ll - spectra.tt) * self._has_direction,
        )
        return tuple(torch.from_numpy(value).to(self._dtype) for value in along)

    @cached_property
    def _coupling(self) -> Tensor:
        """Spectra i S_lz along x and y."""
        both = 1j * np.stack(self._direction) * (self._spectra.lz * self._has_direction)
        is_single = self._dtype == torch.float32
        return torch.from_numpy(both).to(torch.complex64 if is_single else torch.complex128)

    @cached_property
    def _direction(self) -> tuple[FloatArray, FloatArray]:
        k = np.hypot(self._kx, self._ky)
        safe = np.where(k > 0, k, 1.0)
        return self._kx / safe, self._ky / safe

    @property
    def _has_direction(self) -> NDArray[np.bool_]:
        """A wave at the grid's limit has no direction of its own: odd terms vanish there."""
        limit = np.pi / self.cell_mm * (1 - 1e-9)
        return (np.abs(self._kx) < limit) & (np.abs(self._ky) < limit)

    @property
    def shear_diagonal(self) -> float:
        """What one cell's unit tangential traction does to that cell: its spectrum's mean."""
        half = self._tangential[0].double().numpy()
        twice = np.full(half.shape[1], 2.0)
        twice[0] = 1.0
        if self.side % 2 == 0:
            twice[-1] = 1.0
        return float((half * twice).sum() / self.side**2)

    def press(self, pressure: Tensor) -> Tensor:
        """Return the indentation under a pressure."""
        return self._back(torch.fft.rfft2(pressure).mul_(self._zz))

    def bulge(self, traction: Tensor) -> Tensor:
        """Return the indentation that a tangential traction causes."""
        spectrum = torch.fft.rfft2(traction)
        return self._back((spectrum * self._coupling).sum(dim=1))

    def spread(self, pressure: Tensor) -> Tensor:
        """Return the tangential displacement that a pressure causes."""
        return self._back(-torch.fft.rfft2(pressure)[:, None] * self._coupling)

    def shear(self, traction: Tensor) -> Tensor:
        """Return the tangential displacement under a tangential traction."""
        x, y = torch.fft.rfft2(traction).unbind(dim=1)
        xx, yy, xy = self._tangential
        return self._back(torch.stack([xx * x + xy * y, xy * x + yy * y], dim=1))

    def _back(self, spectrum: Tensor) -> Tensor:
        return torch.fft.irfft2(spectrum, s=(self.side, self.side))


class HalfSpaceOperator:
    """The half-space's response; methods and shapes as `LayerOperator`, unit shear modulus."""

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
        loads = {"xx": x, "xy": y}, {"xy": x, "yy": y}
        return torch.stack([self._moved(load) for load in loads], dim=1)

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


def _inverse_distance(x, y):  # antiderivative of 1 / r
    return x * _log_sum(y, x) + y * _log_sum(x, y)


def _x_squared(x, y):  # of x^2 / r^3
    return y * _log_sum(x, y)


def _x_y(x, y):  # of x y / r^3
    return -np.hypot(x, y)


def _x_over_square(x, y):  # of x / r^2
    return 0.5 * y * np.log(x**2 + y**2) + x * np.arctan(y / x)
