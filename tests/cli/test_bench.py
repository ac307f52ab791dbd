"""`geotlm-lm bench` as a user types it, over a bench of one small section."""

import json

import pytest

from geotlm_lm.benchmarks import benches
from geotlm_lm.benchmarks.harness import Bench, Pivot, Row, Section, whole
from geotlm_lm.core.record import RunRecord
from tests.cli.running import run


@pytest.fixture
def given(monkeypatch):
    """Replaces the four benches by small ones; returns the runs they were given."""
    runs = []

    def rows(run):
        runs.append(run)
        run.progress("clips", 2, 2)
        yield Row("clips", "words", 2, 0.5)

    view = Pivot("error:g")
    section = Section(
        "only",
        "Only",
        "About it.",
        whole(rows),
        {"": view},
        headline=lambda rows: f"{len(rows)} rows",
    )
    small = {
        name: Bench(name, name.title(), "About all.", (section,))
        for name in ("accuracy", "pareto", "stability", "omissions", "loop")
    }
    monkeypatch.setattr(benches, "BENCHES", small)
    return runs


@pytest.fixture
def invoke(capsys):
    return lambda *arguments: run(capsys, "bench", *arguments)


@pytest.mark.parametrize("name", ["accuracy", "pareto", "stability", "omissions", "loop"])
def test_options_reach_the_run_and_the_page_is_printed(given, invoke, tmp_path, name):
    code, out, err = invoke(name, "--quick", "--seed", 4, "--real", tmp_path)
    assert code == 0
    (one,) = given
    assert (one.is_quick, one.seed, one.real) == (True, 4, tmp_path)
    assert out.startswith(f"# {name.title()}")
    assert "clips: 2 of 2" in err


def test_record_and_page_are_written_where_asked(given, invoke, tmp_path):
    out = tmp_path / "deep" / "results"
    told = invoke("pareto", "--quick", "--out", out, "--json")[1]
    assert RunRecord.load(out / "records" / "pareto.json").name == "pareto"
    assert (out / "pareto.md").read_text().startswith("# Pareto")
    assert json.loads(told.splitlines()[-1])["config"]["size"] == "quick"


def test_a_quick_run_never_replaces_a_whole_one(given, invoke, tmp_path):
    assert invoke("stability", "--out", tmp_path)[0] == 0
    code, out, err = invoke("stability", "--quick", "--out", tmp_path)
    assert (code, out) == (2, "")
    assert err.startswith(f"--out: {tmp_path}/records/stability.json is the record of a")


def test_recordings_that_are_no_folder_are_refused(given, invoke, tmp_path):
    told = f"--real: {tmp_path}/gone is no folder, expected one of labelled recordings.\n"
    assert invoke("pareto", "--real", tmp_path / "gone") == (2, "", told)
    assert given == []


def test_a_released_encoder_reaches_the_run_whole(given, invoke, tmp_path):
    weights = tmp_path / "released.pth"
    assert invoke("accuracy", "--quick", "--weights", weights, "--encoder", "t3")[0] == 0
    assert (given[0].encoder.weights, given[0].encoder.name) == (weights, "t3")
    assert invoke("accuracy", "--encoder", "t3")[0] == 2


def test_render_fills_the_readme_and_check_agrees_afterwards(given, invoke, tmp_path):
    readme, results = tmp_path / "README.md", tmp_path / "results"
    readme.write_text("<!-- begin: pareto.only -->\n<!-- end: pareto.only -->\nAfter.\n")
    invoke("pareto", "--out", results)
    places = ("--results", results, "--readme", readme)
    assert "its numbers differ" in invoke("render", "--check", *places)[2]
    assert invoke("render", *places)[1] == "1 files changed.\n"
    assert invoke("render", "--check", *places)[0] == 0
    assert "1 rows" in readme.read_text()
    assert readme.read_text().endswith("\nAfter.\n")
    page = results / "pareto.md"
    page.write_text(page.read_text().replace("0.5", "0.05"))
    assert "pareto.md: its numbers differ" in invoke("render", "--check", *places)[2]
