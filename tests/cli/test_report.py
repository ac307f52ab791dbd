import pytest
from typer.testing import CliRunner

from geotlm_lm.cli.report import app
from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.readme import UnusableReadme

BLOCK = "<!-- begin: accuracy -->\n<!-- end: accuracy -->\n"


@pytest.fixture
def invoke(tmp_path):
    (tmp_path / "README.md").write_text(BLOCK)
    RunRecord("evaluate", "geotlm-lm evaluate", 0, 1.0, {"tables": {}}).save(
        tmp_path / "recorded" / "evaluate.json"
    )
    places = ["--readme", str(tmp_path / "README.md"), "--records", str(tmp_path / "recorded")]
    return lambda *arguments: CliRunner().invoke(app, ["readme", *places, *arguments])


def test_the_readme_is_written_and_then_up_to_date(invoke):
    assert invoke().stdout.endswith("README.md: updated\n")
    assert invoke().stdout.endswith("README.md: already up to date\n")
    assert invoke("--check").exit_code == 0


def test_a_stale_readme_fails_the_check(invoke):
    assert isinstance(invoke("--check").exception, UnusableReadme)


def test_a_cold_answer_is_recorded_with_its_command_and_its_median(tmp_path, monkeypatch):
    from geotlm_lm.experiments import cold_answer

    def answered(clip, question, *, command):
        numbers = {"answer": {"text": f"{clip} {question}"}, "cold_s": [1.0, 2.5, 9.0]}
        return RunRecord("answer", command, 0, 1.0, numbers)

    monkeypatch.setattr(cold_answer, "cold_answer", answered)
    monkeypatch.setattr("sys.argv", ["geotlm-lm", "report", "answer"])
    out = tmp_path / "deep" / "answer.json"
    words = ["answer", "--clip", "clip.npz", "--q", "Which way?", "--out", str(out)]
    done = CliRunner().invoke(app, words)
    assert done.stdout == "clip.npz Which way? (cold: median 2.50 s, 1.00-9.00 s)\n"
    assert RunRecord.load(out).command == "geotlm-lm report answer"


def test_optics_are_recorded_and_tabled(tmp_path, monkeypatch):
    from geotlm_lm.experiments import optics

    def compared(real, *, clips, seed, command, progress):
        numbers = {"rows": [], "balls": [], "touches": {}}
        config = {"real": str(real), "clips": clips, "spread": [0.1, 0.9]}
        return RunRecord("optics", command, seed, 1.0, numbers, config)

    monkeypatch.setattr(optics, "compare_optics", compared)
    monkeypatch.setattr("sys.argv", ["geotlm-lm", "report", "optics"])
    out, table = tmp_path / "deep" / "optics.json", tmp_path / "optics.md"
    words = ["optics", "--real", "real", "--clips", "7", "--seed", "3"]
    done = CliRunner().invoke(app, [*words, "--out", str(out), "--table", str(table)])
    assert done.stdout == "0 of 0 simulated medians lie inside the real spread.\n"
    assert RunRecord.load(out).config["clips"] == 7
    assert RunRecord.load(out).seed == 3
    assert table.read_text().startswith("# Simulator: its images beside real ones\n")


def test_closed_forms_are_recorded_and_tabled_with_their_command(tmp_path, monkeypatch):
    from geotlm_lm.experiments import closed_forms

    def solved(*, command, progress):
        return RunRecord("closed_forms", command, 0, 1.0, {"rows": [], "laws": {"mirror": 1e-12}})

    monkeypatch.setattr(closed_forms, "closed_forms", solved)
    monkeypatch.setattr("sys.argv", ["geotlm-lm", "report", "closed-forms"])
    out, table = tmp_path / "deep" / "forms.json", tmp_path / "forms.md"
    words = ["closed-forms", "--out", str(out), "--table", str(table)]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0
    assert RunRecord.load(out).command == "geotlm-lm report closed-forms"
    assert "| mirror |" in table.read_text()
    assert table.read_text().startswith("# Simulator: closed forms and orders of convergence\n")


def test_confusions_are_drawn_beside_the_page_that_shows_them(tmp_path, monkeypatch):
    from geotlm_lm.reports import confusions

    drawn = []
    monkeypatch.setattr(
        confusions, "draw_confusions", lambda record, folder: drawn.append(folder) or [folder / "a"]
    )
    record = tmp_path / "reports" / "recorded" / "evaluate.json"
    RunRecord("evaluate", "", 0, 1.0, {"tables": {}}).save(record)
    done = CliRunner().invoke(app, ["confusions", "--record", str(record)])
    folder = tmp_path / "reports" / "confusions"
    assert drawn == [folder]
    assert done.stdout == f"{folder / 'a'}\n"
    CliRunner().invoke(app, ["confusions", "--record", str(record), "--out", str(tmp_path / "b")])
    assert drawn[-1] == tmp_path / "b"


def test_a_missing_record_names_the_command_that_writes_it(tmp_path):
    path = tmp_path / "evaluate.json"
    error = CliRunner().invoke(app, ["confusions", "--record", str(path)]).exception
    assert str(error) == (
        f"{path}: no such record; write it with `geotlm-lm evaluate --out {path}`."
    )


def test_the_models_stability_is_recorded_tabled_and_drawn(tmp_path, monkeypatch):
    from geotlm_lm import answering
    from geotlm_lm.experiments import model_stability

    row = {"group": "extreme", "case": "black", "level": "-", "unit": "", "clips": 1}
    row |= dict.fromkeys(("right", "wrong", "abstained", "crashed", "false_directions"), 0)
    row |= dict.fromkeys(("confident_false_directions", "confident_oversights"), 0)
    row |= {"refused": 1, "says": "x: is black", "slowest_s": 0.25}
    row |= dict.fromkeys(("accuracy_of_answers", "confidence", "confidence_wrong"))

    def stressed(answerer, *, seed, clips, command, progress):
        tables = dict.fromkeys(("mass_floor", "gradients", "precision", "scales"), [])
        numbers = {"rows": [row], **tables}
        return RunRecord("stability", command, seed, 1.0, numbers, {"clips": clips})

    monkeypatch.setattr(model_stability, "model_stability", stressed)
    monkeypatch.setattr(answering.Answerer, "load", classmethod(lambda cls, folder: folder))
    monkeypatch.setattr("sys.argv", ["geotlm-lm", "report", "stability"])
    places = {"--out": tmp_path / "s.json", "--table": tmp_path / "s.md"}
    words = [word for option, path in places.items() for word in (option, str(path))]
    done = CliRunner().invoke(app, ["stability", "--clips", "3", "--seed", "5", *words])
    assert done.exit_code == 0, done.exception
    assert done.stdout.splitlines()[:2] == [
        "- crashed: none of 1 rows",
        "- a wrong direction at 0.9 or more: none",
    ]
    record = RunRecord.load(tmp_path / "s.json")
    assert (record.seed, record.config["clips"]) == (5, 3)
    assert (tmp_path / "s.md").read_text().startswith("# The model under stress\n")


def test_an_unknown_size_of_the_runtime_report_is_refused_before_a_model_is_loaded(tmp_path):
    done = CliRunner().invoke(app, ["runtime", "--size", "huge"])
    assert str(done.exception) == "--size 'huge' is unknown, expected default or tiny."


def fuzzed(findings):
    def fuzz(targets, seconds, found, *, seed, command, progress):
        counts = {"runs": 1200, "read": 200, "refused": 1000, "kept": 9, "pairs": 70}
        numbers = {"targets": dict.fromkeys(targets, counts), "findings": findings}
        return RunRecord("fuzz", command, seed, seconds, numbers)

    return fuzz


def run_fuzz(tmp_path, monkeypatch, findings, *words):
    from geotlm_lm.fuzzing import run

    monkeypatch.setattr(run, "fuzz", fuzzed(findings))
    places = ["--out", str(tmp_path / "fuzz.json"), "--table", str(tmp_path / "fuzz.md")]
    return CliRunner().invoke(app, ["fuzz", *places, *words])


def test_fuzzing_is_recorded_and_tabled(tmp_path, monkeypatch):
    done = run_fuzz(tmp_path, monkeypatch, [], "--target", "array", "--target", "avi")
    assert done.stdout.startswith("2,400 inputs: none crashed, hung, ")
    assert RunRecord.load(tmp_path / "fuzz.json").seconds == 600
    table = (tmp_path / "fuzz.md").read_text()
    assert "| array  |  1,200 |  200 |   1,000 |" in table


def test_a_finding_fails_the_command_and_is_listed(tmp_path, monkeypatch):
    finding = {"target": "avi", "kind": "crash", "said": "ended with -11"}
    done = run_fuzz(tmp_path, monkeypatch, [finding], "--found", "kept")
    assert str(done.exception) == (
        f"Fuzzing found something (1 kinds, listed in {tmp_path}/fuzz.md); the inputs lie in kept."
    )
    assert "- avi: crash: `ended with -11`" in (tmp_path / "fuzz.md").read_text()


def test_a_target_that_is_not_there_is_told(tmp_path, monkeypatch):
    done = run_fuzz(tmp_path, monkeypatch, [], "--target", "teapot")
    assert str(done.exception).startswith("There is no fuzzing target 'teapot', expected one of ")
