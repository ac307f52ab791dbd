"""`chat` reads lines from a pipe: questions, facts, commands; mistakes do not end it."""

import io
import json

import numpy as np
import pytest

from geotlm_lm.answering import Answerer
from tests.answering.scripted import feeling
from tests.cli.running import run

DIRECTION = "It turns clockwise, about 12 degrees, in the camera image."


@pytest.fixture
def clip_path(tmp_path):
    frames = np.random.default_rng(0).integers(80, 130, (4, 24, 32, 3)).astype(np.uint8)
    np.save(tmp_path / "clip.npy", frames)
    return tmp_path / "clip.npy"


@pytest.fixture
def talk(monkeypatch, capsys, bundle, clip_path):
    """Pipe lines into a conversation about a clip that turns clockwise."""
    folders = []

    def load(folder):
        folders.append(folder)
        return feeling(bundle, "clockwise")

    monkeypatch.setattr(Answerer, "load", load)

    def piped(*lines, options=()):
        monkeypatch.setattr("sys.stdin", io.StringIO("".join(f"{line}\n" for line in lines)))
        code, out, err = run(capsys, "chat", clip_path, *options)
        assert code == 0
        return out.splitlines(), err.splitlines()

    piped.folders = folders
    return piped


def test_each_line_is_answered_on_a_line_of_its_own(talk):
    out, err = talk("Which way?", "", "Are you sure?")
    assert out == [DIRECTION, f"About 95%: i{DIRECTION[1:]}"]
    assert all(line.startswith("note: ") for line in err)


def test_the_frame_is_set_told_and_reset(talk):
    out, _ = talk("/frame", "/frame fact seen object", "Which way?", "/frame reset", "Which way?")
    assert out == [
        "Frame: camera image, looking out of the sensor, object relative to sensor.",
        "Frame: camera image, seen from the object, object relative to sensor.",
        "It turns counterclockwise, about 12 degrees, seen from the object's side.",
        "Frame: camera image, looking out of the sensor, object relative to sensor.",
        DIRECTION,
    ]


def test_an_unknown_fact_is_refused_with_examples(talk):
    out, err = talk("/frame cannot look")
    assert out == []
    assert err[-1].startswith("'cannot look' is no fact I know; say for example 'left-hand thread'")


def test_json_holds_the_whole_answer_until_it_is_switched_off(talk):
    out, _ = talk("/json", "Which way?", "/json", "Which way?")
    assert json.loads(out[0])["direction"] == "clockwise"
    assert out[1:] == ["It turns clockwise, about 12 degrees."]


def test_evidence_is_one_json_object(talk):
    out, _ = talk("/evidence")
    assert {"contact_share", "regions", "view"} <= set(json.loads(out[0]))


def test_reasons_end_in_the_last_answer_and_their_source_is_a_note(talk):
    out, err = talk("Which way?", "/why")
    assert out[1].startswith("Contact fills ")
    assert out[-1] == f"Therefore: {DIRECTION}"
    assert err[-1] == "note: told by rule, from the geometry the model read"


def test_reasons_before_any_answer_are_refused(talk):
    assert talk("/why")[1][-1] == ("there is no answer about one clip yet; ask a question first.")


def test_model_and_size_of_a_pixel_reach_the_loader_and_the_frame(talk, tmp_path):
    out, _ = talk("/frame", "again", options=("--model", tmp_path, "--mm-per-px", "0.06"))
    assert talk.folders == [tmp_path]
    assert "0.06 mm per pixel" in out[0]


def test_history_repeats_the_turns(talk):
    out, _ = talk("Which way?", "/history")
    assert out[1:] == ["> Which way?", DIRECTION]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("/clip gone.npy", "gone.npy: no such file or folder; check the path."),
        ("/clip", "/clip needs a path, such as /clip other.npz."),
        ("/dance", "there is no /dance; did you mean '/evidence'?"),
        ("/frame fact unclear thread", "I did not understand which thread it is;"),
    ],
)
def test_a_mistake_is_told_and_the_conversation_goes_on(talk, line, message):
    out, err = talk(line, "Which way?")
    assert out == [DIRECTION]
    assert any(told.startswith(message) for told in err)


@pytest.mark.parametrize("word", ["/quit", "bye!"])
def test_quit_ends_it_before_the_input_does(talk, word):
    assert talk(word, "Which way?")[0] == []


def test_a_note_says_why_a_value_alone_is_unknown(talk):
    out, err = talk("unit mm amount slide ; as number")
    assert out == ["unknown"]
    assert err[-1].startswith("note: I need the size of a pixel")


def test_help_lists_every_command_with_and_without_a_stroke(talk):
    out, _ = talk("/help")
    assert talk("Help")[0] == out
    for command in ("/clip", "/evidence", "/frame", "/history", "/json", "/quit", "/why"):
        assert any(line.startswith(command) for line in out)


def test_reasons_after_another_clip_are_of_the_clip_before_and_say_so(talk, clip_path, tmp_path):
    other = tmp_path / "other.npy"
    np.save(other, np.load(clip_path)[:, ::-1])
    before = talk("Which way?", "/why")[0][1:]
    out, _ = talk("Which way?", f"/clip {other}", "/why", "Are you sure?", "Which way?", "/why")
    assert out[2] == "Of the clip before:"
    assert out[3 : 3 + len(before)] == before
    doubt, again, *after = out[3 + len(before) :]
    assert doubt.startswith("About ")  # of the clip that is open
    assert "clip before" not in doubt
    assert again == "It turns clockwise, about 12 degrees."
    assert "Of the clip before:" not in after


def test_another_clip_is_read_as_the_first_was_asked_to_be(talk, tmp_path, clip_path):
    frames = np.random.default_rng(1).integers(80, 130, (4, 3, 24, 32)).astype(np.uint8)
    np.save(tmp_path / "planes.npy", frames)
    options = ("--layout", "THWC", "--fps", "7")
    out, err = talk(f"/clip {clip_path}", "file rate", options=options)
    assert out[-1] == "7 frames per second."
    _, err = talk(f"/clip {tmp_path / 'planes.npy'}", options=options)
    assert "THWC" in err[-1]
