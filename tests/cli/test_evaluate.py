import json
from types import SimpleNamespace

import pytest

from geotlm_lm.benchmarks.rows import Bench, Pivot, Row, Section, every
from geotlm_lm.cli.recorded import command_line
from geotlm_lm.core.record import RunRecord
from tests.cli.running import run


@pytest.fixture
def judged(monkeypatch):
    """Replaces the model and the bench; returns the runs that the bench was given."""
    from geotlm_lm import answering
    from geotlm_lm.benchmarks import accuracy

    given = []

    def rows(run):
        given.append(run)
        run.progress("simulated rotation", 5, 5)
        yield Row("simulated rotation", "words", 5, 0.2, interval=(0.1, 0.3))

    view = (Pivot(lambda row: f"{row.error:g}"), every)
    bench = Bench("evaluate", "Mine", "", (Section("clips", "Clips", "", rows, {"": view}),))
    bundle = SimpleNamespace(digest=lambda: "0123456789ab")
    load = classmethod(lambda cls, folder: SimpleNamespace(bundle=bundle))
    monkeypatch.setattr(answering.Answerer, "load", load)
    monkeypatch.setattr(accuracy, "EVALUATION", bench)
    return given


@pytest.fixture
def invoke(capsys):
    return lambda *arguments: run(capsys, "evaluate", *arguments)


def test_options_reach_the_run(judged, invoke, tmp_path):
    options = ("--clips", 7, "--seed", 3, "--real", tmp_path, "--model", "some/tiny")
    assert invoke(*options)[0] == 0
    assert (judged[0].clips, judged[0].seed, judged[0].real) == (7, 3, tmp_path)


def test_progress_goes_to_stderr_only(judged, invoke):
    _, out, err = invoke()
    assert "simulated rotation: 5 of 5 clips" in err
    assert "5 of 5" not in out


def test_the_last_line_is_the_record_when_json_is_asked_for(judged, invoke):
    record = json.loads(invoke("--json")[1].splitlines()[-1])
    assert record["numbers"]["sections"]["clips"]["rows"][0]["error"] == 0.2
    assert record["config"]["model_digest"] == "0123456789ab"


def test_the_record_is_written_where_asked(judged, invoke, tmp_path):
    invoke("--out", tmp_path / "deep" / "run.json")
    assert RunRecord.load(tmp_path / "deep" / "run.json").name == "evaluate"


@pytest.mark.parametrize(
    ("option", "name"), [("--data", "clips.csv"), ("--real", "mini/clips.csv")]
)
def test_the_record_never_replaces_what_it_judges(judged, invoke, tmp_path, option, name):
    table = tmp_path / name
    table.parent.mkdir(exist_ok=True)
    table.write_text("clip_id\n")
    read = table if option == "--data" else tmp_path
    code, out, err = invoke(option, read, "--out", table)
    assert (code, out) == (2, "")
    assert err.startswith(f"--out: {table} is read by this command and would be replaced")
    assert table.read_text() == "clip_id\n"


def test_falling_below_the_minimum_is_an_error_of_its_own(judged, invoke):
    code, _, err = invoke("--min-accuracy", "0.9")
    assert (code, err.splitlines()[-1]) == (
        6,
        "the lowest accuracy of the model's words is 0.800, expected at least 0.9; see the tables "
        "above.",
    )
    assert invoke("--min-accuracy", "0.8")[0] == 0


def test_nothing_to_judge_is_refused(judged, invoke):
    assert invoke("--clips", 0)[0] == 2


def test_the_recorded_command_is_what_a_user_types(monkeypatch):
    monkeypatch.setattr("sys.argv", ["/some/bin/x", "evaluate", "--real", "my clips"])
    assert command_line() == "geotlm-lm evaluate --real 'my clips'"


def test_data_sets_reach_the_run(judged, invoke, tmp_path):
    paths = [tmp_path / "trials", tmp_path / "touchd.csv"]
    words = [word for path in paths for word in ("--data", path)]
    assert invoke("--clips", 0, *words)[0] == 0
    assert list(judged[0].data) == paths


def test_a_record_replaces_an_earlier_record_and_nothing_else(judged, invoke, tmp_path):
    out = tmp_path / "run.json"
    for _ in range(2):
        assert invoke("--out", out)[0] == 0
    for mine in ('{"my": "settings"}', "notes"):
        out.write_text(mine)
        assert invoke("--out", out)[2] == (
            f"--out: {out} holds something else than a run's record and would be replaced, "
            f"expected a new file or an earlier record; give another name.\n"
        )
        assert out.read_text() == mine
    out.write_text("")
    assert invoke("--out", out)[0] == 0


def test_a_record_goes_to_no_device(judged, invoke):
    told = "--out: /dev/null is no regular file, expected the name of one.\n"
    assert invoke("--out", "/dev/null") == (2, "", told)
