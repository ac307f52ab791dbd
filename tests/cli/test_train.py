"""`train` hands its options to the training seam and prints the folder that came out."""

import sys
from pathlib import Path
from types import ModuleType

import pytest

from tests.cli.running import run


@pytest.fixture
def calls(monkeypatch):
    made = []

    def train(preset, out, seed, workers, progress, device, start, stage):
        made.append((preset, out, seed, workers, device, start, stage))
        return out / "bundle"

    module = ModuleType("geotlm_lm.training.train")
    module.train = train
    monkeypatch.setitem(sys.modules, "geotlm_lm.training.train", module)
    return made


def test_options_reach_the_seam_and_the_bundle_is_named(calls, capsys):
    options = ("--preset", "smoke", "--out", "runs/a", "--seed", 3, "--workers", 1)
    options += ("--start", "runs/b", "--stage", "slots")
    assert run(capsys, "train", *options)[:2] == (0, "runs/a/bundle\n")
    assert calls == [("smoke", Path("runs/a"), 3, 1, None, Path("runs/b"), "slots")]


@pytest.mark.parametrize("preset", ["huge", ""])
def test_a_preset_that_there_is_not_leaves_no_folder_behind(
    calls, capsys, tmp_path, monkeypatch, preset
):
    monkeypatch.chdir(tmp_path)
    said = f"there is no preset '{preset}'; choose one of smoke, default, full.\n"
    assert run(capsys, "train", "--out", "runs", "--preset", preset) == (2, "", said)
    assert list(tmp_path.iterdir()) == []
    assert calls == []
