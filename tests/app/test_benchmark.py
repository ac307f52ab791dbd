"""The Benchmark tab shows what was recorded, and says when nothing was."""

import json

from app import benchmark_tab


def test_every_recorded_accuracy_is_a_row_with_its_error():
    tables = json.loads((benchmark_tab.RECORDED / "evaluate.json").read_text())["numbers"]["tables"]
    rows = benchmark_tab.accuracy_rows()
    assert len(rows) == sum(len(table["methods"]) for table in tables.values())
    name, table = next(iter(tables.items()))
    method, scores = next(iter(table["methods"].items()))
    row = next(row for row in rows if (row[0], row[2]) == (name, method))
    assert row[1] == table["clips"]
    assert abs(row[3] - scores["accuracy"]) < 1e-4
    assert abs(row[6] - (1 - scores["accuracy"])) < 1e-4


def test_every_recorded_run_is_listed_with_its_command():
    runs = benchmark_tab.record_rows()
    assert len(runs) == len(list(benchmark_tab.RECORDED.glob("*.json")))
    assert all(row[1].startswith("geotlm-lm ") for row in runs)


def test_nothing_recorded_gives_no_rows(tmp_path):
    assert benchmark_tab.accuracy_rows(tmp_path) == benchmark_tab.record_rows(tmp_path) == []
