"""The examples are what their README says; what is open is saved by the browser."""

import base64
import csv
import io
import json
import re
import shlex
from dataclasses import replace
from pathlib import Path
from urllib.parse import parse_qs

import numpy as np
import pytest

from app.ask_tab import Opening, saved
from app.clips import Reading, Source, by_place, perceive
from app.conversation import EMPTY, REPLACED, Talking, offered
from app.sources import EXAMPLE_FOLDER as FOLDER
from app.sources import FIRST, RECORDING_FOLDER, examples
from geotlm_lm import Clip, GeoTLMError, Motion, read_clip
from geotlm_lm.cli.main import main
from tests.app.fakes import FakeAnswerer
from tests.app.test_stage import clip_of, tracked  # noqa: F401

CLIPS = sorted(FOLDER.glob("*.npz"))
COMMANDS = re.findall(r"^geotlm-lm (.*)$", (FOLDER / "README.md").read_text(), re.MULTILINE)


def test_every_clip_on_offer_has_its_command():
    named = sorted(Path(shlex.split(command)[1]).name for command in COMMANDS)
    assert named == [path.name for path in CLIPS]


@pytest.mark.parametrize("command", COMMANDS)
def test_a_clip_is_what_its_command_makes(tmp_path, command):
    words = shlex.split(command)
    name, words[1] = Path(words[1]).name, str(tmp_path / "clip.npz")
    with pytest.raises(SystemExit) as stopped:
        main(words)
    assert stopped.value.code == 0
    made, kept = read_clip(words[1]), read_clip(FOLDER / name)
    # Another processor may round a few pixels differently.
    assert np.abs(made.frames.astype(int) - kept.frames).mean() < 0.05
    assert np.abs(made.background.astype(int) - kept.background).mean() < 0.05
    assert made.notes == kept.notes


def test_a_clips_name_tells_its_object_and_motion_and_the_page_names_the_object_alone():
    for path in CLIPS:
        label = json.loads(str(np.load(path)["label"]))
        assert path.stem == f"{label['object']}_{label['motion']}"
    for key, example in examples().items():
        words = set(example.name.split()) | set(key.split("_"))
        assert not words & {motion.value for motion in Motion}
    assert next(iter(examples())) == FIRST
    assert [key for key in examples() if key.startswith("key")] == ["key", "key_2"]


def test_whole_recordings_come_first_and_are_small():
    keys = list(examples())
    recordings = sorted(RECORDING_FOLDER.glob("*.mov"))
    assert len(recordings) == 4
    assert keys[0] == FIRST
    assert set(keys[:4]) == {f"recording_{path.stem}" for path in recordings}
    for path in recordings:
        assert path.stat().st_size < 400 * 1024
        assert len(read_clip(path)) > 100


def test_a_link_opens_its_example_and_a_wrong_one_nothing(talked):
    talking = Talking(FakeAnswerer())
    opening = Opening(talking.answerer, talking)
    talking.answerer.bundle.reader.lines["Which & way?"] = "way all"
    *_, last = opening.visit({"example": "coin", "q": "Which & way?"})
    assert last["chat"]["exchanges"][0]["question"] == "Which & way?"
    *_, last = opening.visit({"example": "coin"})
    assert last["chat"]["exchanges"] == []
    steps = opening.visit({"example": "no_such", "q": "Which & way?"})
    assert (closed := next(steps))["shown"] is None
    assert closed["stage"] == {}
    assert "click" not in EMPTY  # no question stands there to be clicked
    with pytest.raises(GeoTLMError, match="^The link names the example 'no_such', which does not"):
        next(steps)


def named(shown, name, example=None):
    return replace(shown, source=Source("", name, example))


def content(file):
    return base64.b64decode(file["content"])


@pytest.fixture
def talked():
    answerer = FakeAnswerer()
    answerer.bundle.reader.lines["Which & way?"] = "way all"
    shown = perceive(answerer, clip_of(4))
    shown.session.ask("Which & way?")
    return shown


def test_only_what_there_is_can_be_saved(tracked, talked):  # noqa: F811
    assert offered(None) == {"kinds": []}
    assert offered(tracked)["kinds"] == ["track.csv", "track.json", "track.png"]
    assert offered(named(talked, "cap", "cap"))["kinds"] == ["talk.txt", "talk.json", "link"]
    with pytest.raises(GeoTLMError, match="^There is nothing of this kind to save; open a"):
        saved("track.csv", talked)


def test_the_track_is_saved_frame_by_frame(tracked):  # noqa: F811
    file = saved("track.csv", named(tracked, "my key.npz"))
    assert (file["name"], file["mime"]) == ("my_key_track.csv", "text/csv")
    rows = list(csv.DictReader(io.StringIO(content(file).decode())))
    assert len(rows) == 40
    assert float(rows[25]["time_s"]) == 1.0
    told = json.loads(content(saved("track.json", named(tracked, "my key.npz"))))
    assert told["made_by"]["recording"] == "my key.npz"
    assert len(told["events"]) == len(tracked.encoded.track.events)
    pytest.importorskip("matplotlib", reason="the plot needs matplotlib (extra: track)")
    assert content(saved("track.png", tracked)).startswith(b"\x89PNG")


def test_the_conversation_is_saved_in_words_and_whole(talked):
    (turn,) = json.loads(content(saved("talk.json", talked)))
    assert turn["question"] == "Which & way?"
    said = content(saved("talk.txt", talked)).decode()
    assert said == f"Which & way?\n{turn['answer']['text']}\n"


def test_a_link_names_the_example_and_the_last_question(talked):
    link = saved("link", named(talked, "cap", "bottle_cap"))["link"]
    assert parse_qs(link.removeprefix("?")) == {"example": ["bottle_cap"], "q": ["Which & way?"]}


def test_a_second_recording_is_compared_on_one_scale_until_it_is_closed(tracked, recordings):  # noqa: F811
    talking = Talking(FakeAnswerer())
    opening = Opening(talking.answerer, talking)
    (choosing,) = opening.compare(named(tracked, "cap"))
    assert choosing["stage_second"] == {"chooses": True}
    before = ([], None, choosing["shown"])
    *_, opened = opening.upload([str(recordings["dark"])], *before)
    assert opened["stage"]["name"] == "cap"
    assert opened["stage_second"]["name"] == "dark.npy"
    assert opened["stage"]["scale"] == opened["stage_second"]["scale"]
    assert "Which turned further?" in opened["chips"]
    both = opened["shown"]
    *_, answered = talking.ask("Do they go the same way?", both, [], None)
    assert answered["chat"]["exchanges"][-1]["answer"].startswith("No: the first ")
    assert [row[0] for row in answered["evidence"]["verdicts"]] == ["first", "second"]
    assert "talk.add_clip(answerer.encode(read_clip('dark.npy')))" in answered["code"]
    asked = {"How far did it go?": "extent", "And the first?": "of-first extent"}
    tracked.session.answerer.bundle.reader.lines |= asked
    (second, first) = (list(talking.ask(each, both, [], None))[-1] for each in asked)
    told = [values["chat"]["exchanges"][-1]["answer"] for values in (second, first)]
    assert told[0].startswith("It slides left, ")
    assert [text.partition(" (")[2] for text in told] == [
        "dark.npy, the second).",
        "cap, the first).",
    ]
    tracked.session.answerer.bundle.reader.lines["One word: which way?"] = "way all ; as word"
    *_, formed = talking.ask("One word: which way?", both, [], None)
    assert " " not in formed["chat"]["exchanges"][-1]["answer"]  # what was asked for, nothing more
    assert second["evidence"]["about"] == list(both.second.encoded.clip.notes)
    assert first["evidence"]["about"] == list(both.encoded.clip.notes)
    *_, forgotten = talking.forget(both, [])
    assert len(forgotten["shown"].session.clips) == 2
    *_, closed = opening.close_second(both)
    assert (closed["stage_second"], closed["shown"].second) == ({}, None)
    assert "scale" not in closed["stage"]
    session = closed["shown"].session
    assert (len(session.clips), len(session.history)) == (1, 4)


@pytest.mark.parametrize(
    ("question", "understood"),
    [
        ("When did the key slide?", "In the first recording, when did it slide?"),
        ("when did KEY slip", "In the first recording, when did it slip"),
        ("What happens in the key 2?", "What happens in the second recording?"),
        ("Did key 2.mov turn?", "In the second recording, did it turn?"),
        ("Which turned further, the key or key 2?", None),
        ("Does the keyhole turn?", None),
        ("Which turned further?", None),
        ("How long was the second one held?", "In the second recording, how long was it held?"),
    ],
)
def test_a_recording_is_named_by_its_title(talked, question, understood):
    first, second = named(talked, "key", "key"), named(talked, "key 2.mov")
    assert by_place(question, replace(first, second=second)) == (understood or question)
    assert by_place(question, first) == question
    if "one" not in question:
        assert by_place(question, replace(first, second=first)) == question


def test_a_title_is_known_by_its_words_without_a_number_where_it_is_alone(talked):
    first, second = named(talked, "lemon_1.mov"), named(talked, "pen_1.mov")
    understood = "In the first recording, how far did it turn?"
    assert by_place("How far did the lemon turn?", replace(first, second=second)) == understood
    alike = replace(first, second=named(talked, "lemon_4.mov"))
    assert by_place("How far did the lemon turn?", alike) == "How far did the lemon turn?"


def test_what_was_typed_is_shown_of_a_question_that_names_a_recording(talked, recordings):
    talking = Talking(FakeAnswerer())
    opening = Opening(talking.answerer, talking)
    before = ([], None, replace(named(talked, "cap"), is_paired=True))
    *_, opened = opening.upload([str(recordings["dark"])], *before)
    lines = talked.session.answerer.bundle.reader.lines
    lines["In the first recording, how far did it go?"] = "of-first extent"
    *_, told = talking.ask("How far did the cap go? ", opened["shown"], [], None)
    last = told["chat"]["exchanges"][-1]
    assert last["question"] == "How far did the cap go?"
    assert last["answer"].endswith("(cap, the first).")
    assert "In the first recording, how far did it go?" in told["code"]
    again = [*talking.again(opened["shown"], [], None)][-1]["chat"]["exchanges"]
    assert again == told["chat"]["exchanges"]


@pytest.fixture
def broken(tmp_path):
    (tmp_path / "broken.npy").write_bytes(b"no recording")
    return str(tmp_path / "broken.npy")


def test_a_second_recording_that_fails_leaves_the_first_open(tracked, broken):  # noqa: F811
    before = ([], None, replace(tracked, is_paired=True))
    steps = Opening(FakeAnswerer()).upload([broken], *before)
    assert (kept := next(steps))["stage_second"] == {"chooses": True}
    assert kept["shown"] is before[-1]
    with pytest.raises(GeoTLMError):
        next(steps)
    assert len(tracked.session.clips) == 1
    with pytest.raises(GeoTLMError, match="^No recording is open"):
        next(Opening(FakeAnswerer()).compare(None))


def failing(steps):
    """Return what is shown last by steps that end in a complaint."""
    shown = []
    with pytest.raises(GeoTLMError):
        shown.extend(steps)
    return {name: value for values in shown for name, value in values.items()}


def test_a_recording_that_fails_leaves_the_one_before_and_its_conversation(recordings, broken):
    talking = Talking(FakeAnswerer())
    opening, dark = Opening(talking.answerer, talking), str(recordings["dark"])
    *_, opened = opening.upload([dark], [])
    *_, asked = talking.ask("Which way is it moving?", opened["shown"], [], 0.05)
    shown = failing(opening.upload([dark, broken], [], 0.05, opened["shown"]))
    assert (shown["stage"]["name"], shown["files"]) == ("dark.npy", [dark])
    assert shown["shown"] is opened["shown"]
    assert shown["source"] == opened["source"]
    kept = ("chat", "evidence", "code")
    assert {name: shown[name] for name in kept} == {name: asked[name] for name in kept}
    assert shown["mm_per_px"] == 0.05
    assert "mm_per_px" not in asked  # a field that was filled meanwhile keeps what stands there
    empty = failing(opening.upload([broken], []))
    assert (empty["shown"], empty["files"], empty["stage"]) == (None, None, {})


def test_a_span_that_is_none_leaves_what_is_open_and_one_outside_as_well(recordings):
    opening = Opening(FakeAnswerer())
    *_, opened = opening.upload([str(recordings["dark"])], [])
    before = ([], None, opened["shown"])
    assert failing(opening.read_again(opened["source"], "0", "1.5", None, *before)) == {}
    shown = failing(opening.read_again(opened["source"], "0", "99", None, *before))
    assert (shown["shown"], shown["last_frame"]) == (opened["shown"], "")


def test_a_bag_whose_topic_is_missing_waits_for_it(recordings, bag):
    opening = Opening(FakeAnswerer())
    *_, opened = opening.upload([str(recordings["dark"])], [])
    shown = failing(opening.upload([str(bag)], [], None, opened["shown"]))
    assert (shown["shown"], shown["source"].name) == (None, bag.name)
    *_, read = opening.read_again(shown["source"], "", "", "/left", [], None, None)
    assert read["stage"]["name"] == bag.name


def test_of_a_recording_that_is_stopped_the_part_before_is_open_and_asked_about(long_recording):
    talking = Talking(FakeAnswerer())
    opening = Opening(talking.answerer, talking)
    steps = opening.upload([str(long_recording)], [])
    reading = next(steps)["reading"]
    assert list(opening.stop(reading)) == [{}]
    *_, stopped = steps
    assert stopped["stage"]["notes"] == ["Stopped at 0.2 s of 56.4 s."]
    assert (stopped["stage"]["count"], stopped["stage"]["pending"]) == (5, False)
    assert (stopped["first"], stopped["last_frame"], stopped["reading"]) == ("0", "4", None)
    *_, asked = talking.ask("What happens first and what then?", stopped["shown"], [], None)
    assert len(asked["chat"]["exchanges"]) == 1
    assert "Stopped at 0.2 s of 56.4 s." in asked["evidence"]["notes"]
    assert "span=(0, 4)" in asked["code"]
    *_, whole = opening.read_again(stopped["source"], "", "", None, [], None, stopped["shown"])
    assert (whole["stage"]["notes"], whole["last_frame"]) == ([], "")
    assert list(opening.stop(None)) == [{}]


def test_an_example_that_is_stopped_is_read_whole_by_the_next_visitor():
    opening = Opening(FakeAnswerer())
    steps = opening.example(FIRST, [])
    list(opening.stop(next(steps)["reading"]))
    *_, stopped = steps
    *_, whole = opening.example(FIRST, [])
    assert len(stopped["stage"]["notes"]) == 1
    assert whole["stage"]["notes"] == []
    assert whole["stage"]["count"] > 100


def test_a_question_waits_until_the_recording_is_read(recordings, broken):
    talking = Talking(FakeAnswerer())
    opening = Opening(talking.answerer, talking)
    *_, opened = opening.upload([str(recordings["dark"])], [])
    question, reading = "Which way is it moving?", Reading()
    (waits,) = talking.wait(question, reading, None)
    assert waits["chat"]["pending"] == f"{question} (waiting until the recording is read)"
    assert list(talking.wait(question, None, opened["shown"])) == [{}]
    assert list(talking.wait("", reading, None)) == [{}]


def test_another_recording_that_is_opened_leaves_the_one_that_is_being_read(
    long_recording, recordings, frames
):
    talking = Talking(FakeAnswerer())
    opening, question = Opening(talking.answerer, talking), "Which way is it moving?"
    one = perceive(talking.answerer, Clip(np.stack(frames), fps=25.0))
    left = {"question": question, "answer": REPLACED}
    for before in (None, replace(one, is_paired=True)):
        steps = opening.upload([str(long_recording)], [], None, before)
        reading = next(steps)["reading"]
        list(talking.wait(question, reading, before))
        assert list(opening.stop(reading, is_replaced=True)) == [{}]
        rest = list(steps)
        assert all(values.keys() <= {"stage", "stage_second"} for values in rest)
        assert list(talking.ask(question, before, [], None, reading)) == []
        first, *_, last = opening.upload([str(recordings["dark"])], [], None, before, reading)
        assert first["chat"]["exchanges"] == [left]
        assert (first | last)["chat"] == first["chat"]
        assert last["reading"] is None
        asked = talking.ask(question, last["shown"], [], None, None)
        assert [*asked][-1]["chat"]["exchanges"][0]["answer"] != REPLACED


def test_of_a_link_that_was_left_for_another_recording_nothing_is_asked():
    talking = Talking(FakeAnswerer())
    opening = Opening(talking.answerer, talking)
    steps = opening.visit({"example": FIRST, "q": "Which way is it moving?"})
    list(opening.stop(next(steps)["reading"], is_replaced=True))
    assert all(values.keys() <= {"stage"} for values in steps)


def test_what_was_asked_of_a_recording_that_fails_is_not_answered_of_the_one_before(
    recordings, broken, monkeypatch
):
    talking = Talking(FakeAnswerer())
    opening, question = Opening(talking.answerer, talking), "Which way is it moving?"
    *_, opened = opening.upload([str(recordings["dark"])], [])
    steps = opening.upload([str(recordings["bright"])], [], None, opened["shown"])
    list(talking.wait(question, next(steps)["reading"], None))
    monkeypatch.setattr(opening, "_perceive", lambda *_: read_clip(broken))
    kept = failing(steps)["shown"]
    with pytest.raises(GeoTLMError, match="^This was asked of a recording that failed"):
        next(talking.ask(question, kept, [], None))
    *_, answered = talking.ask(question, kept, [], None)
    assert answered["chat"]["exchanges"][0]["answer"].startswith("It slides left")
