"""Rows for every clip and question, whatever happens on the way."""

import json
import os
import pickle
import signal

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from geotlm_lm import answer_schema
from geotlm_lm.answering import Answerer, batch
from geotlm_lm.answering.batch import answer_all
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.data_sets.lerobot import read_data_set
from geotlm_lm.data_sets.stored_episode import every_episode
from geotlm_lm.recordings import listing
from geotlm_lm.recordings.listing import StoredRecording
from geotlm_lm.workers import LOST, Workers
from tests.answering.scripted import feeling, recording
from tests.data_sets.lerobot_files import CAMERA, turned, write_data_set
from tests.tiny_bundle import tiny_bundle

QUESTIONS = ["Which way?", "backwards > way"]


@pytest.fixture
def clips(tmp_path):
    """Three recordings, the second of which is damaged, and a file that is none."""
    folder = tmp_path / "clips"
    folder.mkdir()
    for name in ("a", "c"):
        np.save(folder / f"{name}.npy", recording(frames=6).frames)
    (folder / "b.npy").write_bytes(b"no array")
    (folder / "readme.txt").write_text("not a clip")
    return folder


def clips_in(folder):
    return list(map(StoredRecording, listing.clips_in(folder)))


def answer_by(answerer, *args, **options):
    return answer_all(lambda: answerer, *args, **options)


SENT_ANSWERER = []


def sent_answerer():
    return SENT_ANSWERER[0]


class Sending:
    """Works here with what other processes would be sent."""

    def each_done(self, work, parts, **_):
        return map(pickle.loads(pickle.dumps(work)), pickle.loads(pickle.dumps(parts)))


def rows_in(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


def test_every_clip_and_question_gets_a_row_in_order(bundle, clips, tmp_path):
    out = tmp_path / "a folder to be made" / "answers.jsonl"
    result = answer_by(feeling(bundle, "left"), clips_in(clips), QUESTIONS, out)
    rows = rows_in(out)
    assert [(row["clip"], row["question"]) for row in rows] == [
        (clip, question) for clip in ("a.npy", "b.npy", "c.npy") for question in QUESTIONS
    ]
    assert (result.rows, result.errors, result.continued) == (6, 2, 0)
    assert [row["answer"]["direction"] for row in rows if row["answer"]] == ["left", "right"] * 2
    bad = [row for row in rows if row["clip"] == "b.npy"]
    assert [row["answer"] for row in bad] == [None, None]
    assert bad[0]["error"] == bad[1]["error"]
    assert bad[0]["error"].startswith(str(clips / "b.npy"))


def test_other_processes_can_be_sent_the_work(bundle, clips, tmp_path, monkeypatch):
    monkeypatch.setitem(globals(), "SENT_ANSWERER", [feeling(bundle, "left")])
    out = tmp_path / "answers.jsonl"
    result = answer_all(sent_answerer, clips_in(clips), QUESTIONS, out, workers=Sending())
    assert (result.rows, result.errors) == (6, 2)


class Deadly(StoredRecording):
    """A recording whose decoder ends the process."""

    def read(self):
        os.kill(os.getpid(), signal.SIGKILL)


def tiny_answerer():
    return feeling(tiny_bundle(), "left")


@pytest.mark.skipif(os.name == "nt", reason="a process is ended there in other ways")
def test_a_recording_that_ends_its_process_has_rows_that_say_so_and_is_not_begun_again(
    clips, tmp_path
):
    found, out = clips_in(clips), tmp_path / "answers.jsonl"
    found[1] = Deadly(found[1].path)
    with pytest.raises(Stopped):  # even where the run is stopped before it has its file
        answer_all(tiny_answerer, found, QUESTIONS, out, workers=Workers(1), progress=stop_after(3))
    result = answer_all(tiny_answerer, found, QUESTIONS, out)
    assert (result.rows, result.errors, result.continued) == (6, 2, 6)
    rows = rows_in(out)
    assert [row["clip"] for row in rows if row["error"]] == ["b.npy", "b.npy"]
    assert rows[2]["error"] == f"b.npy: {LOST}"


def test_a_question_that_cannot_be_asked_spoils_its_own_row_only(bundle, clips, tmp_path):
    out = tmp_path / "answers.jsonl"
    answer_by(
        feeling(bundle, "left"), [StoredRecording(clips / "a.npy")], ["  ", "Which way?"], out
    )
    refused, answered = rows_in(out)
    assert refused["error"].startswith("The question is empty")
    assert answered["error"] is None
    assert answered["answer"]["direction"] == "left"


def test_rows_follow_the_published_schema(bundle, clips, tmp_path):
    schema, out = answer_schema(), tmp_path / "answers.jsonl"
    answer_by(feeling(bundle, "left"), clips_in(clips), QUESTIONS, out)
    validator = Draft202012Validator(schema)
    for row in rows_in(out):
        assert list(validator.descend(row, schema["$defs"]["batch_row"])) == []


def test_a_clip_is_encoded_once(bundle, clips, tmp_path, monkeypatch):
    seen, encode = [], Answerer.encode
    monkeypatch.setattr(
        Answerer, "encode", lambda self, clip, span: seen.append(clip.name) or encode(self, clip)
    )
    answer_by(
        feeling(bundle, "left"), [StoredRecording(clips / "a.npy")], QUESTIONS, tmp_path / "x.jsonl"
    )
    assert len(seen) == 1


class Stopped(BaseException):
    """A run ended from outside, as by Ctrl-C."""


def stop_after(count):
    def progress(done, total):
        if done == count:
            raise Stopped

    return progress


def test_a_stopped_run_leaves_no_file_and_continues_with_the_same_rows(bundle, clips, tmp_path):
    whole, out = tmp_path / "whole.jsonl", tmp_path / "answers.jsonl"
    found, answerer = clips_in(clips), feeling(bundle, "left")
    answer_by(answerer, found, QUESTIONS, whole)
    with pytest.raises(Stopped):
        answer_by(answerer, found, QUESTIONS, out, progress=stop_after(2))
    assert not out.exists()
    answerer.bundle.reader.heard.clear()
    result = answer_by(answerer, found, QUESTIONS, out)
    assert (result.continued, result.errors) == (4, 2)
    assert len(answerer.bundle.reader.heard) == 2  # only the third clip was asked about
    assert without_times(out) == without_times(whole)
    assert not out.with_name("answers.jsonl.part").exists()


def test_two_runs_do_not_write_the_same_rows_file(bundle, clips, tmp_path):
    out, found, answerer = tmp_path / "x.jsonl", clips_in(clips), feeling(bundle, "left")
    refused = []

    def meanwhile(done, total):
        with pytest.raises(UsageError) as error:
            answer_by(answerer, found, QUESTIONS, out)
        refused.append(str(error.value))

    answer_by(answerer, found, QUESTIONS, out, progress=meanwhile)
    assert set(refused) == {
        f"{out}.part: another run is writing it, expected one at a time; wait for it, or give "
        f"another --out."
    }
    assert len(rows_in(out)) == 6
    assert answer_by(answerer, found, QUESTIONS, out).continued == 0  # the claim is gone


def without_times(path):
    rows = rows_in(path)
    for row in rows:
        if row["answer"]:
            del row["answer"]["timing_ms"]
    return rows


def test_half_a_row_that_a_kill_left_is_written_again(bundle, clips, tmp_path):
    out, part = tmp_path / "answers.jsonl", tmp_path / "answers.jsonl.part"
    found, answerer = clips_in(clips), feeling(bundle, "left")
    with pytest.raises(Stopped):
        answer_by(answerer, found, QUESTIONS, out, progress=stop_after(2))
    text = part.read_bytes()
    part.write_bytes(text[: len(text) - 40])
    assert answer_by(answerer, found, QUESTIONS, out).continued == 2
    assert len(rows_in(out)) == 6


@pytest.mark.parametrize("change", ["questions", "clip", "model", "frame", "schema"])
def test_an_unfinished_run_of_something_else_is_not_continued(
    bundle, clips, tmp_path, monkeypatch, change
):
    out, answerer, questions = tmp_path / "x.jsonl", feeling(bundle, "left"), list(QUESTIONS)
    found, frame = clips_in(clips), FrameSpec()
    with pytest.raises(Stopped):
        answer_by(answerer, found, questions, out, progress=stop_after(1))
    if change == "questions":
        questions.append("Is it still?")
    elif change == "clip":
        np.save(clips / "a.npy", recording(frames=7).frames)
    elif change == "model":
        answerer = feeling(bundle, "left", temperature=2.0)
    elif change == "frame":
        frame = FrameSpec(mm_per_px=0.06)
    else:  # an older version, whose answers had other fields
        monkeypatch.setattr(batch, "answer_schema", dict)
    with pytest.raises(UsageError) as error:
        answer_by(answerer, found, questions, out, frame=frame)
    assert str(error.value) == (
        f"{out}.part: belongs to a run of other clips, questions or facts, or of another model or "
        f"version, expected this one's; delete it to begin anew, or give another --out."
    )


OTHERS = (
    "{}: belongs to a run of other clips, questions or facts, or of another model or version, "
    "expected this one's; delete it to begin anew, or give another --out."
)
DAMAGED = (
    "{}: its line 2 is damaged, expected one JSON object a line; delete the file to begin anew, or "
    "give another --out."
)


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (lambda lines: [b"hello\n"], OTHERS),
        (lambda lines: [b"\xff\xfe\n", *lines[1:]], OTHERS),
        (lambda lines: [b"[" * 100_000 + b"\n"], OTHERS),
        (lambda lines: [*lines[:2], b'{"clip": \n'], DAMAGED),
        (lambda lines: [*lines[:2], b"[1]\n"], DAMAGED),
    ],
    ids=["foreign", "no text", "deep", "half a row", "no row"],
)
def test_a_file_that_is_no_unfinished_run_is_refused_and_left(
    bundle, clips, tmp_path, damage, sentence
):
    out, part = tmp_path / "x.jsonl", tmp_path / "x.jsonl.part"
    answerer = feeling(bundle, "left")
    with pytest.raises(Stopped):
        answer_by(answerer, clips_in(clips), QUESTIONS, out, progress=stop_after(1))
    part.write_bytes(b"".join(damage(part.read_bytes().splitlines(keepends=True))))
    before = part.read_bytes()
    with pytest.raises(UsageError) as error:
        answer_by(answerer, clips_in(clips), QUESTIONS, out)
    assert str(error.value) == sentence.format(part)
    assert part.read_bytes() == before


def test_a_run_without_questions_is_refused(bundle, clips, tmp_path):
    with pytest.raises(ValueError, match="^a run takes 1 question or more, found none$"):
        answer_by(feeling(bundle, "left"), clips_in(clips), [], tmp_path / "x.jsonl")


def test_a_stopped_run_over_a_data_set_goes_on_behind_the_episodes_it_had_done(
    bundle, tmp_path, monkeypatch
):
    pytest.importorskip("pyarrow", reason="needs pyarrow, of the extra lerobot")
    pytest.importorskip("av", reason="needs av, of the extra lerobot")
    root = write_data_set(tmp_path / "robot", [turned(degrees) for degrees in (20, -15, 10)])
    episodes = list(every_episode(read_data_set(root), CAMERA))
    monkeypatch.setitem(globals(), "SENT_ANSWERER", [feeling(bundle, "left")])
    whole, out = tmp_path / "whole.jsonl", tmp_path / "answers.jsonl"
    answer_all(sent_answerer, episodes, QUESTIONS, whole)
    with pytest.raises(Stopped):
        answer_all(sent_answerer, episodes, QUESTIONS, out, progress=stop_after(2))
    result = answer_all(sent_answerer, episodes, QUESTIONS, out, workers=Sending())
    assert (result.rows, result.continued, result.errors) == (6, 4, 0)
    assert without_times(out) == without_times(whole)


def test_an_episode_that_was_recorded_anew_is_another(tmp_path):
    pytest.importorskip("pyarrow", reason="needs pyarrow, of the extra lerobot")
    pytest.importorskip("av", reason="needs av, of the extra lerobot")
    root = write_data_set(tmp_path / "robot", [turned(20), turned(10)])
    episode = next(every_episode(read_data_set(root), CAMERA))
    before = episode.stamp()
    assert episode.stamp() == before
    assert next(every_episode(read_data_set(root), CAMERA, fps=10.0)).stamp() != before
    path = root / f"videos/{CAMERA}/chunk-000/file-000.mp4"
    path.write_bytes(path.read_bytes() + b"more")
    assert episode.stamp() != before
