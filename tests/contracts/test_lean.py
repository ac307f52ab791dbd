"""Lean by construction: what a question or a command does not need does not run and is not loaded.

The scenes' counterpart is in tests/simulation/test_stages.py.
"""

import ast
import copy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch

import geotlm_lm
from geotlm_lm.answering import Answerer
from geotlm_lm.answering import perceiving as perceiving_room
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import first_kinds_of, recording

FOREIGN = "In welche Richtung dreht es sich?"

PERCEIVED = {"choose", "touch", "encode", "total"}
SPOKEN = PERCEIVED | {"generate"}
CHECKED = PERCEIVED | {"check"}


class Counting:
    """A speaker that counts how often each half of it runs; its words name a motion."""

    def __init__(self, sentence):
        self.sentence, self.generated, self.checked = sentence, 0, 0

    def generate(self, fused_token, questions):
        self.generated += 1
        return [self.sentence] * len(questions)

    def would_write(self, fused_token, question, sentence):
        self.checked += 1
        return sentence == self.sentence


@pytest.fixture
def answerer(bundle):
    speaking = copy.copy(bundle)
    speaking.grammar = first_kinds_of(bundle.grammar)
    sentence = speaking.grammar.sentence(Slots("direction", direction=Motion.CLOCKWISE))
    speaking.speaker = Counting(sentence)
    return Answerer(speaking)


@pytest.fixture
def encodings(bundle, monkeypatch):
    """Return a list that grows by one at each pass through the backbone."""
    calls, encode = [], bundle.model.backbone.encode
    monkeypatch.setattr(
        bundle.model.backbone, "encode", lambda clips: calls.append(len(clips)) or encode(clips)
    )
    return calls


@pytest.mark.parametrize(
    ("question", "stages", "checks"),
    [
        ("Which way is it moving?", CHECKED, 1),
        ("Is it turning clockwise?", SPOKEN, 0),
        ("Is anything touching the gel?", SPOKEN, 0),
        ("And played backwards?", PERCEIVED, 0),
        (FOREIGN, PERCEIVED, 0),
        ("The image is mirrored.", PERCEIVED, 0),
        ("How deep does it press in?", PERCEIVED, 0),
        ("Did it turn 45 degrees?", PERCEIVED, 0),
    ],
)
def test_a_question_runs_the_stages_it_needs(answerer, question, stages, checks):
    answer = answerer.ask(answerer.encode(recording()), question)
    assert set(answer.timing_ms) == stages
    speaker = answerer.bundle.speaker
    assert (speaker.generated, speaker.checked) == ("generate" in stages, checks)


def test_several_questions_share_one_encoding(answerer, encodings):
    session = answerer.session(answerer.encode(recording()))
    for question in ("Which way is it moving?", "Is it turning clockwise?", "Seen from behind?"):
        session.ask(question)
    assert encodings == [1]


@pytest.fixture
def looks(monkeypatch):
    """Return a list that grows by the name of each step of looking at a clip."""
    calls = []

    def count(room, name):
        step = getattr(room, name)
        monkeypatch.setattr(room, name, lambda *given: calls.append(name) or step(*given))

    count(perceiving_room, "belief_of")
    return calls


def test_what_is_believed_is_worked_out_once_and_only_where_a_motion_is_asked_about(bundle, looks):
    answerer = Answerer(bundle)
    encoded = answerer.encode(recording())
    answerer.ask(encoded, FOREIGN)
    assert looks == []
    for question in ("Which way is it moving?", "How far did it turn?", "Is it pressing in?"):
        answerer.ask(encoded, question)
    assert looks == ["belief_of"]


def test_a_doubt_and_a_repetition_run_nothing(answerer, encodings):
    session = answerer.session(answerer.encode(recording()))
    session.ask("Which way is it moving?")
    for question in ("Are you sure?", "Say that again."):
        session.ask(question)
    speaker = answerer.bundle.speaker
    assert (speaker.generated, speaker.checked, encodings) == (0, 1, [1])


def test_reasons_cost_no_encoding_and_no_word(answerer, encodings):
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, "Which way is it moving?")
    answerer.why(encoded, answer)
    assert answerer.bundle.speaker.generated == 0
    assert encodings == [1]


def test_two_clips_are_encoded_once_each(answerer, encodings):
    pair = [answerer.encode(recording()) for _ in range(2)]
    answerer.compare(*pair)
    answerer.order(pair)
    assert encodings == [1, 1]


def test_what_holds_no_picture_is_never_encoded(answerer, encodings):
    black = Clip(np.zeros((4, 32, 32, 3), np.uint8))
    with pytest.raises(geotlm_lm.GeoTLMError):
        answerer.encode(black)
    assert encodings == []


def test_no_gradient_is_kept_on_the_way_to_an_answer(bundle, monkeypatch):
    answerer, seen = Answerer(bundle), []
    logits = type(bundle.speaker.model).logits

    def spy(model, hidden):
        seen.append(logits(model, hidden))
        return seen[-1]

    monkeypatch.setattr(type(bundle.speaker.model), "logits", spy)
    with torch.enable_grad():
        encoded = answerer.encode(recording())
        answerer.ask(encoded, "Which way is it moving?")
        answerer.ask(encoded, "Is it turning clockwise?")
    tensors = [encoded.perception.fused_token, encoded.perception.geometry.mask, *seen]
    assert len(seen) >= 2  # of checking and of generating
    assert not any(one.requires_grad or one.grad_fn for one in tensors)


HEAVY = {"torch", "transformers", "tokenizers", "cv2", "scipy", "sklearn", "matplotlib", "gradio"}
HEAVY |= {"rich", "PIL", "filelock"}
ANSWERING = {"torch", "tokenizers", "cv2"}
READING = {"cv2"}
SIMULATING = {"torch", "cv2"}

NEEDS = {
    "--version": set(),
    "--help": set(),
    "answer --help": set(),
    "bench --help": set(),
    "evaluate --help": set(),
    "bench render --help": set(),
    "info --clip CLIP": READING,
    "simulate --clip MADE": SIMULATING,
    "answer --clip CLIP --q Which?": ANSWERING,
    "answer --clip CLIP --q Which? --why": ANSWERING,
    "chat --clip CLIP": ANSWERING,
    "watch --source CLIP": ANSWERING,
}
"""Command -> the heavy packages it may load; no other one."""

MODELLESS = {"answering", "language", "checkpoint", "backbone", "training", "benchmarks"}
"""Rooms that no command loads which needs no model."""


@pytest.fixture(scope="module")
def clip_path(tmp_path_factory):
    rng = np.random.default_rng(0)
    frames = rng.normal(110, 1, (9, 48, 64, 3))
    for number in range(4, 9):
        frames[number, 18:30, 10 + 3 * number : 24 + 3 * number] += 30
    path = tmp_path_factory.mktemp("clip") / "clip.npy"
    np.save(path, frames.round().astype(np.uint8))
    return path


@pytest.mark.parametrize("command", NEEDS)
def test_a_command_loads_what_it_needs_and_nothing_else(command, clip_path):
    needs = NEEDS[command]
    if needs == ANSWERING and not (Path(geotlm_lm.__file__).parent / "bundle").is_dir():
        pytest.skip("needs the trained bundle")
    places = {"CLIP": str(clip_path), "MADE": str(clip_path.with_name("made.npz"))}
    words = [places.get(word, word) for word in command.split()]
    loaded = modules_after(words)
    outermost = {name.partition(".")[0] for name in loaded}
    assert outermost & HEAVY <= needs
    rooms = {name.split(".")[1] for name in loaded if name.startswith("geotlm_lm.")}
    if needs != ANSWERING:
        assert not rooms & MODELLESS
    assert "training" not in rooms


def modules_after(words):
    """Return the names of all modules loaded when a command has ended."""
    program = (
        "import sys\nfrom geotlm_lm.cli.main import main\n"
        f"try:\n    main({words!r})\n"
        "except SystemExit as ended:\n    code = ended.code\n"
        "print()\nprint((code, sorted(sys.modules)))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], input="", capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    code, names = ast.literal_eval(done.stdout.splitlines()[-1])
    assert code in (0, None), done.stderr
    return names
