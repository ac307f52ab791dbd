"""`doctor` tells findings in words or as JSON, of a recording, a camera or the installation."""

import json

import numpy as np
import pytest

from geotlm_lm.doctor import installation
from geotlm_lm.recordings import streams
from geotlm_lm.recordings.streams import StreamFrame
from tests.cli.running import run

FRAMES = np.random.default_rng(0).normal((70, 95, 110), 1, (12, 120, 160, 3))
FRAMES = FRAMES.round().astype(np.uint8)


@pytest.fixture
def repeating(tmp_path):
    path = tmp_path / "clip.npz"
    np.savez(path, frames=np.repeat(FRAMES, 2, axis=0), fps=25, background=FRAMES[0])
    return path


def test_a_recording_is_examined_in_words(capsys, repeating):
    code, told, errors = run(capsys, "doctor", repeating)
    lines = told.splitlines()
    assert (code, errors) == (0, "")
    assert lines[0].startswith("fine    frame rate: 25 frames per second")
    assert "fault   repeated frames: 12 of 24 equal the one before (52.2%)." in lines
    assert any(line.startswith("note    Shape (24, 120, 160, 3) was taken") for line in lines)
    assert lines[-1] == "clip.npz: 2 to repair: repeated frames, contrast."


def test_a_recording_is_examined_as_json(capsys, repeating):
    code, told, _ = run(capsys, "doctor", repeating, "--json")
    facts = json.loads(told)
    assert code == 0
    assert facts["source"] == str(repeating)
    assert facts["faults"] == ["repeated frames", "contrast"]
    assert set(facts["findings"][0]) == {"subject", "verdict", "measured", "means", "advice"}


def test_options_that_a_finding_names_change_it(capsys, repeating):
    as_bgr = run(capsys, "doctor", repeating, "--json", "--layout", "BGR")[1]
    assert "colour order" in json.loads(as_bgr)["faults"]


def test_what_cannot_be_read_is_told_as_everywhere(capsys, tmp_path):
    code, told, errors = run(capsys, "doctor", tmp_path / "none.avi")
    assert (code, told) == (3, "")
    assert errors == f"{tmp_path / 'none.avi'}: no such file or folder; check the path.\n"


def test_a_camera_is_examined_by_its_first_frames(capsys, monkeypatch):
    def frames():
        yield from (StreamFrame(one, 0.04 * n, n) for n, one in enumerate(FRAMES))

    monkeypatch.setattr(streams, "open_source", lambda name, fps: frames())
    facts = json.loads(run(capsys, "doctor", "0", "--json")[1])
    rate = facts["findings"][0]
    assert rate["measured"].startswith("25.0 frames per second")
    assert "repeated frames" not in facts["faults"]


def test_without_a_source_the_installation_is_examined(capsys, monkeypatch):
    monkeypatch.setattr(
        installation, "find_spec", lambda package: None if package == "rosbags" else object()
    )
    monkeypatch.setattr(installation, "_answers", lambda model: installation._extra("track"))
    told = run(capsys, "doctor")[1]
    assert told.startswith("fine    versions: geotlm-lm ")
    assert "limit   extra ros: not installed." in told
    assert "run `pip install 'geotlm-lm[ros]'`." in told
    assert told.endswith("the installation: Nothing to repair.\n")


def test_the_shipped_model_answers_its_example(answerer):
    assert installation._answers(None).verdict == "fine"


def test_a_bundle_that_is_not_there_is_a_fault(tmp_path):
    finding = installation._answers(tmp_path)
    assert (finding.verdict, finding.means) == ("fault", "Nothing is answered.")
