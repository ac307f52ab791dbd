"""`track` tells the events of a recording, writes what it is asked for, and keeps what it has."""

import csv
import json
import re
import time
from contextlib import contextmanager
from types import SimpleNamespace
from urllib.error import URLError
from urllib.request import urlopen

import cv2
import numpy as np
import pytest

from geotlm_lm.core.twist import Component
from geotlm_lm.recordings import policy
from geotlm_lm.recordings.idle import estimate_background
from geotlm_lm.track.rerun_log import log_clip, rerun_recording, viewer
from geotlm_lm.track.tracker import Tracker
from tests.cli import running
from tests.cli.recorded_touch import CLIP, Measuring, saved_touch
from tests.recordings.test_read import write_gif


@pytest.fixture(autouse=True)
def without_model(monkeypatch):
    monkeypatch.setattr("geotlm_lm.answering.Answerer.load", lambda *_, **__: Measuring())


@pytest.fixture
def path(tmp_path):
    return saved_touch(tmp_path)


def run(capsys, *arguments):
    return running.run(capsys, "track", *arguments)


def test_events_are_a_table_with_times_amounts_and_totals(capsys, path):
    code, out, err = run(capsys, path)
    assert code == 0
    head, *lines = out.splitlines()
    assert head.split() == ["begin", "end", "what", "how", "far", "likely", "sure"]
    turns = [line for line in lines if "  turn " in line]
    assert ["counterclockwise" in line for line in turns] == [False, True]
    assert "deg" in turns[0]
    assert lines[0].split()[4] == "touch"
    assert any("degrees clockwise from first to last" in line for line in lines)
    assert "tracking: 105 of 105 frames" in err


def test_how_far_is_not_told_where_the_pictures_do_not_tell_it(capsys, path, monkeypatch):
    def seen_closely(self, recording, track):
        return track.as_readable({Component.TURN: False})

    monkeypatch.setattr(Measuring, "seen_closely", seen_closely)
    _, out, _ = run(capsys, path)
    turns = [line for line in out.splitlines() if "  turn " in line]
    assert turns
    assert all("not seen" in line and "deg" not in line for line in turns)
    assert "Turned; the pictures do not tell how far.\nDoes not slide" in out
    written = json.loads(run(capsys, path, "--json")[1])
    amounts = {event["amount"] for event in written["events"] if event["event"] == "turn"}
    assert amounts == {None} == {written["totals"]["turn_net"]["amount"]}


def test_json_holds_events_and_totals_in_one_object(capsys, path):
    told = json.loads(run(capsys, path, "--json")[1])
    turn, back = (one for one in told["events"] if one["event"] == "turn")
    assert (turn["way"], back["way"]) == ("clockwise", "counterclockwise")
    assert 0.8 <= turn["begin_s"] <= 1.2
    assert turn["end"] == pytest.approx(45, abs=5)
    assert turn["amount"] == pytest.approx(30, rel=0.25)
    assert turn["low"] < turn["amount"] < turn["high"]
    totals = told["totals"]
    assert totals["turned_back"] == 1
    assert totals["turn_in_all"]["amount"] > totals["turn_net"]["amount"] > 0


def test_every_file_that_is_asked_for_is_written(capsys, path, tmp_path):
    names = {"--out": "t.csv", "--plot": "t.png", "--video": "t.mp4"}
    options = [part for option, name in names.items() for part in (option, tmp_path / name)]
    assert run(capsys, path, *options)[0] == 0
    rows = list(csv.DictReader((tmp_path / "t.csv").open()))
    assert [int(row["frame"]) for row in rows] == list(range(len(CLIP)))
    assert float(rows[50]["turn_deg"]) == pytest.approx(30, rel=0.25)
    assert cv2.imread(str(tmp_path / "t.png")).shape[2] == 3
    film = cv2.VideoCapture(str(tmp_path / "t.mp4"))
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) == len(CLIP)


def test_a_json_file_says_what_made_it_and_travel_may_be_told_in_mm(capsys, path, tmp_path):
    run(capsys, path, "--out", tmp_path / "t.json", "--mm-per-px", 0.06, "--frames", "20:60")
    told = json.loads((tmp_path / "t.json").read_text())
    assert {"right_mm", "down_mm", "right_mm_deviation"} < set(told["rows"][0])
    assert [row["frame"] for row in told["rows"]] == list(range(20, 61))
    assert told["totals"]["slide_net"]["unit"] == "mm"
    assert told["made_by"]["recording"] == str(path)
    assert told["made_by"]["command"].startswith("geotlm-lm")


def test_a_parquet_table_holds_the_same_rows(capsys, path, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    run(capsys, path, "--out", tmp_path / "t.parquet")
    run(capsys, path, "--out", tmp_path / "t.csv")
    table = parquet.read_table(tmp_path / "t.parquet")
    rows = list(csv.DictReader((tmp_path / "t.csv").open()))
    assert table.column_names == list(rows[0])
    assert table["turn_deg"].to_pylist() == [float(row["turn_deg"]) for row in rows]
    assert json.loads(table.schema.metadata[b"geotlm_lm"])["totals"]["turned_back"] == 1


def test_ctrl_c_ends_the_recording_there_and_keeps_what_was_tracked(
    capsys, path, tmp_path, monkeypatch
):
    feed = Tracker.feed

    def stopped(self, frame, time_s, number=None):
        if number == 50:
            raise KeyboardInterrupt
        return feed(self, frame, time_s, number)

    monkeypatch.setattr(Tracker, "feed", stopped)
    code, out, err = run(capsys, path, "--out", tmp_path / "t.csv", "--video", tmp_path / "t.mp4")
    assert code == 130
    assert "turn clockwise" in out
    assert "note: Tracked as far as frame 49.\n" in err
    assert err.endswith("Stopped; files already complete are kept.\n")
    assert len((tmp_path / "t.csv").read_text().splitlines()) == 1 + 50
    film = cv2.VideoCapture(str(tmp_path / "t.mp4"))
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) == 50


@pytest.mark.parametrize(
    ("option", "name", "package"),
    [("--out", "t.parquet", "pyarrow"), ("--plot", "t.png", "matplotlib")],
)
def test_a_missing_package_is_told_with_its_extra(
    capsys, path, tmp_path, monkeypatch, option, name, package
):
    monkeypatch.setattr("geotlm_lm.core.errors.find_spec", lambda name: None)
    assert run(capsys, path, option, tmp_path / name) == (
        7,
        "",
        f"{tmp_path / name}: a .{name[2:]} file is written with {package}, which is not "
        f"installed; run `pip install 'geotlm-lm[track]'`.\n",
    )


def test_no_file_is_replaced_unasked_nor_named_wrongly(capsys, path, tmp_path):
    target = tmp_path / "t.csv"
    target.write_text("mine")
    code, _, err = run(capsys, path, "--out", target)
    assert (code, target.read_text()) == (2, "mine")
    assert f"--out: {target} is there already" in err
    assert run(capsys, path, "--out", target, "--force")[0] == 0
    assert target.read_text().startswith("frame,time_s,")
    code, _, err = run(capsys, path, "--plot", tmp_path / "t.gif")
    assert (code, err) == (
        2,
        f"--plot {tmp_path / 't.gif'} was given, expected a name that ends in .png or .svg "
        f"or .pdf.\n",
    )
    assert run(capsys, path, "--force")[0] == 2
    assert run(capsys, path, "--frames", "90:200")[0] == 2


def test_an_untouched_gel_is_told_in_a_sentence(capsys, tmp_path):
    np.savez(tmp_path / "idle.npz", frames=CLIP.frames[:9], fps=25.0)
    assert run(capsys, tmp_path / "idle.npz")[1] == "Nothing touches in the recording.\n"


def test_a_recording_without_a_picture_is_refused_in_one_sentence(capsys, tmp_path):
    path = tmp_path / "none.npz"
    np.savez(path, frames=np.zeros((30, 120, 160, 3), np.uint8), fps=25.0)
    assert run(capsys, path) == (
        3,
        "",
        f"{path}: 100% of frame 0 is black, expected at most 40%; check the camera and the "
        f"sensor's lights.\n",
    )


def test_a_recording_in_which_nothing_changes_is_tracked_with_a_guessed_gel(
    capsys, tmp_path, monkeypatch
):
    def tracker(_, recording):
        return Tracker(idle=estimate_background(recording.frames))

    monkeypatch.setattr(Measuring, "tracker", tracker)
    frames = np.full((30, 120, 160, 3), 120, np.uint8)
    np.savez(tmp_path / "plain.npz", frames=frames, fps=25.0)
    assert run(capsys, tmp_path / "plain.npz")[:2] == (0, "Nothing touches in the recording.\n")


def test_frame_numbers_stand_for_times_where_no_rate_is_known(capsys, tmp_path):
    np.save(tmp_path / "clip.npy", CLIP.frames)
    lines = run(capsys, tmp_path / "clip.npy", "--plot", tmp_path / "t.png")[1].splitlines()
    assert lines[1].split()[:3] == ["10", "10", "touch"]
    assert re.search(r"; touched for \d+ frames\.$", lines[-1])


STEPS_S = [0.04] * 40 + [0.4] + [0.08] * 64


@pytest.mark.parametrize("kept", [len(CLIP), 20])
def test_frames_of_an_uneven_video_have_their_own_times(capsys, tmp_path, monkeypatch, kept):
    durations_ms = [round(1000 * step_s) for step_s in STEPS_S]
    write_gif(tmp_path / "c.gif", CLIP.frames[..., 0], durations_ms)
    monkeypatch.setattr(policy, "KEPT_BYTES", kept * CLIP.frames[0].nbytes)
    code, out, err = run(capsys, tmp_path / "c.gif", "--out", tmp_path / "t.csv")
    rows = list(csv.DictReader((tmp_path / "t.csv").open()))
    times = np.concatenate([[0], np.cumsum(STEPS_S)])[: len(CLIP)]
    assert code == 0
    assert [float(row["time_s"]) for row in rows] == pytest.approx(times.tolist())
    (turn, _) = (line.split() for line in out.splitlines() if "  turn " in line)
    assert turn[1] == turn[3] == "s"
    assert float(turn[0]) == pytest.approx(times[25], abs=0.2)
    assert float(turn[2]) == pytest.approx(times[45], abs=0.3)
    assert err.count("No frame came for 0.40 s before frame 41") == 1


def logged(path):
    """Return how many rows a recording holds of each entity."""
    chunks = pytest.importorskip("rerun.chunk", reason="needs rerun-sdk, of the extra rerun")
    found = {}
    for chunk in chunks.RrdReader(path).stream():
        found[chunk.entity_path] = found.get(chunk.entity_path, 0) + chunk.num_rows
    return found


def test_a_track_is_written_for_the_viewer(capsys, path, tmp_path):
    target = tmp_path / "t.rrd"
    code, out, _ = run(capsys, path, "--rerun", target, "--frames", "20:60")
    found = logged(target)
    assert code == 0
    assert (found["/camera/image"], found["/camera/turn"]) == (41, 41)
    assert found["/events"] == sum(" s  " in line for line in out.splitlines())
    assert "/answer" not in found
    code, _, err = run(capsys, path, "--rerun", target)
    assert (code, err.startswith(f"--rerun: {target} is there already")) == (2, True)
    code, _, err = run(capsys, path, "--rerun", tmp_path / "t.txt")
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


@pytest.mark.slow
def test_a_recording_is_served_to_this_machine_until_it_is_stopped(tmp_path, monkeypatch):
    pytest.importorskip("rerun", reason="needs rerun-sdk, of the extra rerun")
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
    pytest.importorskip("rerun", reason="needs rerun-sdk, of the extra rerun")
    seen = []

    @contextmanager
    def watched(file):
        seen.append(logged(file))
        yield "http://there", SimpleNamespace(wait=lambda: None)

    monkeypatch.setattr("geotlm_lm.track.rerun_log.viewer", watched)
    code, out, err = run(capsys, path, "--rerun", "serve")
    assert (code, seen[0]["/camera/image"]) == (0, len(CLIP))
    assert "degrees clockwise" in out
    assert "Rerun's viewer is at http://there until Ctrl-C.\n" in err
