"""The record of how far clips are told to go as one table."""

from __future__ import annotations

from typing import Any

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.tables import markdown, provenance

METHODS = ("odometer", "optical flow")

COLUMNS = (
    "clips",
    "n",
    "unit",
    "odometer, within tolerance",
    "95 %",
    "off by, median",
    "told over true, median",
    "span holds it",
    "mean probability",
    "optical flow, within tolerance",
    "off by, median",
    "told over true, median",
)


def odometry_page(record: RunRecord) -> str:
    """Return the page: what is told how, and the rows."""
    return (
        "# How far it went\n\n"
        "The kind of motion is given; only how far it went from the first to the last frame is "
        "asked. An amount is *within tolerance* if it is off by 2 degrees, 2 pixels of a "
        "224-pixel image, or a fifth of the true one, at most; *off by* is relative to the true "
        "one. The odometer also tells a span meant to hold nine tenths of the true amounts, and "
        "how probable its amount is right within tolerance. Optical flow is that of the tables "
        "elsewhere, whose rigid fit was tuned to tell directions. Simulated amounts are exact. "
        "Semi-real imprints are real and carried by a known path. Amounts of real windows were "
        "measured from the images, some twice: those that differ by more than the tolerance are "
        "left out, and what is left is not exact. On gels with markers they are how far the "
        "markers went, which lag behind the object; the odometer tells of the object. Windows are "
        "also played backwards; intervals resample families of objects.\n\n"
        f"{odometry_table(record)}\n\n{provenance(record)}\n"
    )


def odometry_table(record: RunRecord) -> str:
    """Return one row per source of clips."""
    return markdown(COLUMNS, [_row(title, row) for title, row in sorted(record.numbers.items())])


def _row(title: str, row: dict[str, Any]) -> list[str]:
    odometer, flow = (row[name] for name in METHODS)
    low, high = odometer["interval"]
    return [
        title,
        str(odometer["clips"]),
        row["unit"],
        f"{odometer['in_tolerance']:.3f}",
        f"{low:.3f}-{high:.3f}",
        f"{odometer['median_error']:.0%}",
        f"{odometer['median_ratio']:.2f}",
        f"{odometer['in_span']:.3f}",
        f"{odometer['mean_probability']:.3f}",
        f"{flow['in_tolerance']:.3f}",
        f"{flow['median_error']:.0%}",
        f"{flow['median_ratio']:.2f}",
    ]
