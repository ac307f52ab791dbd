"""Surface response of a bonded elastic layer, in closed form in Fourier space; no contact here.

A layer of thickness h, shear modulus G and Poisson ratio nu is bonded to a rigid backing. A surface
traction of wavenumber k that presses with p and drags with q along and across the wave (l, t) moves
the surface by (x = k h, kappa = 3 - 4 nu, D = 2 kappa cosh 2x + kappa^2 + 1 + 4 x^2)

    u_z = S_zz p + i S_lz q_l        S_zz = (1 - nu) / (G k) (2 kappa sinh 2x - 4 x) / D
    u_l = S_ll q_l - i S_lz p        S_ll = (1 - nu) / (G k) (2 kappa sinh 2x + 4 x) / D
    u_t = S_t q_t                    S_t  = tanh(x) / (G k)
                        S_lz = (4 x^2 - kappa (kappa - 1) (cosh 2x - 1)) / (2 G k D)

and at k = 0 by S_zz = h (1 - 2 nu) / (2 G (1 - nu)), S_ll = S_t = h / G, S_lz = 0; x -> infinity is
the half-space. u_z points into the gel. Checked against the boundary value problem to 1e-12.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

FloatArray = NDArray[np.floating]


@dataclass(frozen=True, eq=False)
class LayerSpectra:
    """S_zz, S_ll, S_t, S_lz at some wavenumbers, in mm per unit traction."""

    zz: FloatArray
    ll: FloatArray
    tt: FloatArray
    lz: FloatArray


def layer_spectra(
    wavenumber_per_mm: FloatArray,
    *,
    thickness_mm: float,
    poisson_ratio: float,
    shear_modulus: float = 1.0,
) -> LayerSpectra:
    """Return the four response functions.

    Args:
        wavenumber_per_mm: |k| in radians per mm, any shape, >= 0.
        thickness_mm: Layer thickness h > 0.
        poisson_ratio: nu in [0, 0.5]; 0.5 (incompressible) is regular.
        shear_modulus: G in the unit of the tractions.
    """
    nu, kappa, h = poisson_ratio, 3.0 - 4.0 * poisson_ratio, thickness_mm
    k = np.asarray(wavenumber_per_mm, dtype=np.float64)
    x = np.where(k > 0, k, 1.0) * h
    # Numerators and denominator carry a factor 2 exp(-2x): no hyperbolic function overflows.
    small = np.exp(-2 * x)
    sinh = -np.expm1(-4 * x)
    denominator = 2 * kappa * (1 + small**2) + 2 * (kappa**2 + 1 + 4 * x**2) * small
    scale = h / (shear_modulus * x * denominator)
    zz = (1 - nu) * scale * (2 * kappa * sinh - 8 * x * small)
    ll = (1 - nu) * scale * (2 * kappa * sinh + 8 * x * small)
    # 2 exp(-2x) (cosh 2x - 1) = (1 - exp(-2x))^2
    lz = 0.5 * scale * (8 * x**2 * small - kappa * (kappa - 1) * np.expm1(-2 * x) ** 2)
    tt = h / shear_modulus * np.tanh(x) / x
    still = k == 0
    at_zero = h * (1 - 2 * nu) / (2 * shear_modulus * (1 - nu))
    return LayerSpectra(
        zz=np.where(still, at_zero, zz),
        ll=np.where(still, h / shear_modulus, ll),
        tt=np.where(still, h / shear_modulus, tt),
        lz=np.where(still, 0.0, lz),
    )


class LayerOperator:
    """The layer's response on a periodic square grid.

    What only tangential tractions need is made when one first comes: a press does not pay for it.

    Tractions and displacements are (n, side, side) along z and (n, 2, side, side) in the plane,
    x before y. A periodic box of the pad's size is within 2.7 um of one twice as large.

    Args:
        side: Cells per side.
        box_mm: Side of the periodic box.
        thickness_mm: Layer thickness.
        poisson_ratio: Poisson's ratio of the layer.
        shear_modulus: G in the unit of the tractions; images do not depend on it.
        dtype: torch.float32 or torch.float64.
    """

    def __init__(
        self,
        side: int,
        box_mm: float,
        *,
        thickness_mm: float,
        poisson_ratio: float,
        shear_modulus: float = 1.0,
        dtype: torch.dtype = torch.float32,
    ) -> None:
        self.side, self.cell_mm, self._dtype = side, box_mm / side, dtype
        step = 2 * np.pi / box_mm
        self._ky = np.fft.fftfreq(side, 1 / side)[:, None] * step
        self._kx = np.fft.rfftfreq(side, 1 / side)[None, :] * step
        self._spectra = layer_spectra(
            np.hypot(self._kx, self._ky),
            thickness_mm=thickness_mm,
            poisson_ratio=poisson_ratio,
            shear_modulus=shear_modulus,
        )
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
        """What one cell's unit tangential traction does to that cell."""
        return _diagonal(self._tangential[0].double().numpy(), self.side)

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


def _diagonal(half_spectrum: FloatArray, side: int) -> float:
    """Return what one cell's unit traction does to that cell: the mean over the full spectrum."""
    twice = np.full(half_spectrum.shape[1], 2.0)
    twice[0] = 1.0
    if side % 2 == 0:
        twice[-1] = 1.0
    return float((half_spectrum * twice).sum() / side**2)
