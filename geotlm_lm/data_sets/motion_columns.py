"""What a track tells of every frame of an episode, as columns of 32-bit floats, and its events."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.track.export import Exported

Values = NDArray[np.float32]

CAMERA_PREFIX = "observation.images."
"""Of most cameras' names; what is behind it begins the names of the columns."""

QUANTILES = (0.01, 0.1, 0.5, 0.9, 0.99)


def column_names(camera: str, unit: str) -> tuple[str, ...]:
    """Return the names of the columns that are added for a camera, each before its deviation.

    Args:
        camera: Name of the feature.
        unit: Of travel, "px" or "mm".
    """
    short = camera.removeprefix(CAMERA_PREFIX)
    told = ("turn_deg_s", f"right_{unit}_s", f"down_{unit}_s", "contact")
    return tuple(name for one in told for name in (f"{short}.{one}", f"{short}.{one}_deviation"))


def motion_values(exported: Exported, count: int) -> Values:
    """Return the columns of a track, in the order of `column_names`, (count, 8).

    Rates are clockwise, right and down positive. A frame that was left out of the track has what
    lies between its neighbours. Contact is a probability; its deviation that of touching or not.

    Args:
        exported: The track in its units.
        count: Rows of the episode.
    """
    track = exported.track
    if not len(track):
        return unknown_values(count)
    rates, deviations = track.rates()
    contact = track.contact
    sideways = [exported.units.travelled(one[:, 1], one[:, 2]) for one in (rates, deviations)]
    told = (
        *(rates[:, 0], deviations[:, 0]),
        *(sideways[0][0], sideways[1][0]),
        *(sideways[0][1], sideways[1][1]),
        *(contact, np.sqrt(contact * (1 - contact))),
    )
    rows = [np.interp(np.arange(count), track.numbers, one) for one in told]
    return np.stack(rows, axis=1).astype(np.float32)


def unknown_values(count: int) -> Values:
    """Return the columns of an episode that could not be tracked: no number, (count, 8)."""
    return np.full((count, len(column_names("", "px"))), np.nan, np.float32)


def features_of(names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return what `meta/info.json` says of the columns."""
    return {name: {"dtype": "float32", "shape": [1], "names": None} for name in names}


def statistics_of(values: Values) -> dict[str, list[float | int]]:
    """Return the statistics that LeRobot keeps of a column, each of one element.

    Args:
        values: Of the column, (n,); what is no number does not count.
    """
    known = values[np.isfinite(values)].astype(np.float64)
    known = known if len(known) else np.zeros(1)
    told = {"min": known.min(), "max": known.max(), "mean": known.mean(), "std": known.std()}
    quantiles = np.quantile(known, QUANTILES)
    told |= {f"q{round(100 * q):02d}": x for q, x in zip(QUANTILES, quantiles, strict=True)}
    return {name: [float(value)] for name, value in told.items()} | {"count": [len(values)]}
