"""The few numbers that are kept of each frame, in arrays that grow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.track.block import Row

_SHAPES = {
    "numbers": ((), np.int64),
    "times_s": ((), np.float64),
    "contact": ((), np.float32),
    "strength_grey": ((), np.float32),
    "twists": ((4,), np.float32),
    "covariances": ((4, 4), np.float32),
    "radius_px": ((), np.float32),
}

FIRST_ROOM = 1024


class Table:
    """Rows of frames; 112 bytes each."""

    def __init__(self) -> None:
        self._count = 0
        self._columns = {
            name: np.zeros((FIRST_ROOM, *shape), kind) for name, (shape, kind) in _SHAPES.items()
        }
        self.way, self.doubt = np.zeros(4), np.zeros((4, 4))
        """Sums of all twists and covariances so far."""

    def add(self, row: Row, twist: NDArray, covariance: NDArray, contact: float) -> int:
        """Write a frame down and return its place."""
        if self._count == len(self._columns["numbers"]):
            self._columns = {
                name: np.concatenate([column, np.zeros_like(column)])
                for name, column in self._columns.items()
            }
        values = {
            "numbers": row.number,
            "times_s": row.time_s,
            "contact": contact,
            "strength_grey": row.strength_grey,
            "twists": twist,
            "covariances": covariance,
            "radius_px": row.radius_px,
        }
        for name, value in values.items():
            self._columns[name][self._count] = value
        self.way, self.doubt = self.way + twist, self.doubt + covariance
        self._count += 1
        return self._count - 1

    def arrays(self) -> dict[str, NDArray]:
        """Return the columns, as of `Track`."""
        return {
            name: column[: self._count].astype(np.int64 if name == "numbers" else np.float64)
            for name, column in self._columns.items()
        }
