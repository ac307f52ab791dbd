"""`answer` prints the answer alone, notes on the side, and refuses bad clips in one sentence."""

import json
import sys
from dataclasses import dataclass
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from geotlm_lm.recordings.read import frames_inside
from tests.cli.running import run
from tests.recordings.test_failures import CASES


class FakeAnswerer:
    abstained = False

    def __init__(self):
        self.clips, self.spans, self.questions, self.folders = [], [], [], []
        self.frames = []

    def load(self, folder=None):
        self.folders.append(folder)
        return self

    def encode(self, clip, span=None):
        self.clips.append(clip)
        self.spans.append(span)
        return clip if span is None else frames_inside(clip, span)

    def ask(self, encoded, question, *, frame):
        self.questions.append(question)
        self.frames.append(frame)
        return SimpleNamespace(
            text="Clockwise.",
            abstained=self.abstained,
            notes=("Frames 0, 1, 2, 3 are used.",),
            to_dict=lambda: {"text": "Clockwise.", "direction": "clockwise"},
        )

    def why(self, encoded, answer):
        return Why(("Contact fills the gel.", f"Therefore: {answer.text}"), "by rule")


@dataclass(frozen=True)
class Why:
    steps: tuple
    source: str


@pytest.fixture
def answerer(monkeypatch):
    fake = FakeAnswerer()
    module = ModuleType("geotlm_lm.answering")
    module.Answerer = SimpleNamespace(load=fake.load)
    monkeypatch.setitem(sys.modules, "geotlm_lm.answering", module)
    return fake


@pytest.fixture
def clip_path(tmp_path):
    path = tmp_path / "clip.npy"
    frames = np.random.default_rng(0).integers(0, 255, (30, 24, 32, 3)).astype(np.uint8)
    np.save(path, frames)
    return path


@pytest.fixture
def ask(capsys, answerer, clip_path):
    """Ask which way, with some options."""
    return lambda *options: run(capsys, "answer", clip_path, "--q", "Which way?", *options)


def test_the_sentence_goes_to_stdout_and_notes_to_stderr(ask, answerer):
    assert ask() == (0, "Clockwise.\n", "note: Frames 0, 1, 2, 3 are used.\n")
    assert answerer.questions == ["Which way?"]
    assert len(answerer.clips[0]) == 30


def test_json_is_one_object_on_the_last_line(ask):
    code, out, _ = ask("--json")
    assert code == 0
    assert json.loads(out.splitlines()[-1]) == {"text": "Clockwise.", "direction": "clockwise"}
    told = json.loads(ask("--why", "--json")[1])
    assert (told["direction"], told["why"]["source"]) == ("clockwise", "by rule")


def test_why_prints_the_reasons_before_the_answer_and_their_source_aside(ask):
    code, out, err = ask("--why")
    assert (code, out) == (0, "Contact fills the gel.\nClockwise.\n")
    assert err.splitlines()[-1] == "note: the reasons are told by rule"


def test_the_frames_asked_for_are_the_ones_the_model_is_given(ask, answerer):
    ask("--frames", "10:19")
    assert answerer.spans == [(10, 19)]


def test_background_rate_and_model_reach_their_seams(ask, answerer, tmp_path):
    idle = tmp_path / "idle.npy"
    np.save(idle, np.full((24, 32, 3), 7, np.uint8))
    ask("--background", idle, "--fps", 12, "--model", tmp_path)
    assert answerer.clips[0].fps == 12
    assert (answerer.clips[0].background == 7).all()
    assert answerer.folders == [tmp_path]


def test_the_size_of_a_pixel_reaches_the_frame(ask, answerer):
    assert ask()[0] == ask("--mm-per-px", 0.06)[0] == 0
    assert [frame.mm_per_px for frame in answerer.frames] == [None, 0.06]
    code, _, err = ask("--mm-per-px", 40)
    assert code == 2
    assert "A pixel of 40 mm was given, expected 0.001 to 2 mm" in err


def test_an_abstention_fails_only_when_asked_to(ask, answerer, clip_path):
    answerer.abstained = True
    assert ask()[0] == 0
    code, out, err = ask("--fail-on-abstain")
    assert (code, out) == (5, "Clockwise.\n")
    assert err.splitlines()[-1] == (
        f"{clip_path}: the model would not answer; see `geotlm-lm info {clip_path}` for "
        f"contact, or give a part with more motion by --frames."
    )


@pytest.mark.parametrize(("command", "name"), [("answer", "nan.npy"), ("info", "bomb.npz")])
def test_a_bad_clip_ends_with_its_sentence_and_code_3(capsys, answerer, tmp_path, command, name):
    content, sentence = CASES[name]
    path = tmp_path / name
    path.write_bytes(content)
    question = ["--q", "Which way?"] if command == "answer" else []
    done = run(capsys, command, path, *question)
    assert done == (3, "", f"{path}: {sentence}\n")
    assert answerer.clips == []


def test_a_span_outside_the_recording_ends_with_code_2(ask):
    assert ask("--frames", "20:90") == (
        2,
        "",
        "Frames 20:90 were asked for, expected FIRST < LAST within 0:29; "
        "give frame numbers inside the recording.\n",
    )


def test_square_pixels_are_told_to_the_reader(capsys, answerer, tmp_path):
    path = tmp_path / "square.npy"
    np.save(path, np.random.default_rng(0).integers(0, 255, (4, 224, 224, 3)).astype(np.uint8))
    asked = ("answer", path, "--q", "Which way?")
    run(capsys, *asked)
    run(capsys, *asked, "--square-pixels")
    assert [clip.frames.shape[1:3] for clip in answerer.clips] == [(224, 224), (224, 223)]
