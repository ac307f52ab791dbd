from pathlib import Path

import pytest

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.optics import comparison_table, optics_report, source_table, verdict

REPORTS = Path(__file__).resolve().parents[2] / "reports"

SUMMARY = {"median": 2.0, "low": 1.0, "high": 12.0, "count": 9}


def row(title, outside=None, group="camera", unit="grey"):
    found = {"key": title, "group": group, "title": title, "unit": unit, "real": SUMMARY}
    found |= {"simulated": SUMMARY | {"median": 14.5}, "sources": {"unit 1": SUMMARY}}
    if outside is None:
        return found | {"simulated": None}
    return found | {"outside": outside, "share_inside": 0.25, "share_covered": 1.0}


@pytest.fixture
def record():
    rows = [row("noise, R", 2.5), row("noise, B", -0.07), row("drift", 0.0), row("spill")]
    touches = {"unit 1": {"recordings": 3, "touches": 9, "faint": 1}}
    numbers = {"rows": rows, "balls": [row("area", 0.0, "contact", "%")], "touches": touches}
    config = {"spread": [0.1, 0.9], "balls_mm": [6.31, 9.5]}
    return RunRecord("optics", "geotlm-lm report optics --real DIR", 0, 60.0, numbers, config)


def test_the_verdict_counts_and_names_what_is_outside(record):
    assert verdict(record) == (
        "1 of 3 simulated medians lie inside the real spread; outside: noise (R, B). "
        "Not measured on both sides: spill. "
        "1 of 1 simulated balls' medians lie inside the real spread."
    )


def test_a_row_says_by_how_much_it_is_outside(record):
    lines = comparison_table(record.numbers["rows"], "camera").splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    assert cells[2] == ["noise, R", "grey", "2.00 (1.00 to 12.0)", "14.5 (1.00 to 12.0)",
                        "2.50 above", "25 %", "100 %"]  # fmt: skip
    assert [line[4] for line in cells[3:]] == ["0.07 below", "inside", "not measured"]
    assert cells[5][3:] == ["-", "not measured", "-", "-"]


def test_each_source_has_a_column_and_its_counts(record):
    lines = source_table(record).splitlines()
    assert lines[0].split("|")[2].strip() == "unit 1"
    assert [line.split("|")[2].strip() for line in lines[2:5]] == ["3", "9", "1"]


def test_the_report_names_its_spread_balls_and_command(record):
    text = optics_report(record)
    assert "10th to the 90th percentile" in text
    assert "Smooth balls of 6.31 and 9.5 mm diameter." in text
    assert "`geotlm-lm report optics --real DIR` at commit" in text


def test_without_balls_none_are_spoken_of(record):
    record.numbers["balls"] = []
    assert "balls'" not in verdict(record)
    assert "## Balls" not in optics_report(record)


@pytest.mark.skipif(not REPORTS.is_dir(), reason="needs the checkout's reports/")
def test_the_table_in_the_checkout_is_the_recorded_runs():
    record = RunRecord.load(REPORTS / "recorded" / "optics.json")
    assert (REPORTS / "optics.md").read_text() == optics_report(record)
