"""Normal compliance of a bonded elastic layer in Fourier space; knows nothing of contact.

For a layer of thickness h, shear modulus G and Poisson ratio nu, bonded to a rigid backing, a
pressure of wavenumber k presses the surface in by S_zz(k) times its amplitude, with x = k h and
kappa = 3 - 4 nu (Barber, Elasticity; Johnson, Contact Mechanics, layered bodies):

    S_zz = (1 - nu) / (G k) * (2 kappa sinh 2x - 4 x) / (2 kappa cosh 2x + kappa^2 + 1 + 4 x^2)
    S_zz(0) = h (1 - 2 nu) / (2 G (1 - nu))
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.floating]


def normal_compliance(
    wavenumber_per_mm: FloatArray,
    *,
    thickness_mm: float,
    poisson_ratio: float,
    shear_modulus: float = 1.0,
) -> FloatArray:
    """Return S_zz in mm per unit pressure.

    Args:
        wavenumber_per_mm: |k| in radians per mm, any shape, >= 0.
        thickness_mm: Layer thickness h > 0.
        poisson_ratio: nu in [0, 0.5]; 0.5 (incompressible) is regular.
        shear_modulus: G in the unit of the pressure.
    """
    nu, kappa = poisson_ratio, 3.0 - 4.0 * poisson_ratio
    k = np.asarray(wavenumber_per_mm, dtype=np.float64)
    at_zero = thickness_mm * (1 - 2 * nu) / (2 * shear_modulus * (1 - nu))
    x = np.where(k > 0, k, 1.0) * thickness_mm
    # Numerator and denominator carry a factor 2 exp(-2x), so that no hyperbolic function overflows.
    small = np.exp(-2 * x)
    numerator = 2 * kappa * (-np.expm1(-4 * x)) - 8 * x * small
    denominator = 2 * kappa * (1 + small**2) + 2 * (kappa**2 + 1 + 4 * x**2) * small
    value = (1 - nu) * thickness_mm / (shear_modulus * x) * numerator / denominator
    return np.where(k > 0, value, at_zero)


def grid_compliance(
    side: int, box_mm: float, *, thickness_mm: float, poisson_ratio: float
) -> FloatArray:
    """Return S_zz (G = 1) on the half spectrum of a periodic square grid.

    Args:
        side: Cells per side.
        box_mm: Side of the periodic box.
        thickness_mm: Layer thickness.
        poisson_ratio: Poisson's ratio of the layer.

    Returns:
        float64, shape (side, side // 2 + 1), to multiply `rfft2` of a pressure.
    """
    step = 2 * np.pi / box_mm
    ky = np.fft.fftfreq(side, 1 / side)[:, None] * step
    kx = np.fft.rfftfreq(side, 1 / side)[None, :] * step
    return normal_compliance(
        np.hypot(kx, ky), thickness_mm=thickness_mm, poisson_ratio=poisson_ratio
    )
