"""`info` describes a recording or an encoder's file, `doctor` examines it, without a model."""

import json
import os

import numpy as np
import pytest

from geotlm_lm.doctor import installation
from geotlm_lm.recordings import streams
from geotlm_lm.recordings.streams import StreamFrame
from tests.backbone.small_files import write_small
from tests.cli.running import run


def described(capsys, path, *options):
    code, out, _ = run(capsys, "info", path, "--json", *options)
    assert code == 0
    return json.loads(out.splitlines()[-1])


@pytest.fixture
def press(tmp_path):
    """A bar pressed into a plain gel over 20 frames, the first 8 untouched."""
    bar = np.zeros((60, 80, 1))
    bar[20:40, 30:34] = 60
    depth = np.clip((np.arange(20) - 7) / 4, 0, 1)[:, None, None, None]
    noise = np.random.default_rng(0).normal(0, 1, (20, 60, 80, 3))
    path = tmp_path / "press.npz"
    np.savez(path, frames=np.rint(120 + depth * bar + noise).astype(np.uint8), fps=25)
    return path


def test_a_recording_is_described(capsys, press):
    facts = described(capsys, press)
    assert facts["frames"] == 20
    assert facts["size_px"] == [80, 60]
    assert facts["fps"] == 25
    assert facts["background"] == "found in the recording"
    assert facts["contact"] == "likely"
    assert facts["touched_frames"] == [8, 19]
    assert facts["strongest_imprint_grey_levels"] > 2
    assert {"frames: 20", "size px: 80 60"} <= set(run(capsys, "info", press)[1].splitlines())


def test_a_name_that_is_not_utf_8_is_printed_as_it_is(capfdbinary, press):
    path = press.rename(press.with_name(os.fsdecode(b"m\xe9.npz")))
    code, out, _ = run(capfdbinary, "info", path)
    assert code == 0
    assert b"/m\xe9.npz\n" in out
    assert run(capfdbinary, "doctor", path)[1].endswith(b"\nm\xe9.npz: 1 to repair: size.\n")


def test_a_span_is_described_by_its_own_frames(capsys, press):
    assert described(capsys, press, "--frames", "12:15")["touched_frames"] == [12, 15]
    free = described(capsys, press, "--frames", "0:5")
    assert (free["contact"], free["touched_frames"]) == ("none seen", None)


def test_a_given_background_is_told_from_an_estimated_one(capsys, press, tmp_path):
    frames = np.load(press)["frames"]
    np.save(tmp_path / "touched.npy", frames[12:])
    np.save(tmp_path / "idle.npy", frames[0])
    facts = described(capsys, tmp_path / "touched.npy")
    assert facts["background"] == "estimated from the frames"
    assert facts["contact"] == "unknown without an idle frame"
    given = described(capsys, tmp_path / "touched.npy", "--background", tmp_path / "idle.npy")
    assert given["background"] == "given"
    assert given["contact"] == "likely"


def test_an_untouched_gel_shows_no_contact(capsys, tmp_path):
    frames = np.random.default_rng(0).normal(120, 1, (5, 240, 320, 3)).astype(np.uint8)
    np.savez(tmp_path / "idle.npz", frames=frames[1:], background=frames[0])
    assert described(capsys, tmp_path / "idle.npz")["contact"] == "none seen"


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


@pytest.mark.parametrize("arguments", [[], ["a.npy", "--weights", "b.pth"]])
def test_info_describes_either_a_recording_or_a_file(capsys, arguments):
    code, out, err = run(capsys, "info", *arguments)
    assert (code, out) == (2, "")
    assert err == "give a recording, or --weights with the file of a released encoder.\n"


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
    assert any(line.startswith("note    Colours were taken for red") for line in lines)
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
