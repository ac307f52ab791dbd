"""A newcomer's first minute: simulate a clip, look at it, ask about it, with the shipped model."""

import json
from pathlib import Path

import pytest

import geotlm_lm
from geotlm_lm.cli.main import main

BUNDLE = Path(geotlm_lm.__file__).parent / "bundle"


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as exit_info:
        main([str(argument) for argument in arguments])
    assert exit_info.value.code == 0
    return capsys.readouterr().out


def test_a_simulated_clip_is_described_and_asked_about(tmp_path, capsys):
    clip = tmp_path / "clip.npz"
    run(capsys, "simulate", "--clip", clip, "--motion", "left", "--object", "key")
    facts = json.loads(run(capsys, "info", "--clip", clip, "--json"))
    assert (facts["contact"], facts["touched_frames"]) == ("likely", [0, 3])
    if not BUNDLE.is_dir():
        pytest.skip("needs the trained bundle")
    question = ["--q", "Which way is it moving?", "--json"]
    answer = json.loads(run(capsys, "answer", "--clip", clip, *question).splitlines()[-1])
    assert answer["direction"] == "left"
    assert 0.5 < answer["confidence"] <= 1
    assert answer["frame"]["sentence"].startswith("camera image")
