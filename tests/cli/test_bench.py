"""`geotlm-lm bench` as a user types it, over a bench of one small section."""

import json

import pytest
from typer.testing import CliRunner

from geotlm_lm.benchmarks import benches
from geotlm_lm.benchmarks.rows import Bench, Pivot, Row, Section, every
from geotlm_lm.cli import bench as command
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.record import RunRecord


@pytest.fixture
def given(monkeypatch):
    """Replaces the four benches by small ones; returns the runs they were given."""
    runs = []

    def rows(run):
        runs.append(run)
        run.progress("clips", 2, 2)
        yield Row("clips", "words", 2, 0.5)

    view = (Pivot(lambda row: f"{row.error:g}"), every)
    section = Section(
        "only", "Only", "About it.", rows, {"": view}, headline=lambda rows: f"{len(rows)} rows"
    )
    small = {
        name: Bench(name, name.title(), "About all.", (section,))
        for name in ("accuracy", "pareto", "stability", "omissions")
    }
    monkeypatch.setattr(benches, "BENCHES", small)
    return runs


def invoke(*arguments):
    return CliRunner().invoke(command.app, list(arguments))


@pytest.mark.parametrize("name", ["accuracy", "pareto", "stability", "omissions"])
def test_options_reach_the_run_and_the_page_is_printed(given, tmp_path, name):
    result = invoke(name, "--quick", "--seed", "4", "--real", str(tmp_path))
    assert result.exit_code == 0
    (run,) = given
    assert (run.is_quick, run.seed, run.real) == (True, 4, tmp_path)
    assert result.stdout.startswith(f"# {name.title()}")
    assert "clips: 2 of 2" in result.stderr


def test_record_and_page_are_written_where_asked(given, tmp_path):
    out = tmp_path / "deep" / "results"
    result = invoke("pareto", "--quick", "--out", str(out), "--json")
    assert RunRecord.load(out / "records" / "pareto.json").name == "pareto"
    assert (out / "pareto.md").read_text().startswith("# Pareto")
    assert json.loads(result.stdout.splitlines()[-1])["config"]["size"] == "quick"


def test_a_quick_run_never_replaces_a_whole_one(given, tmp_path):
    assert invoke("stability", "--out", str(tmp_path)).exit_code == 0
    error = invoke("stability", "--quick", "--out", str(tmp_path)).exception
    assert isinstance(error, UsageError)
    assert str(error).startswith(f"--out: {tmp_path}/records/stability.json is the record of a")


def test_recordings_that_are_no_folder_are_refused(given, tmp_path):
    error = invoke("pareto", "--real", str(tmp_path / "gone")).exception
    assert str(error) == (
        f"--real: {tmp_path}/gone is no folder, expected one of labelled recordings."
    )
    assert given == []


def test_a_released_encoder_reaches_the_run_whole(given, tmp_path):
    weights = tmp_path / "released.pth"
    result = invoke("accuracy", "--quick", "--weights", str(weights), "--encoder", "t3")
    assert result.exit_code == 0
    assert (given[0].encoder.weights, given[0].encoder.name) == (weights, "t3")
    assert isinstance(invoke("accuracy", "--encoder", "t3").exception, UsageError)


def test_render_fills_the_readme_and_check_agrees_afterwards(given, tmp_path):
    readme, results = tmp_path / "README.md", tmp_path / "results"
    readme.write_text("<!-- begin: pareto.only -->\n<!-- end: pareto.only -->\n")
    invoke("pareto", "--out", str(results))
    places = ("--results", str(results), "--readme", str(readme))
    assert "its numbers differ" in str(invoke("render", "--check", *places).exception)
    assert invoke("render", *places).stdout == "1 files changed.\n"
    assert invoke("render", "--check", *places).exit_code == 0
    assert "1 rows" in readme.read_text()
