import json

import pytest
from typer.testing import CliRunner

from geotlm_lm.cli.report import app
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.record import RunRecord


@pytest.fixture
def invoke(tmp_path, monkeypatch):
    """Runs the command with a stand-in for model and run; the options given lie in `.given`."""
    from geotlm_lm import answering
    from geotlm_lm.experiments import language_talk

    def run(answerer, **options):
        invoked.given = options
        options["progress"]("simulated, asked", 7, 7)
        return RunRecord("language", options["command"], options["seed"], 1.0, {"sets": {}})

    def invoked(*arguments):
        places = ["--out", str(tmp_path / "a" / "l.json"), "--table", str(tmp_path / "b" / "l.md")]
        return CliRunner().invoke(app, ["language", *places, *arguments])

    monkeypatch.setattr(answering.Answerer, "load", classmethod(lambda cls, folder=None: folder))
    monkeypatch.setattr(language_talk, "evaluate_talk", run)
    return invoked


def test_options_reach_the_run(invoke, tmp_path):
    result = invoke("--clips", "7", "--real", str(tmp_path), "--windows", "3", "--seed", "2")
    assert result.exit_code == 0
    given = invoke.given
    assert (given["clips"], given["windows"], given["seed"]) == (7, 3, 2)
    assert given["real_folder"] == tmp_path


def test_the_record_and_the_page_are_written(invoke, tmp_path):
    invoke()
    assert RunRecord.load(tmp_path / "a" / "l.json").name == "language"
    assert (tmp_path / "b" / "l.md").read_text().startswith("# Language: every question type")


def test_the_last_line_is_the_record_when_json_is_asked_for(invoke):
    assert json.loads(invoke("--json").stdout.splitlines()[-1])["numbers"] == {"sets": {}}


def test_progress_goes_to_stderr_only(invoke):
    result = invoke()
    assert "simulated, asked: 7 of 7 clips" in result.stderr
    assert "7 of 7" not in result.stdout


def test_nothing_to_ask_about_is_refused(invoke):
    error = invoke("--clips", "0").exception
    assert isinstance(error, UsageError)
    assert str(error) == ("nothing to ask about: give --clips above 0, or --real with a folder.")


def test_the_transcript_is_written_and_counted(tmp_path, monkeypatch):
    from geotlm_lm import answering
    from geotlm_lm.experiments import transcript

    def run(answerer, *, model_name, command):
        numbers = {"questions": 2, "as_wanted": 1, "turns": []}
        return RunRecord("transcript", command, 0, 1.0, numbers, {"model": model_name})

    monkeypatch.setattr(answering.Answerer, "load", classmethod(lambda cls, folder=None: folder))
    monkeypatch.setattr(transcript, "transcript", run)
    out, table = tmp_path / "a" / "t.json", tmp_path / "b" / "t.md"
    places = ["--out", str(out), "--table", str(table), "--model", "some/tiny"]
    result = CliRunner().invoke(app, ["transcript", *places])
    assert result.stdout == f"1 of 2 as wanted: {table}\n"
    assert RunRecord.load(out).config == {"model": "tiny"}
    assert "1 of 2 answers are as wanted." in table.read_text()


@pytest.mark.parametrize("name", ["language", "transcript"])
def test_a_written_page_is_the_one_the_records_make(name, tmp_path, monkeypatch):
    from geotlm_lm import answering
    from geotlm_lm.experiments import language_talk, transcript
    from geotlm_lm.reports.readme import check_readme

    turn = {"clip": "a", "before": [], "question": "Up?", "answer": "No.", "as_wanted": False}
    turn |= {"wanted": {"kind": "x", "decided": "y"}, "found": {"kind": None, "decided": "no"}}
    turn |= {"confidence": 0.5, "told_by": "rule", "note": ""}
    numbers = {"sets": {}, "questions": 1, "as_wanted": 0, "turns": [turn]}

    def run(answerer, **options):
        return RunRecord(name, "geotlm-lm", 0, 1.0, numbers)

    monkeypatch.setattr(answering.Answerer, "load", classmethod(lambda cls, folder=None: folder))
    monkeypatch.setattr(language_talk, "evaluate_talk", run)
    monkeypatch.setattr(transcript, "transcript", run)
    out, table = tmp_path / "recorded" / f"{name}.json", tmp_path / f"{name}.md"
    result = CliRunner().invoke(app, [name, "--out", str(out), "--table", str(table)])
    assert result.exit_code == 0
    (tmp_path / "README.md").write_text("no blocks\n")
    check_readme(tmp_path / "README.md", tmp_path / "recorded")
