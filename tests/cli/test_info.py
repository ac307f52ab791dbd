"""`info` tells what a recording holds without any model."""

import json
import os

import numpy as np
import pytest

from tests.cli.running import run


def described(capsys, path, *options):
    code, out, _ = run(capsys, "info", "--clip", path, "--json", *options)
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


def test_a_name_that_is_not_utf_8_is_printed_as_it_is(capfdbinary, press):
    path = press.rename(press.with_name(os.fsdecode(b"m\xe9.npz")))
    code, out, _ = run(capfdbinary, "info", "--clip", path)
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


def test_words_are_one_fact_a_line(capsys, press):
    lines = run(capsys, "info", "--clip", press)[1].splitlines()
    assert "frames: 20" in lines
    assert "size px: 80 60" in lines
