"""`geotlm-lm label`: what it prints and what it refuses; the labels: tests/data_sets."""

import json

import numpy as np
import pytest

from geotlm_lm.answering.answerer import loaded
from geotlm_lm.core.clip import Clip
from geotlm_lm.runs.run import ALONE
from tests.cli import running
from tests.cli.recorded_touch import Measuring
from tests.data_sets.lerobot_files import CAMERA, FPS, OTHER, turned, write_data_set

pytest.importorskip("pyarrow", reason="needs pyarrow, of the extra lerobot")
pytest.importorskip("av", reason="needs av, of the extra lerobot")

CLIP = turned(20)


@pytest.fixture(autouse=True)
def without_model(monkeypatch):
    monkeypatch.setattr("geotlm_lm.answering.Answerer.load", lambda *_, **__: Measuring())
    monkeypatch.setattr("geotlm_lm.cli.label.Workers", lambda *_: ALONE)
    loaded.cache_clear()
    yield
    loaded.cache_clear()


def run(capsys, *arguments):
    return running.run(capsys, "label", *arguments)


def test_a_data_set_is_labelled_and_what_has_no_labels_is_told(capsys, tmp_path):
    black = Clip(np.zeros_like(CLIP.frames), fps=FPS)
    root, out = write_data_set(tmp_path / "robot", [CLIP, black]), tmp_path / "out"
    code, told, err = run(capsys, root, "--camera", CAMERA, "--out", out, "--workers", 1)
    assert (code, told) == (0, f"{out}: 2 episodes, 48 frames, 3 events\n")
    assert "note: episode 1 has no labels: " in err
    assert "labelled: 2 of 2 episodes" in err


def test_a_wrong_camera_is_told_with_those_there_are_and_a_set_that_is_none(capsys, tmp_path):
    root = write_data_set(tmp_path / "robot", [CLIP])
    assert run(capsys, root, "--camera", "wrist", "--out", tmp_path / "out") == (
        2,
        "",
        f"{root}: has no camera wrist; choose one of {OTHER}, {CAMERA}.\n",
    )
    code, _, err = run(capsys, tmp_path, "--camera", CAMERA, "--out", tmp_path / "out")
    assert code == 3
    assert err.startswith(f"{tmp_path}: is no LeRobot data set, expected a readable meta/info.json")


def test_an_episode_is_tracked_as_a_recording(capsys, tmp_path):
    root = write_data_set(tmp_path / "robot", [CLIP, turned(-15, 28)])
    episode = ("--episode", 1, "--camera", CAMERA)
    code, out, _ = running.run(capsys, "track", root, *episode, "--json")
    turns = [one for one in json.loads(out)["events"] if one["event"] == "turn"]
    assert code == 0
    assert [one["amount"] for one in turns] == [pytest.approx(-15, rel=0.25)]
    assert running.run(capsys, "track", root) == (
        2,
        "",
        f"{root}: has 2 cameras: {OTHER}, {CAMERA}; give the touch sensor's by --camera.\n",
    )


def test_an_only_camera_need_not_be_told_and_a_recording_has_none(capsys, tmp_path):
    root = write_data_set(tmp_path / "robot", [CLIP], as_images=True)
    assert running.run(capsys, "track", root)[0] == 0
    np.savez(tmp_path / "clip.npz", frames=CLIP.frames, fps=FPS)
    asked = ("answer", "--clip", tmp_path / "clip.npz", "--q", "Which way?", "--episode", 1)
    assert running.run(capsys, *asked) == (
        2,
        "",
        f"--episode and --camera are of a LeRobot data set, and {tmp_path / 'clip.npz'} is none; "
        f"leave them out.\n",
    )
