"""`evaluate` hands its options on, and writes a record; of an encoder's file as of the model."""

import json
from types import SimpleNamespace

import pytest

from geotlm_lm.benchmarks.harness import Bench, Pivot, Row, Section, rows_of, whole
from geotlm_lm.cli.options import command_line
from geotlm_lm.core.record import RunRecord
from geotlm_lm.training import config
from geotlm_lm.training.config import HeadsPreset
from tests.backbone.small_files import write_small
from tests.cli.running import run


@pytest.fixture
def judged(monkeypatch):
    """Replaces the model and the bench; returns the runs that the bench was given."""
    from geotlm_lm import answering
    from geotlm_lm.benchmarks import benches

    given = []

    def rows(run):
        given.append(run)
        run.progress("simulated rotation", 5, 5)
        yield Row("simulated rotation", "words", 5, 0.2, interval=(0.1, 0.3))

    view = Pivot("error:g")
    bench = Bench("evaluate", "Mine", "", (Section("clips", "Clips", "", whole(rows), {"": view}),))
    bundle = SimpleNamespace(digest=lambda: "0123456789ab")
    load = classmethod(lambda cls, folder: SimpleNamespace(bundle=bundle))
    monkeypatch.setattr(answering.Answerer, "load", load)
    monkeypatch.setattr(benches, "EVALUATION", bench)
    return given


@pytest.fixture
def invoke(capsys):
    return lambda *arguments: run(capsys, "evaluate", *arguments)


def test_options_reach_the_run(judged, invoke, tmp_path):
    data = [tmp_path / "trials", tmp_path / "touchd.csv"]
    options = ("--clips", 7, "--seed", 3, "--real", tmp_path, "--model", "some/tiny")
    options += ("--data", data[0], "--data", data[1])
    code, out, err = invoke(*options)
    assert code == 0
    assert (judged[0].clips, judged[0].seed, judged[0].real) == (7, 3, tmp_path)
    assert list(judged[0].data) == data
    assert "simulated rotation: 5 of 5 clips" in err
    assert "5 of 5" not in out


def test_the_record_is_the_last_line_and_is_written_where_asked(judged, invoke, tmp_path):
    written = tmp_path / "deep" / "run.json"
    record = json.loads(invoke("--json", "--out", written)[1].splitlines()[-1])
    assert RunRecord.load(written).name == "evaluate"
    assert record["numbers"]["sections"]["clips"]["rows"][0]["error"] == 0.2
    assert record["config"]["model_digest"] == "0123456789ab"


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


TINY = HeadsPreset(
    name="tiny",
    head_clips=16,
    validation_clips=8,
    geometry_epochs=1,
    answer_clips=3,
    slots_steps=2,
    sentences_steps=2,
    language_batch=4,
)


@pytest.fixture
def weights(tmp_path):
    return write_small("anytouch2", tmp_path / "file")


@pytest.mark.slow
def test_an_encoder_is_evaluated_from_its_file_to_the_record(
    capsys, weights, tmp_path, monkeypatch
):
    monkeypatch.setitem(config.HEADS_PRESETS, "tiny", TINY)
    arguments = ["evaluate", "--encoder", "anytouch2", "--weights", weights, "--heads", 2]
    arguments += ["--preset", "tiny", "--run-folder", tmp_path / "run", "--clips", 2]
    code, out, _ = run(capsys, *arguments, "--out", tmp_path / "first.json")
    assert code == 0
    assert "linear probe" in out
    record = RunRecord.load(tmp_path / "first.json")
    assert record.config["model"] == "AnyTouch 2 (checkpoint.pth)"
    assert record.config["encoder"]["encoder"] == "anytouch2"
    assert {row.case for row in rows_of(record, "clips")} == {
        f"simulated {task}" for task in ("rotation", "sliding", "all")
    }
    run(capsys, *arguments, "--out", tmp_path / "second.json")
    second = RunRecord.load(tmp_path / "second.json")
    assert second.config["model_digest"] == record.config["model_digest"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--encoder", "t3"], "--encoder and --heads need --weights with the encoder's file.\n"),
        (
            ["--weights", "a.pth", "--model", "b"],
            "--model and --weights exclude each other: give one of them.\n",
        ),
        (
            ["--preset", "smoke"],
            "--preset and --run-folder need --weights with the encoder's file.\n",
        ),
    ],
)
def test_options_that_do_not_go_together_are_refused(capsys, arguments, sentence):
    assert run(capsys, "evaluate", *arguments) == (2, "", sentence)


@pytest.mark.parametrize(
    ("options", "begins"),
    [
        (["--preset", "nope"], "there is no preset 'nope'; choose one of "),
        (["--out", "new/x.json", "--run-folder", "new/run"], "no.pth: "),
    ],
)
def test_an_evaluation_that_is_refused_leaves_no_folder_behind(
    capsys, tmp_path, monkeypatch, options, begins
):
    monkeypatch.chdir(tmp_path)
    code, _, err = run(capsys, "evaluate", "--weights", "no.pth", *options)
    assert code != 0
    assert err.startswith(begins)
    assert list(tmp_path.iterdir()) == []
