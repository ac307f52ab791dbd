"""Differential operators of the shear change, which the paper's configuration leaves switched off.

Closed forms on the patch grid; knows no learned weight.
"""

from __future__ import annotations

import torch
from torch import Tensor

OPERATORS = ("curl", "divergence", "stretch", "shear_strain")
"""What is computed, in this order. The paper names curl, divergence and strain; the two components
of strain that change no area are the ones divergence leaves."""


def differential_operators(shear_change: Tensor) -> Tensor:
    """Return curl, divergence and both strains of a field, by central differences.

    At the border the differences are one-sided.

    Args:
        shear_change: Components (x right, y down), shape (b, gh, gw, 2), at least two patches a
            side.

    Returns:
        Shape (b, gh, gw, 4), in the order of `OPERATORS`, per patch step. Curl is positive where
        the field turns clockwise as drawn.
    """
    x, y = shear_change.unbind(dim=-1)
    x_down, x_right = torch.gradient(x, dim=(1, 2))
    y_down, y_right = torch.gradient(y, dim=(1, 2))
    fields = (y_right - x_down, x_right + y_down, x_right - y_down, x_down + y_right)
    return torch.stack(fields, dim=-1)
