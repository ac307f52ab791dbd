"""`watch` prints what happens as it is over, writes what `track` writes, and keeps what it has."""

import csv
import json
import os
from contextlib import ExitStack

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import MissingDependency, Stalled, UnreadableClip
from geotlm_lm.recordings import streams
from geotlm_lm.track.tracker import Tracker
from tests.cli import running
from tests.cli.recorded_touch import CLIP, saved_touch
from tests.recordings.fake_camera import FakeCamera
from tests.recordings.test_read import write_video


class Asked:
    """Tracks by measurement alone; answers with what it was asked about."""

    def tracker(self, recording=None):
        return Tracker()

    def seen_closely(self, recording, track):
        return track

    def encode(self, clip, *, track):
        if track.net_twist.turn_deg < 0:
            raise UnreadableClip("the frames are black.")
        return clip, track

    def ask(self, encoded, question):
        clip, track = encoded
        return type("", (), {"text": f"{question} {len(clip)} of {len(track)} frames"})


@pytest.fixture(autouse=True)
def _model_stands_in(monkeypatch):
    monkeypatch.setattr("geotlm_lm.answering.Answerer.load", lambda folder: Asked())


@pytest.fixture
def recording(tmp_path):
    return saved_touch(tmp_path)


def run(capsys, *arguments):
    return running.run(capsys, "watch", *arguments)


def test_it_prints_the_table_that_track_prints_and_the_account_to_stderr(capsys, recording):
    code, out, err = run(capsys, recording)
    head, *events = out[: out.index("\n\n")].splitlines()
    whole = running.run(capsys, "track", recording)[1].splitlines()
    assert (code, head) == (0, whole[0])
    assert any("  turn clockwise  " in line for line in events)
    ends = [float(line.split()[2]) for line in events]
    assert ends == sorted(ends)  # each is told once it is over
    assert len(events) == whole.index("") - 1
    assert "; touched for" in out
    assert f"note: {len(CLIP)} frames, none dropped; each tracked in " in err
    assert "note: Colours were taken for red, green, blue; pass --layout BGR if OpenCV" in err


def test_no_touch_is_not_claimed_where_none_was_judged(capsys, tmp_path):
    write_video(tmp_path / "touching.avi", CLIP.frames[30:31])
    code, out, err = run(capsys, tmp_path / "touching.avi")
    assert (code, out) == (0, "")
    assert "note: No untouched gel was seen" in err
    write_video(tmp_path / "idle.avi", CLIP.frames[:9].repeat(3, axis=0))
    assert run(capsys, tmp_path / "idle.avi")[1] == "Nothing touches in the recording.\n"


def test_events_are_one_json_object_a_line_and_the_account_is_last(capsys, recording):
    *events, account = map(json.loads, run(capsys, recording, "--json")[1].splitlines())
    assert {one["type"] for one in events} == {"event"}
    turn, back = (one for one in events if one["event"] == "turn")
    assert (turn["way"], back["way"]) == ("clockwise", "counterclockwise")
    assert turn["low"] < turn["amount"] < turn["high"]
    assert (account["type"], account["frames"], account["dropped"]) == ("account", len(CLIP), 0)
    assert account["totals"]["turned_back"] == 1


def test_it_writes_the_files_that_track_writes(capsys, recording, tmp_path):
    files = {"--out": "t.csv", "--plot": "t.png", "--video": "new/t.mp4"}
    options = [part for option, name in files.items() for part in (option, tmp_path / name)]
    assert run(capsys, recording, "--mm-per-px", 0.06, *options)[0] == 0
    rows = list(csv.DictReader((tmp_path / "t.csv").open()))
    assert len(rows) == len(CLIP)
    assert "right_mm" in rows[0]
    assert cv2.imread(str(tmp_path / "t.png")).shape[2] == 3
    film = cv2.VideoCapture(str(tmp_path / "new" / "t.mp4"))
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) == len(CLIP)


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (KeyboardInterrupt(), 130, "Stopped; files already complete are kept.\n"),
        (MissingDependency("Camera 0 stopped."), 7, "Camera 0 stopped.\n"),
    ],
)
def test_what_was_tracked_is_told_and_written_where_it_is_stopped_or_unplugged(
    capsys, recording, tmp_path, monkeypatch, error, code, said
):
    play = streams.Recording.__iter__

    def stopping(self):
        for frame in play(self):
            if frame.number == 50:
                raise error
            yield frame

    monkeypatch.setattr(streams.Recording, "__iter__", stopping)
    out, video = tmp_path / "t.csv", tmp_path / "t.mp4"
    found = run(capsys, recording, "--out", out, "--video", video)
    assert found[0] == code
    assert "turn clockwise" in found[1]
    assert found[2].endswith(said)
    assert len(out.read_text().splitlines()) == 1 + 50
    assert cv2.VideoCapture(str(video)).get(cv2.CAP_PROP_FRAME_COUNT) == 50


def test_a_question_is_asked_about_each_motion_that_ends(capsys, recording):
    lines = run(capsys, recording, "--q", "Where?", "--json")[1].splitlines()[:-1]
    events = list(map(json.loads, lines))
    turn, back = (one for one in events if one["event"] == "turn")
    frames = turn["end"] - turn["begin"] + 1
    assert turn["answer"].startswith("Where? ")
    assert turn["answer"].endswith(f" of {frames} frames")
    assert frames / 2 <= 2 * int(turn["answer"].split()[1]) <= 2 + frames
    assert back["answer"] == "I cannot read this motion's frames: the frames are black."
    still = [one for one in events if one["event"] in ("touch", "stick", "slip")]
    assert still
    assert not any("answer" in one for one in still)


def test_a_rate_that_is_assumed_is_told_and_can_be_given(capsys, tmp_path):
    path = tmp_path / "clip.npy"
    np.save(path, CLIP.frames[:8])
    note = f"note: {path} at {{}}"
    assert run(capsys, path)[2].startswith(
        note.format("25 frames per second, as is assumed; give the rate by --fps.\n")
    )
    given = run(capsys, path, "--fps", 50)[2]
    assert given.startswith(note.format("50 frames per second.\n"))
    assert run(capsys, path, "--fps", 0)[0] == 2


@pytest.mark.parametrize("forced", [(), ("--force",)])
def test_a_video_never_replaces_the_recording(capsys, tmp_path, forced):
    own = tmp_path / "own.mp4"
    own.write_bytes(b"a recording")
    (tmp_path / "link.mp4").symlink_to(own)
    assert run(capsys, own, "--video", tmp_path / "link.mp4", *forced) == (
        2,
        "",
        f"--video: {tmp_path / 'link.mp4'} is read by this command and would be replaced, expected "
        f"the name of another file; give one.\n",
    )
    assert own.read_bytes() == b"a recording"


def test_a_missing_recording_ends_with_code_3_and_leaves_no_folder_behind(capsys, tmp_path):
    drawing = tmp_path / "new" / "out.mp4"
    code, out, err = run(capsys, "gone.avi", "--video", drawing)
    assert (code, out, err) == (3, "", "gone.avi: no such file or folder; check the path.\n")
    assert not drawing.parent.exists()


def test_a_question_that_cannot_be_asked_is_told_before_the_source_is_opened(capsys):
    sentence = "The question is empty; ask something like 'Which way is it moving?'.\n"
    assert run(capsys, "gone.avi", "--q", " ") == (2, "", sentence)


def test_a_grey_array_is_watched_with_its_layout(capsys, tmp_path):
    path = tmp_path / "grey.npy"
    np.save(path, CLIP.frames[:12, ..., 0])
    code, _, err = run(capsys, path)
    assert (code, err.count("pass --layout THW")) == (3, 1)
    code, _, err = run(capsys, path, "--layout", "THW")
    assert (code, "12 frames" in err) == (0, True)
    assert run(capsys, "recording.avi", "--layout", "HW")[0] == 2


@pytest.mark.parametrize(
    ("name", "options", "columns"),
    [("square.npz", (), 224), ("square.avi", ("--square-pixels",), 223)],
)
def test_frames_of_224_pixels_are_taken_as_asked(
    capsys, tmp_path, monkeypatch, name, options, columns
):
    frames = [cv2.resize(one, (224, 224)) for one in CLIP.frames[:9]]
    if name.endswith(".npz"):
        np.savez(tmp_path / name, frames=np.stack(frames), fps=25.0)
    else:
        write_video(tmp_path / name, frames, 25, "MJPG")
    widths, feed = set(), Tracker.feed

    def fed(self, frame, *rest):
        widths.add(frame.shape[1])
        return feed(self, frame, *rest)

    monkeypatch.setattr(Tracker, "feed", fed)
    assert run(capsys, tmp_path / name, *options)[0] == 0
    assert widths == {columns}


@pytest.fixture
def plugged_in(monkeypatch):
    monkeypatch.setattr(streams, "SILENT_S", 0.01)
    monkeypatch.setattr(streams, "THREAD_END_S", 0.01)
    with ExitStack() as cameras:

        def plug_in(frames):
            camera = FakeCamera(frames, waits=True)
            cameras.callback(camera.release)
            monkeypatch.setattr(cv2, "VideoCapture", lambda *_: camera)

        yield plug_in


def test_a_camera_that_stalls_is_told_and_ends_with_what_was_tracked(capsys, tmp_path, plugged_in):
    plugged_in(CLIP.frames[:20, ..., ::-1])
    table = tmp_path / "t.csv"
    given = (0, "--stalled-after", 0.2, "--out", table, "--json")
    code, out, err = run(capsys, *given)
    assert code == Stalled.exit_code == 10
    (account,) = map(json.loads, out.splitlines())
    assert (account["type"], account["frames"]) == ("account", 20)
    assert len(table.read_text().splitlines()) == 1 + 20
    _, *silent, last = err.splitlines()
    assert silent == [f"note: No frame of 0 for {0.01 * 2**k:g} s." for k in range(5)]
    assert last.startswith("Camera 0 has given no frame for 0.2 s; check its cable, ")


def test_a_camera_that_never_gives_a_frame_ends_too(capsys, plugged_in):
    plugged_in([])
    code, out, err = run(capsys, "/dev/video9", "--stalled-after", 0.05)
    assert (code, out) == (10, "")
    assert err.startswith("note: No frame of /dev/video9 for 0.01 s.\n")


@pytest.mark.parametrize("stalled_after", [0, "nan"])
def test_patience_that_makes_no_sense_is_told(capsys, stalled_after):
    code, out, err = run(capsys, 0, "--stalled-after", stalled_after)
    assert (code, out) == (2, "")
    assert err.endswith("expected more than 0 seconds; leave it out for 10, or give inf to wait "
                        "without end.\n")  # fmt: skip


def test_a_recording_may_pause_for_as_long_as_it_likes(capsys, recording, monkeypatch):
    monkeypatch.setattr(streams, "SILENT_S", 0.001)
    given = (recording, "--at-its-rate", "--fps", 1e3, "--stalled-after", 1e-9)
    code, _, err = run(capsys, *given)
    assert code == 0
    assert "No frame" not in err


@pytest.mark.parametrize(("level", "kind"), [(0, "black"), (90, "all the same")])
def test_a_camera_that_shows_nothing_any_more_is_told(capsys, plugged_in, monkeypatch, level, kind):
    plugged_in([*CLIP.frames[:5], *np.full_like(CLIP.frames[:30], level)])
    monkeypatch.setattr(streams, "SILENT_S", 1e-9)
    err = run(capsys, 0, "--stalled-after", 0.2)[2]
    assert f"note: The camera's frames have been {kind} for " in err


def test_a_pipe_is_not_waited_for(capsys, tmp_path):
    os.mkfifo(tmp_path / "pipe.mp4")
    code, _, err = run(capsys, tmp_path / "pipe.mp4")
    assert (code, err) == (
        3,
        f"{tmp_path / 'pipe.mp4'}: is not a regular file; give a recording.\n",
    )
