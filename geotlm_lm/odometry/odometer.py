"""How far it went, as probabilities of many amounts: a small network on the imprint's movement."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from geotlm_lm.odometry.movement import MOVEMENT_DIM

UNITS = ("deg", "px")
"""Degrees of turning, and pixels of sliding in the 224-pixel image."""

SPANS = {"deg": (0.8, 60.0), "px": (0.8, 90.0)}
"""Least and most that is told: training's hands turn 1 to 40 degrees and slide 1 to 55 pixels."""

AMOUNTS = 40
"""Amounts weighed per unit, evenly apart on a log scale: by 11 and 12 %, half of a tolerance."""

HIDDEN = 128


def amounts(unit: str) -> Tensor:
    """Return the middles, on a log scale, of the cells whose probabilities are read, (AMOUNTS,)."""
    low, high = torch.tensor(SPANS[unit], dtype=torch.float64).log()
    places = (torch.arange(AMOUNTS, dtype=torch.float64) + 0.5) / AMOUNTS
    return (low + (high - low) * places).exp()


def place_of(amount: Tensor, unit: str) -> Tensor:
    """Return where amounts lie among `amounts`: 0 is the first, in fractions of a cell."""
    low, high = torch.tensor(SPANS[unit], dtype=amount.dtype).log()
    return (amount.log() - low) / (high - low) * AMOUNTS - 0.5


class Odometer(nn.Module):
    """Read from an imprint's movement how far it turned, if it turned, and slid, if it slid.

    Measured on 619 turns and slides of objects kept from training: it tells 0.87 of the turns and
    0.93 of the slides within their tolerance, where the language model, choosing among 30 amounts
    by the fused token alone, told 0.79 and 0.82. Of the fused token as one more input nothing is
    gained.
    """

    def __init__(self) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(MOVEMENT_DIM))
        self.register_buffer("scale", torch.ones(MOVEMENT_DIM))
        self.layers = nn.Sequential(
            nn.Linear(MOVEMENT_DIM, HIDDEN),
            nn.GELU(),
            nn.Dropout(0.1),
            nn.Linear(HIDDEN, HIDDEN),
            nn.GELU(),
            nn.Linear(HIDDEN, len(UNITS) * AMOUNTS),
        )

    def forward(self, movement: Tensor) -> Tensor:
        """Return the logits of every amount, (b, units, AMOUNTS).

        Args:
            movement: As `movement.movement` describes it, (b, MOVEMENT_DIM).
        """
        standard = (movement - self.mean) / self.scale
        return self.layers(standard).unflatten(-1, (len(UNITS), AMOUNTS))

    @torch.inference_mode()
    def read(self, movement: Tensor, unit: str) -> Tensor:
        """Return the probability of each of `amounts(unit)`, (b, AMOUNTS)."""
        return self(movement)[:, UNITS.index(unit)].softmax(dim=-1)
