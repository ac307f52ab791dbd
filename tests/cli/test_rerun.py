"""`--rerun` of `track` and `answer`: a file that Rerun's own reader takes."""

import time
from contextlib import contextmanager
from types import SimpleNamespace
from urllib.error import URLError
from urllib.request import urlopen

import numpy as np
import pytest

from geotlm_lm.track.rerun_log import log_clip, rerun_recording, viewer
from tests.cli import running
from tests.cli.recorded_touch import CLIP, Measuring, saved_touch

chunks = pytest.importorskip("rerun.chunk", reason="needs rerun-sdk, of the extra rerun")


@pytest.fixture
def path(tmp_path):
    return saved_touch(tmp_path)


def logged(path):
    """Return how many rows a recording holds of each entity."""
    found = {}
    for chunk in chunks.RrdReader(path).stream():
        found[chunk.entity_path] = found.get(chunk.entity_path, 0) + chunk.num_rows
    return found


def test_a_track_is_written_for_the_viewer(capsys, path, tmp_path, monkeypatch):
    monkeypatch.setattr("geotlm_lm.answering.Answerer.load", lambda *_, **__: Measuring())
    target = tmp_path / "t.rrd"
    code, out, _ = running.run(capsys, "track", path, "--rerun", target, "--frames", "20:60")
    found = logged(target)
    assert code == 0
    assert (found["/camera/image"], found["/camera/turn"]) == (41, 41)
    assert found["/events"] == sum(" s  " in line for line in out.splitlines())
    assert "/answer" not in found
    code, _, err = running.run(capsys, "track", path, "--rerun", target)
    assert (code, err.startswith(f"--rerun: {target} is there already")) == (2, True)
    code, _, err = running.run(capsys, "track", path, "--rerun", tmp_path / "t.txt")
    assert err.endswith("expected a name that ends in .rrd.\n")


def test_an_answer_is_written_with_what_it_rests_on(capsys, path, tmp_path, answerer, monkeypatch):
    monkeypatch.setattr("geotlm_lm.answering.Answerer.load", lambda *_, **__: answerer)
    asked = ("--q", "Which way is it turning?")
    code, *_ = running.run(capsys, "answer", path, *asked, "--rerun", tmp_path / "a.rrd")
    found = logged(tmp_path / "a.rrd")
    assert code == 0
    assert (found["/camera/image"], found["/answer"]) == (len(CLIP), 1)
    assert found["/events"] > 3
    np.savez(tmp_path / "four.npz", frames=CLIP.frames[[0, 30, 36, 42]], fps=CLIP.fps)
    target = tmp_path / "four.rrd"
    running.run(capsys, "answer", tmp_path / "four.npz", *asked, "--rerun", target)
    found = logged(target)
    assert (found["/camera/image"], found["/answer"]) == (4, 1)
    assert "/turn/deg" not in found


def test_a_recording_is_served_to_this_machine_until_it_is_stopped(tmp_path, monkeypatch):
    # Of what is its first session, to a home of its own, the viewer sends no usage data.
    for name in ("HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME"):
        monkeypatch.setenv(name, str(tmp_path / "home"))
    with rerun_recording(tmp_path / "t.rrd") as stream:
        log_clip(stream, CLIP.select([0, 40]))
    with viewer(tmp_path / "t.rrd") as (address, running):
        assert running.poll() is None
        page = opened(address)
    assert b"<html" in page.lower()
    assert running.poll() is not None
    with pytest.raises(URLError):
        urlopen(address, timeout=10)


def opened(address, until_s=60):
    deadline = time.monotonic() + until_s
    while True:
        try:
            return urlopen(address, timeout=10).read()
        except URLError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.2)


def test_serve_shows_what_would_be_written(capsys, path, tmp_path, monkeypatch):
    monkeypatch.setattr("geotlm_lm.answering.Answerer.load", lambda *_, **__: Measuring())
    seen = []

    @contextmanager
    def watched(file):
        seen.append(logged(file))
        yield "http://there", SimpleNamespace(wait=lambda: None)

    monkeypatch.setattr("geotlm_lm.track.rerun_log.viewer", watched)
    code, out, err = running.run(capsys, "track", path, "--rerun", "serve")
    assert (code, seen[0]["/camera/image"]) == (0, len(CLIP))
    assert "degrees clockwise" in out
    assert "Rerun's viewer is at http://there until Ctrl-C.\n" in err
