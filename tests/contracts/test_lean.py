"""Lean by construction: what a question or a command does not need does not run and is not loaded.

The scenes' counterpart is in tests/simulation/test_simulate.py.
"""

import ast
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
from tests.answering.scripted import ScriptedReader, feeling, read_by, recording


@pytest.fixture
def answerer(bundle):
    return feeling(bundle, "clockwise")


@pytest.fixture
def encodings(bundle, monkeypatch):
    """Return a list that grows by one at each pass through the backbone."""
    calls, encode = [], bundle.model.backbone.encode
    monkeypatch.setattr(
        bundle.model.backbone, "encode", lambda clips: calls.append(len(clips)) or encode(clips)
    )
    return calls


@pytest.mark.parametrize("question", ["way all", "cw", "backwards way all", "fact mirrored"])
def test_a_question_is_read_once(answerer, question):
    answer = answerer.ask(answerer.encode(recording()), question)
    assert set(answer.timing_ms) == {"choose", "touch", "encode", "read", "answer", "total"}
    assert len(answerer.bundle.reader.heard) == 1


def test_questions_share_one_encoding_of_a_clip_and_a_doubt_one_answer(answerer, encodings):
    pair = [answerer.encode(recording()) for _ in range(2)]
    session = answerer.session(pair[0])
    answer = session.ask("way all")
    assert session.ask("sure").values is answer.values
    for question in ("cw", "behind again", "why"):
        session.ask(question)
    for question in ("same way all", "which-clip cw"):
        answerer.compare(*pair, question)
    assert encodings == [1, 1]


def test_what_is_believed_is_worked_out_once_and_not_for_a_fact_alone(bundle, monkeypatch):
    looks, step = [], perceiving_room.belief_of
    monkeypatch.setattr(
        perceiving_room, "belief_of", lambda *given: looks.append(1) or step(*given)
    )
    answerer = Answerer(read_by(bundle, ScriptedReader()))
    encoded = answerer.encode(recording())
    answerer.ask(encoded, "fact mirrored")
    assert looks == []
    for question in ("way all", "amount turn", "in"):
        answerer.ask(encoded, question)
    assert looks == [1]


def test_what_holds_no_picture_is_never_encoded(answerer, encodings):
    black = Clip(np.zeros((4, 32, 32, 3), np.uint8))
    with pytest.raises(geotlm_lm.GeoTLMError):
        answerer.encode(black)
    assert encodings == []


def test_no_gradient_is_kept_on_the_way_to_an_answer(bundle):
    answerer = Answerer(read_by(bundle, ScriptedReader()))
    with torch.enable_grad():
        encoded = answerer.encode(recording())
        answerer.ask(encoded, "way all")
    tensors = [encoded.perception.fused_token, encoded.perception.geometry.mask]
    assert not any(one.requires_grad or one.grad_fn for one in tensors)


HEAVY = {"torch", "transformers", "tokenizers", "cv2", "scipy", "sklearn", "matplotlib", "gradio"}
HEAVY |= {"rich", "PIL", "filelock", "ray"}
ANSWERING = {"torch", "tokenizers", "cv2"}
READING = {"cv2"}
SIMULATING = {"torch", "cv2"}

NEEDS = {
    "--version": set(),
    "--help": set(),
    "answer --help": set(),
    "bench render --help": set(),
    "info --clip CLIP": READING,
    "doctor CLIP": READING,
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
