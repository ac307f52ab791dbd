"""`watch` prints events line by line, says what it cannot open, and draws without a window."""

import json
from itertools import islice
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from geotlm_lm.cli.watch import _words
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import Motion
from geotlm_lm.live import watcher as watcher_module
from geotlm_lm.live.watcher import Window
from tests.cli import running
from tests.track.test_idle_tracker import gel, touched

FRAMES = 50


@pytest.fixture
def recording(tmp_path):
    """Half a second untouched, then touched; the reader says it turns all the while."""
    frames = gel()
    clip = [next(frames) for _ in range(12)] + [touched(next(frames)) for _ in range(FRAMES - 12)]
    np.savez(tmp_path / "clip.npz", frames=np.stack(clip), fps=25.0)
    return tmp_path / "clip.npz"


@pytest.fixture(autouse=True)
def formats_loaded(monkeypatch):
    def read(clip, among):
        motion = Motion.CLOCKWISE if Motion.CLOCKWISE in among else Motion.STILL
        return Window(motion, 0.8, turn_deg=4.0)

    monkeypatch.setattr(watcher_module, "model_reader", lambda answerer: read)
    formats = []

    def load(folder, precision):
        formats.append(precision)
        return object()

    monkeypatch.setattr("geotlm_lm.answering.Answerer.load", load)
    return formats


def run(capsys, *arguments):
    return running.run(capsys, "watch", *arguments)


def test_events_are_one_json_object_a_line_and_the_account_is_last(capsys, recording):
    code, out, _ = run(capsys, "--source", recording, "--json")
    lines = [json.loads(line) for line in out.splitlines()]
    assert code == 0
    assert [line.get("phase") for line in lines] == ["start", "end", None]
    assert lines[0]["motion"] == "clockwise"
    assert lines[-1]["type"] == "account"
    assert (lines[-1]["frames"], lines[-1]["dropped"]) == (FRAMES, 0)


def test_words_go_to_stdout_and_the_account_to_stderr(capsys, recording):
    _, out, err = run(capsys, "--source", recording)
    assert out.splitlines()[0].split(" s  ")[1] == "clockwise begins"
    assert f"{FRAMES} frames, none dropped" in err


def test_what_the_reader_guessed_is_told(capsys, recording):
    err = run(capsys, "--source", recording)[2]
    assert (
        "note: Values (uint8) were taken for 0..255, colours for RGB; pass --layout BGR if OpenCV "
        "gave them." in err.splitlines()
    )


def test_a_recording_without_an_untouched_gel_says_so(capsys, tmp_path):
    frames = gel()
    turning = [np.roll(touched(next(frames)), 2 * number, axis=1) for number in range(30)]
    np.savez(tmp_path / "turning.npz", frames=np.stack(turning), fps=25.0)
    code, out, err = run(capsys, "--source", tmp_path / "turning.npz")
    assert (code, out) == (0, "")
    assert (
        "note: No untouched gel was seen, so nothing could be judged; start while nothing touches."
    ) in err.splitlines()


def test_a_rate_that_is_assumed_is_told_and_can_be_given(capsys, tmp_path):
    frames = gel()
    path = tmp_path / "foil.npy"
    np.save(path, np.stack([next(frames) for _ in range(12)]))
    note = f"note: {path} at {{}}"
    assert run(capsys, "--source", path)[2].startswith(
        note.format("25 frames per second, as is assumed; give the rate by --fps.\n")
    )
    given = run(capsys, "--source", path, "--fps", 50)[2]
    assert given.startswith(note.format("50 frames per second.\n"))
    assert run(capsys, "--source", path, "--fps", 0)[0] == 2


def test_a_drawing_has_every_frame(capsys, recording, tmp_path):
    drawing = tmp_path / "new" / "out.mp4"
    code, _, _ = run(capsys, "--source", recording, "--draw", drawing)
    capture = cv2.VideoCapture(str(drawing))
    assert code == 0
    assert capture.get(cv2.CAP_PROP_FRAME_COUNT) == FRAMES


def test_a_drawing_is_named_mp4(capsys, recording):
    assert run(capsys, "--source", recording, "--draw", "out.gif") == (
        2,
        "",
        "--draw out.gif was given, expected a name that ends in .mp4.\n",
    )


@pytest.mark.parametrize("forced", [(), ("--force",)])
def test_a_drawing_never_replaces_the_recording(capsys, tmp_path, forced):
    own = tmp_path / "own.mp4"
    own.write_bytes(b"a recording")
    (tmp_path / "link.mp4").symlink_to(own)
    assert run(capsys, "--source", own, "--draw", tmp_path / "link.mp4", *forced) == (
        2,
        "",
        f"--draw: {tmp_path / 'link.mp4'} is read by this command and would be replaced, expected "
        f"the name of another file; give one.\n",
    )
    assert own.read_bytes() == b"a recording"


def test_a_drawing_replaces_no_other_file_unless_that_is_asked_for(capsys, recording, tmp_path):
    own = tmp_path / "own.mp4"
    own.write_bytes(b"a film of mine")
    assert run(capsys, "--source", recording, "--draw", own) == (
        2,
        "",
        f"--draw: {own} is there already and would be replaced, expected a new name; give one, or "
        f"--force to replace the file.\n",
    )
    assert own.read_bytes() == b"a film of mine"
    assert run(capsys, "--source", recording, "--draw", own, "--force")[0] == 0
    assert cv2.VideoCapture(str(own)).get(cv2.CAP_PROP_FRAME_COUNT) == FRAMES


def test_a_camera_that_does_not_open_ends_with_advice_and_code_7(capsys):
    code, out, err = run(capsys, "--source", "97")
    assert (code, out) == (7, "")
    assert err.startswith("Camera 97 does not open (")
    assert err.count("\n") == 1


def test_a_missing_recording_ends_with_code_3_and_leaves_no_folder_behind(capsys, tmp_path):
    drawing = tmp_path / "new" / "out.mp4"
    code, out, err = run(capsys, "--source", "gone.avi", "--draw", drawing)
    assert (code, out, err) == (3, "", "gone.avi: no such file or folder; check the path.\n")
    assert not drawing.parent.exists()


def test_the_number_format_reaches_the_loader(capsys, recording, formats_loaded):
    assert run(capsys, "--source", recording, "--precision", "int8")[0] == 0
    assert formats_loaded == ["int8"]


def test_a_question_that_cannot_be_asked_is_told_before_the_source_is_opened(capsys):
    sentence = "The question is empty; ask for example --q 'Which way is it turning?'.\n"
    assert run(capsys, "--source", "gone.avi", "--q", " ") == (2, "", sentence)


def test_a_motion_whose_frames_cannot_be_read_does_not_end_the_stream():
    class Blind:
        ask = None

        def encode(self, clip):
            raise UnreadableClip("the frames are black.")

    watcher = SimpleNamespace(clip_of=lambda event: "its clip")
    event = SimpleNamespace(phase="end")
    told = _words(Blind(), watcher, event, "How far?")
    assert told == "I cannot read this motion's frames: the frames are black."


def test_a_grey_array_is_watched_with_its_layout(capsys, tmp_path):
    frames = gel()
    path = tmp_path / "grey.npy"
    np.save(path, np.stack([next(frames) for _ in range(12)]).mean(axis=-1).astype(np.uint8))
    code, _, err = run(capsys, "--source", path)
    assert (code, err.count("pass --layout THW")) == (3, 1)
    code, _, err = run(capsys, "--source", path, "--layout", "THW")
    assert (code, "12 frames" in err) == (0, True)
    assert run(capsys, "--source", "recording.avi", "--layout", "HW")[0] == 2


@pytest.mark.parametrize(("options", "columns"), [((), 224), (("--square-pixels",), 223)])
@pytest.mark.parametrize("name", ["square.npz", "square.avi"])
def test_frames_of_224_pixels_are_taken_as_asked(
    capsys, tmp_path, monkeypatch, name, options, columns
):
    frames = [cv2.resize(touched(one), (224, 224)) for one in islice(gel(), 30)]
    frames[:15] = [cv2.resize(one, (224, 224)) for one in islice(gel(), 15)]
    if name.endswith(".npz"):
        np.savez(tmp_path / name, frames=np.stack(frames), fps=25.0)
    else:
        codec = cv2.VideoWriter_fourcc(*"MJPG")
        writer = cv2.VideoWriter(str(tmp_path / name), codec, 25.0, (224, 224))
        for one in frames:
            writer.write(one)
        writer.release()
    widths = set()

    def read(clip, among):
        widths.add((clip.frames.shape[2], clip.background.shape[1]))
        return Window(Motion.STILL, 0.8)

    monkeypatch.setattr(watcher_module, "model_reader", lambda answerer: read)
    drawing = ("--draw", tmp_path / "out.mp4")
    assert run(capsys, "--source", tmp_path / name, *options, *drawing)[0] == 0
    assert widths == {(columns, columns)}
