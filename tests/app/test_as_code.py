"""A question as code asks the same: the command parses, Python runs, the call is whole."""

import json
import shlex
import subprocess
from types import SimpleNamespace

import pytest
from app.as_code import calls_of
from app.parameters import frame_of

from geotlm_lm import FrameSpec

CAMERA = FrameSpec()


def test_the_command_is_one_that_a_shell_takes_apart_again():
    calls = calls_of("it's mine.npz", ["Is it 'still'?"], FrameSpec(mm_per_px=0.06), (3, 9))
    assert shlex.split(calls.command) == [
        *("geotlm-lm", "answer", "--clip", "it's mine.npz", "--q", "Is it 'still'?"),
        *("--mm-per-px", "0.06", "--frames", "3:9"),
    ]


FRAMES = [
    CAMERA,
    FrameSpec(image_mirrored=True, viewpoint="object"),
    FrameSpec(image_upside_down=True, actor="sensor", mm_per_px=0.1),
    FrameSpec(image_quarter_turn="counterclockwise", thread="left", contact_side="shank"),
]


@pytest.mark.parametrize("frame", FRAMES)
def test_the_frame_is_stated_as_values(frame):
    calls = calls_of("a.npz", ["Which way?"], frame)
    assert asked_by(calls.python) == [("a.npz", None), ("Which way?", frame)]
    sent = sent_by(calls.rest)
    assert (sent.pop("recording"), sent.pop("question")) == ("/uploaded.npz", "Which way?")
    assert frame_of(**sent) == frame


def test_a_command_states_the_facts_in_its_question():
    calls = calls_of("a.npz", ["Which way?"], FRAMES[1])
    stated = "The image is mirrored. I look from the object's side. Which way?"
    assert shlex.split(calls.command)[-1] == stated


def asked_by(program):
    """Run a program with stand-ins for the model and the file, and return what it did."""
    did = []

    def session(seen, frame=CAMERA):
        return SimpleNamespace(
            ask=lambda text: did.append((text, frame)) or SimpleNamespace(text=text)
        )

    answerer = SimpleNamespace(
        encode=lambda clip, span=None: did.append((clip, span)),
        ask=lambda seen, text, frame=CAMERA: session(seen, frame).ask(text),
        session=session,
    )
    lines = program.splitlines()
    assert lines[0].startswith("from geotlm_lm import Answerer, ")
    names = {
        "FrameSpec": FrameSpec,
        "Answerer": SimpleNamespace(load=lambda: answerer),
        "read_clip": lambda path, topic=None: path if topic is None else (path, topic),
    }
    exec("\n".join(lines[1:]), names)
    return did


def test_the_program_asks_one_question_or_the_whole_conversation():
    one = calls_of("a.npz", ["Which way?"], CAMERA, (3, 9)).python
    assert asked_by(one) == [("a.npz", (3, 9)), ("Which way?", CAMERA)]
    asked, frame = ["Which way?", "And 'mirrored'?", "Why?"], FrameSpec(mm_per_px=0.1)
    talk = calls_of("a.npz", asked, frame)
    assert asked_by(talk.python) == [("a.npz", None), *((one, frame) for one in asked)]


def test_the_topic_of_a_bag_is_in_every_call():
    calls = calls_of("run.mcap", ["Which way?"], CAMERA, (3, 9), topic="/gel/image")
    assert shlex.split(calls.command)[-2:] == ["--topic", "/gel/image"]
    assert asked_by(calls.python) == [
        (("run.mcap", "/gel/image"), (3, 9)),
        ("Which way?", CAMERA),
    ]
    asked = {"question": "Which way?", "frames": [3, 9], "topic": "/gel/image"}
    assert sent_by(calls.rest) == {"recording": "/uploaded.npz"} | asked


def sent_by(script):
    """Return what a call over REST sends, with a stand-in for the upload."""
    script = "\n".join(["clip=/uploaded.npz", script.splitlines()[2], 'printf %s "$asked"'])
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def test_the_call_sends_the_question_as_it_is():
    question = "Is it 'left', \"right\" or $HOME?"
    calls = calls_of("my clip.npz", [question], CAMERA, address="http://localhost:1")
    assert sent_by(calls.rest) == {"recording": "/uploaded.npz", "question": question}
    url, clip, *_ = calls.rest.splitlines()
    assert url == "url=http://localhost:1/gradio_api"
    assert shlex.split(clip[len("clip=$(") :].split(" | ")[0])[3] == "files=@my clip.npz"
