"""`info` and `evaluate` of a released encoder, as a user calls them."""

import json
from functools import partial

import pytest

from geotlm_lm.benchmarks.rows import rows_of
from geotlm_lm.core.record import RunRecord
from geotlm_lm.language.decoder import LanguageSize
from geotlm_lm.training import config, train
from geotlm_lm.training.config import HeadsPreset
from geotlm_lm.training.language import LanguageTraining
from tests.backbone.small_files import write_small
from tests.cli.running import run

TINY = HeadsPreset(
    name="tiny",
    head_clips=16,
    validation_clips=8,
    geometry_epochs=1,
    language_steps=2,
    language_batch=4,
)


@pytest.fixture
def weights(tmp_path):
    return write_small("anytouch2", tmp_path / "file")


def test_a_file_is_described_by_what_it_was_recognised_as(capsys, weights):
    code, out, _ = run(capsys, "info", "--weights", weights, "--heads", 2, "--json")
    facts = json.loads(out)
    assert code == 0
    assert facts["encoder"] == "anytouch2"
    assert facts["patch_tokens"] == [2, 3, 3, 24]
    assert facts["parameters"] > 10_000
    _, out, _ = run(capsys, "info", "--weights", weights, "--encoder", "anytouch2", "--heads", 2)
    assert "title: AnyTouch 2" in out.splitlines()


def test_a_file_of_another_encoder_ends_with_one_sentence(capsys, weights):
    code, out, err = run(capsys, "info", "--weights", weights, "--encoder", "unit")
    assert (code, out, err.count("\n")) == (4, "", 1)
    assert "is not UniT: missing encoder.conv_in.weight" in err


@pytest.mark.parametrize("arguments", [[], ["--clip", "a.npy", "--weights", "b.pth"]])
def test_info_describes_either_a_recording_or_a_file(capsys, arguments):
    code, out, err = run(capsys, "info", *arguments)
    assert (code, out) == (2, "")
    assert (
        err == "give --clip with a recording, or --weights with the file of a released encoder.\n"
    )


def test_an_encoder_is_evaluated_from_its_file_to_the_record(
    capsys, weights, tmp_path, monkeypatch
):
    monkeypatch.setitem(config.HEADS_PRESETS, "tiny", TINY)
    small = partial(LanguageTraining, size=LanguageSize(width=16, layers=1, heads=2, mlp=16))
    monkeypatch.setattr(train, "LanguageTraining", small)
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
        (["--encoder", ""], "--encoder and --heads need --weights with the encoder's file.\n"),
        (
            ["--weights", "a.pth", "--model", "b"],
            "--model and --weights exclude each other: give one of them.\n",
        ),
        (
            ["--preset", "smoke"],
            "--preset and --run-folder need --weights with the encoder's file.\n",
        ),
        (
            ["--run-folder", "a"],
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
        (["--preset", ""], "there is no preset ''; choose one of "),
        ([], "no.pth: "),
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
