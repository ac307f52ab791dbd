"""A newcomer's first minute: simulate a clip, look at it, ask about it, with the shipped model."""

import json
from pathlib import Path

import pytest

import geotlm_lm
from geotlm_lm.cli.main import main

BUNDLE = Path(geotlm_lm.__file__).parent / "bundle"
needs_bundle = pytest.mark.skipif(not BUNDLE.is_dir(), reason="needs the trained bundle")


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as exit_info:
        main([str(argument) for argument in arguments])
    assert exit_info.value.code == 0
    return capsys.readouterr().out


@pytest.fixture
def clip(tmp_path, capsys):
    path = tmp_path / "clip.npz"
    run(capsys, "simulate", "--clip", path, "--motion", "left", "--object", "key")
    return path


def test_a_simulated_clip_is_described_as_touched(clip, capsys):
    facts = json.loads(run(capsys, "info", "--clip", clip, "--json"))
    assert facts["contact"] == "likely"
    assert facts["touched_frames"] == [0, 3]


@needs_bundle
def test_the_shipped_model_answers_with_a_direction_a_probability_and_a_frame(clip, capsys):
    question = ["--q", "Which way is it moving?", "--json"]
    answer = json.loads(run(capsys, "answer", "--clip", clip, *question).splitlines()[-1])
    assert answer["direction"] == "left"
    assert 0.5 < answer["confidence"] <= 1
    assert answer["frame"]["sentence"].startswith("camera image")
