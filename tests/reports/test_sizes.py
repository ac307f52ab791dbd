"""Language models of several sizes: means over the types of questions that their titles name."""

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.sizes import COLUMNS, VERDICTS, sizes_table


def test_verdicts_and_other_types_are_averaged_apart():
    row = {
        "name": "small",
        "parameters": 1_234_567,
        "is_shipped_size": True,
        "rotation": 0.9,
        "sliding": 0.8,
        "seen": 0.7,
        "held_out": 0.6,
        "by_type": {f"{name} seen": 0.5 for name in VERDICTS}
        | {"T1 seen": 1.0, "T5 seen": 0.8, "T1 held_out": 0.1, "T2 held_out": 0.1},
        "weigh_ms_median": 1.0,
        "weigh_ms_p95": 2.0,
        "write_ms_median": 3.0,
        "write_ms_p95": 4.0,
    }
    line = sizes_table(RunRecord("sizes", "", 0, 1.0, {"rows": [row]})).splitlines()[2]
    cells = [one.strip() for one in line.strip("|").split("|")]
    assert list(zip(COLUMNS, cells, strict=True)) == [
        ("language model", "small *"),
        ("parameters", "1,234,567"),
        ("turns", "0.900"),
        ("slides", "0.800"),
        ("all types", "0.700"),
        ("unseen wordings", "0.600"),
        ("verdicts, choices", "0.500"),
        ("all others", "0.900"),
        ("weigh, ms", "1.0"),
        ("p95", "2.0"),
        ("write, ms", "3.0"),
        ("p95", "4.0"),
    ]
