"""How far clips are told to go: every number stands under the title that says what it is."""

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.odometry import COLUMNS, odometry_table

ODOMETER = {
    "clips": 40,
    "in_tolerance": 0.875,
    "interval": [0.75, 0.95],
    "median_error": 0.06,
    "median_ratio": 1.02,
    "in_span": 0.9,
    "mean_probability": 0.8,
}
FLOW = ODOMETER | {"in_tolerance": 0.5, "median_error": 0.25, "median_ratio": 0.75}
FLOW |= {"in_span": None, "mean_probability": None}


def test_a_row_tells_the_odometers_numbers_and_then_the_flows():
    numbers = {"some slides": {"unit": "px", "odometer": ODOMETER, "optical flow": FLOW}}
    header, _, line = odometry_table(RunRecord("odometry", "", 0, 1.0, numbers)).splitlines()
    titles, cells = ([one.strip() for one in row.strip("|").split("|")] for row in (header, line))
    assert tuple(titles) == COLUMNS
    assert list(zip(titles, cells, strict=True)) == [
        ("clips", "some slides"),
        ("n", "40"),
        ("unit", "px"),
        ("odometer, within tolerance", "0.875"),
        ("95 %", "0.750-0.950"),
        ("off by, median", "6%"),
        ("told over true, median", "1.02"),
        ("span holds it", "0.900"),
        ("mean probability", "0.800"),
        ("optical flow, within tolerance", "0.500"),
        ("off by, median", "25%"),
        ("told over true, median", "0.75"),
    ]
