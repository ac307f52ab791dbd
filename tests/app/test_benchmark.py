"""The Benchmark tab shows what was recorded, and says when nothing was."""

import json

import pytest

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


def test_the_tab_says_when_plain_optical_flow_is_the_better_choice_as_recorded():
    told = benchmark_tab.introduction(benchmark_tab.clip_rows())
    errors = {(row["case"], row["variant"]): row["error"] for row in benchmark_tab.clip_rows()}
    case = "real physiclear, pairs, report"
    assert errors[case, benchmark_tab.FLOW] <= errors[case, benchmark_tab.WORDS]
    assert told.count(". ") == 1
    assert "Plain optical flow is the better choice where you only need to know" in told


@pytest.mark.parametrize(
    ("errors", "told"),
    [
        ((0.2, 0.1), "the better choice where you only need to know which of two ways something "
         "turns, or which of four it slides: it was right at least as often on 1 of 1 sets"),
        ((0.1, 0.2), "mostly behind even where you only need to know which of two ways something "
         "turns, or which of four it slides: it was right at least as often on 0 of 1 sets"),
    ],
)  # fmt: skip
def test_whether_optical_flow_is_better_is_judged_on_real_sets_that_nothing_was_chosen_by(
    errors, told
):
    methods = zip((benchmark_tab.WORDS, benchmark_tab.FLOW), errors, strict=True)
    rows = [
        {"case": "real sensor, report", "variant": name, "error": error, "ms_p50": 5.0}
        for name, error in methods
    ]
    left_out = [row | {"case": "real sensor, tune", "error": 0.5} for row in rows]
    assert told in benchmark_tab.introduction(rows + left_out)
    assert "sets of real" not in benchmark_tab.introduction(left_out)


def test_nothing_recorded_gives_no_rows(tmp_path):
    assert benchmark_tab.accuracy_rows(tmp_path) == benchmark_tab.record_rows(tmp_path) == []
