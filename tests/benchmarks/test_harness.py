"""The harness: sections run once, records keep the rest, pages say what records say."""

import json
from dataclasses import replace
from functools import partial

import cv2
import pytest
import torch

from geotlm_lm.benchmarks import benches
from geotlm_lm.benchmarks.benches import ACCURACY, run_bench
from geotlm_lm.benchmarks.harness import Bench, Pivot, Row, Run, Section, rows_of, whole
from geotlm_lm.benchmarks.rendering import (
    StaleResults,
    check_results,
    page,
    render_results,
    save_figure,
    save_results,
    table,
)
from geotlm_lm.core.errors import UsageError
from geotlm_lm.runs.run import ALONE, Workers


def headline(rows):
    return f"{len(rows)} rows, worst {max(row.error for row in rows)}"


def draw(rows, path):
    from matplotlib.figure import Figure

    save_figure(Figure(figsize=(1, 1)), rows, path)


@pytest.fixture
def toy():
    """Two sections; the list tells which were run."""
    ran = []

    def section(name):
        def rows(run):
            ran.append(name)
            assert (torch.get_num_threads(), cv2.getNumThreads()) == (1, 1)
            yield Row(f"{name} clips", "words", 4, 0.25, interval=(0.1, 0.5), ms_p50=1.5)
            yield Row(f"{name} clips", "flow", 4, run.size(0.5, 1.0), detail={"seed": run.seed})

        view = Pivot("error:.2f")
        about = f"About {name}."
        return Section(name, name.title(), about, whole(rows), {"": view}, headline=headline)

    return Bench("toy", "Toy", "About all.", (section("first"), section("second"))), ran


def test_a_row_survives_json():
    row = Row("clips", "words", 3, 0.25, interval=(0.1, 0.5), ms_p50=2.0, detail={"a": [1]})
    assert Row.from_dict(json.loads(json.dumps(row.to_dict()))) == row
    assert Row.from_dict(Row("a", "b", error=0.0).to_dict()).error == 0.0


def test_a_bench_runs_its_sections_in_order_on_one_thread(toy):
    (bench, ran), before = toy, (torch.get_num_threads(), cv2.getNumThreads())
    record = run_bench(bench, Run(seed=3))
    assert ran == ["first", "second"]
    assert [row.variant for row in rows_of(record, "second")] == ["words", "flow"]
    assert rows_of(record, "second")[1].detail == {"seed": 3}
    assert "prove nothing" not in page(bench, record)
    assert (torch.get_num_threads(), cv2.getNumThreads()) == before


def test_only_one_section_is_run_and_the_others_kept(toy):
    bench, ran = toy
    before = run_bench(bench, Run(is_quick=True), command="the first")
    assert "prove nothing" in page(bench, before)
    after = run_bench(bench, Run(), only=["second"], before=before, command="another")
    assert ("`the first`" in page(bench, after), "`another`" in page(bench, after)) == (True, True)
    assert ran == ["first", "second", "second"]
    assert rows_of(after, "first") == rows_of(before, "first")
    assert rows_of(after, "second")[1].error == 0.5


def test_an_unknown_section_is_refused(toy):
    expected = "^--only 'fourth' is unknown; choose one of first, second[.]$"
    with pytest.raises(UsageError, match=expected):
        run_bench(toy[0], Run(), only=["fourth"])


def test_a_stopped_run_goes_on_where_it_was_at_the_same_commit_only(toy, tmp_path, monkeypatch):
    bench, ran = toy
    for commit in ("abc", "abc", "def", "def+", "def+"):
        monkeypatch.setattr(benches, "commit", lambda commit=commit: commit)
        run_bench(bench, Run(folder=tmp_path))
    # Once for abc, once for def; a changed checkout is never taken for its commit.
    assert ran == ["first", "second"] * 4


def test_a_stopped_run_keeps_the_shares_that_it_had_of_a_section(toy, tmp_path, monkeypatch):
    bench, ran, stops = toy[0], [], [True, False]

    def share(name):
        if name == "b" and stops.pop(0):
            raise KeyboardInterrupt
        ran.append(name)
        return [Row(name, "words", 1, 0.5)]

    def shares(run):
        return {name: partial(share, name) for name in "ab"}

    bench = replace(bench, sections=(replace(bench.sections[0], shares=shares),))
    monkeypatch.setattr(benches, "commit", lambda: "abc")
    with pytest.raises(KeyboardInterrupt):
        run_bench(bench, Run(folder=tmp_path))
    record = run_bench(bench, Run(folder=tmp_path))
    assert ran == ["a", "b"]
    assert [row.case for row in rows_of(record, "first")] == ["a", "b"]


@pytest.mark.slow
@pytest.mark.usefixtures("answerer")  # skipped without the shipped model
def test_two_processes_measure_what_one_does():
    def measured(workers):
        run = Run(seed=3, clips=2, workers=workers)
        record = run_bench(ACCURACY, run, only=["clips"])
        return [replace(row, ms_p50=None, ms_p95=None) for row in rows_of(record, "clips")]

    assert measured(Workers(2)) == measured(ALONE)


def test_a_pivot_has_a_line_per_case_and_a_column_per_variant():
    rows = [Row("a", "words", 2, 0.5), Row("a", "flow", 3, 0.0), Row("b", "flow", 1, 1.0)]
    lines = table(Pivot("error:g"), rows).splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    assert cells[0] == ["clips", "n", "words", "flow"]
    assert cells[2:] == [["a", "3", "0.5", "0"], ["b", "1", "-", "1"]]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("<!-- begin: toy.first -->\n", "block 'toy.first' is not closed; add the line"),
        ("<!-- begin: toy.x -->\n<!-- end: toy.x -->\n", "block 'toy.x' is not known; expected"),
        (
            "<!-- begin: other.first -->\n<!-- end: other.first -->\n",
            "block 'other.first' has no record; write it with `geotlm-lm bench other",
        ),
    ],
)
def test_a_block_that_cannot_be_filled_is_refused(toy, tmp_path, text, says):
    bench, readme = toy[0], tmp_path / "README.md"
    readme.write_text(text)
    save_results(bench, run_bench(bench, Run()), tmp_path)
    other = Bench("other", "Other", "About it.", bench.sections)
    with pytest.raises(StaleResults, match=says):
        render_results([bench, other], tmp_path, readme)


def test_a_picture_of_other_numbers_is_detected(toy, tmp_path):
    pytest.importorskip("matplotlib", reason="pictures need matplotlib (extra: eval)")
    first, *others = toy[0].sections
    bench = replace(toy[0], sections=(replace(first, figure=draw), *others))
    readme, folder = tmp_path / "README.md", tmp_path / "results"
    readme.write_text("")
    save_results(bench, run_bench(bench, Run()), folder)
    check_results([bench], folder, readme)
    draw([Row("other", "x")], folder / "toy_first.png")
    with pytest.raises(StaleResults, match="toy_first.png: is missing or shows other numbers"):
        check_results([bench], folder, readme)
