"""`train` hands its options to the training seam and prints the folder that came out."""

import sys
from pathlib import Path
from types import ModuleType

import pytest

from geotlm_lm.cli.main import main


@pytest.fixture
def calls(monkeypatch):
    made = []

    def train(preset, out, seed, workers, progress):
        made.append((preset, out, seed, workers))
        return out / "bundle"

    module = ModuleType("geotlm_lm.training.train")
    module.train = train
    monkeypatch.setitem(sys.modules, "geotlm_lm.training.train", module)
    return made


def test_options_reach_the_seam_and_the_bundle_is_named(calls, capsys):
    with pytest.raises(SystemExit) as exit_info:
        main(["train", "--preset", "smoke", "--out", "runs/a", "--seed", "3", "--workers", "1"])
    assert exit_info.value.code == 0
    assert calls == [("smoke", Path("runs/a"), 3, 1)]
    assert capsys.readouterr().out == "runs/a/bundle\n"


@pytest.mark.parametrize(
    ("options", "code", "sentence"),
    [
        (["--preset", "huge"], 2, "there is no preset 'huge'; choose one of smoke, default.\n"),
        (
            ["--keep", "gone"],
            4,
            "gone: found no model bundle there (no config.json); give the folder that `geotlm-lm "
            "train` wrote.\n",
        ),
        (["--preset", ""], 2, "there is no preset ''; choose one of smoke, default.\n"),
        (
            ["--keep", "gone", "--preset", "smoke"],
            2,
            "--preset cannot go with --keep, which uses the kept bundle's own; leave out one of "
            "them.\n",
        ),
    ],
)
def test_what_is_refused_leaves_no_folder_behind(
    calls, capsys, tmp_path, monkeypatch, options, code, sentence
):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as exit_info:
        main(["train", "--out", "runs", *options])
    assert (exit_info.value.code, capsys.readouterr().err) == (code, sentence)
    assert list(tmp_path.iterdir()) == []
    assert calls == []


def test_a_bundle_to_keep_reaches_the_other_seam(monkeypatch, capsys):
    made = []
    monkeypatch.setattr("geotlm_lm.checkpoint.read_config", lambda folder: {})

    def retrain_odometer(kept, out, seed, workers, progress):
        made.append((kept, out, seed, workers))
        return out / "bundle"

    module = ModuleType("geotlm_lm.training.retraining")
    module.retrain_odometer = retrain_odometer
    monkeypatch.setitem(sys.modules, "geotlm_lm.training.retraining", module)
    with pytest.raises(SystemExit) as exit_info:
        main(["train", "--keep", "runs/a/bundle", "--out", "runs/b", "--workers", "1"])
    assert exit_info.value.code == 0
    assert made == [(Path("runs/a/bundle"), Path("runs/b"), 0, 1)]
    assert capsys.readouterr().out == "runs/b/bundle\n"
