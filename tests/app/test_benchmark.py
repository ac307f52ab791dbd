"""The Benchmark tab shows what was recorded, and says when nothing was."""

import json

from app import benchmark_tab


def test_every_recorded_accuracy_is_a_row_with_its_error():
    record = json.loads((benchmark_tab.RECORDED / "accuracy.json").read_text())
    recorded = record["numbers"]["sections"]["clips"]["rows"]
    rows = benchmark_tab.accuracy_rows()
    assert len(rows) == len(recorded)
    for row, one in zip(rows, recorded, strict=True):
        assert row[:3] == [one["case"], one["count"], one["variant"]]
        assert row[4] - 1e-4 <= row[3] <= row[5] + 1e-4
        assert abs(row[3] + row[6] - 1) < 2e-4


def test_every_recorded_run_is_listed_with_its_command():
    runs = benchmark_tab.record_rows()
    assert len(runs) == len(list(benchmark_tab.RECORDED.glob("*.json")))
    assert all(row[1].startswith("geotlm-lm ") for row in runs)


def test_nothing_recorded_gives_no_rows(tmp_path):
    assert benchmark_tab.accuracy_rows(tmp_path) == benchmark_tab.record_rows(tmp_path) == []
