"""Rows for every clip and question, whatever happens on the way; runs themselves: tests/runs."""

import json
import os
import pickle
import signal
from dataclasses import replace

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from geotlm_lm import answer_schema
from geotlm_lm.answering import Answerer, batch
from geotlm_lm.answering.batch import answer_all
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.data_sets.lerobot import every_episode, read_data_set
from geotlm_lm.recordings import read
from geotlm_lm.recordings.read import StoredRecording
from geotlm_lm.runs.run import LOST, Workers
from tests.answering.scripted import feeling, recording
from tests.data_sets.lerobot_files import CAMERA, turned, write_data_set
from tests.tiny_bundle import tiny_bundle

QUESTIONS = ["Which way?", "backwards way all"]


@pytest.fixture
def clips(tmp_path):
    """Three recordings, the second of which is damaged, and a file that is none."""
    folder = tmp_path / "clips"
    folder.mkdir()
    for name in ("a", "c"):
        np.save(folder / f"{name}.npy", recording().frames)
    (folder / "b.npy").write_bytes(b"no array")
    (folder / "readme.txt").write_text("not a clip")
    return folder


def clips_in(folder):
    return list(map(StoredRecording, read.clips_in(folder)))


def answer_by(answerer, *args, **options):
    return answer_all(lambda: answerer, *args, **options)


SENT_ANSWERER = []


def sent_answerer():
    return SENT_ANSWERER[0]


class Sending:
    """Works here with what other processes would be sent."""

    def map(self, work, parts, **_):
        work = pickle.loads(pickle.dumps(work))
        return ((part, work(part)) for part in pickle.loads(pickle.dumps(parts)))


def rows_in(path):
    """Return the rows without the times in them."""
    rows = [json.loads(line) for line in path.read_text().splitlines()]
    for row in rows:
        if row["answer"]:
            del row["answer"]["timing_ms"]
    return rows


class Stopped(BaseException):
    """A run ended from outside, as by Ctrl-C."""


def stop_after(count):
    def progress(what, done, total):
        if done == count:
            raise Stopped

    return progress


def test_every_clip_and_question_gets_a_row_in_order(bundle, clips, tmp_path, monkeypatch):
    encoded, encode = [], Answerer.encode
    monkeypatch.setattr(
        Answerer, "encode", lambda self, clip, span: encoded.append(clip.name) or encode(self, clip)
    )
    out = tmp_path / "a folder to be made" / "answers.jsonl"
    result = answer_by(feeling(bundle, "left"), clips_in(clips), [*QUESTIONS, "  "], out)
    schema = answer_schema()
    validator = Draft202012Validator(schema)
    for line in out.read_text().splitlines():
        assert list(validator.descend(json.loads(line), schema["$defs"]["batch_row"])) == []
    rows = rows_in(out)
    assert [(row["clip"], row["question"]) for row in rows] == [
        (clip, question) for clip in ("a.npy", "b.npy", "c.npy") for question in [*QUESTIONS, "  "]
    ]
    assert (result.rows, result.errors, result.continued) == (9, 5, 0)
    assert [row["answer"]["direction"] for row in rows if row["answer"]] == ["left", "right"] * 2
    assert rows[2]["error"].startswith("The question is empty")
    assert [row["answer"] for row in rows[3:6]] == [None] * 3
    assert len({row["error"] for row in rows[3:6]}) == 1
    assert rows[3]["error"].startswith(str(clips / "b.npy"))
    assert len(encoded) == 2  # once a clip, whatever the number of questions
    with pytest.raises(ValueError, match="^a run takes 1 question or more, found none$"):
        answer_by(feeling(bundle, "left"), clips_in(clips), [], out)


class Deadly(StoredRecording):
    """A recording whose decoder ends the process."""

    def read(self):
        os.kill(os.getpid(), signal.SIGKILL)


def tiny_answerer():
    return feeling(tiny_bundle(), "left")


@pytest.mark.slow
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
    assert rows_in(out) == rows_in(whole)
    assert not out.with_name("answers.jsonl.part").exists()


@pytest.mark.parametrize("change", ["questions", "clip", "model", "frame", "schema", "old"])
def test_an_unfinished_run_of_something_else_is_not_continued(
    bundle, clips, tmp_path, monkeypatch, change
):
    out, answerer, questions = tmp_path / "x.jsonl", feeling(bundle, "left"), list(QUESTIONS)
    found, frame, part = clips_in(clips), FrameSpec(), tmp_path / "x.jsonl.part"
    if change == "old":  # one file, as earlier versions kept it
        part.write_text('{"format": 3, "model": "m", "asked": "a"}\n{"clip": 0, "rows": []}\n')
    else:
        with pytest.raises(Stopped):
            answer_by(answerer, found, questions, out, progress=stop_after(1))
    if change == "questions":
        questions.append("Is it still?")
    elif change == "clip":
        np.save(clips / "a.npy", recording(frames=7).frames)
    elif change == "model":
        answerer = feeling(bundle, "left", felt_temperature=2.0)
    elif change == "frame":
        frame = FrameSpec(mm_per_px=0.06)
    elif change == "schema":  # an older version, whose answers had other fields
        monkeypatch.setattr(batch, "answer_schema", dict)
    with pytest.raises(UsageError) as error:
        answer_by(answerer, found, questions, out, frame=frame)
    assert str(error.value) == (
        f"{part}: belongs to a run of other clips, questions or facts, or of another model or "
        f"version, expected this one's; delete it to begin anew, or give another --out."
    )


@pytest.fixture
def episodes(tmp_path):
    pytest.importorskip("pyarrow", reason="needs pyarrow, of the extra lerobot")
    pytest.importorskip("av", reason="needs av, of the extra lerobot")
    root = write_data_set(tmp_path / "robot", [turned(degrees) for degrees in (20, -15, 10)])
    return list(every_episode(read_data_set(root), CAMERA))


def test_a_stopped_run_over_a_data_set_goes_on_behind_the_episodes_it_had_done(
    bundle, tmp_path, monkeypatch, episodes
):
    monkeypatch.setitem(globals(), "SENT_ANSWERER", [feeling(bundle, "left")])
    whole, out = tmp_path / "whole.jsonl", tmp_path / "answers.jsonl"
    answer_all(sent_answerer, episodes, QUESTIONS, whole)
    with pytest.raises(Stopped):
        answer_all(sent_answerer, episodes, QUESTIONS, out, progress=stop_after(2))
    result = answer_all(sent_answerer, episodes, QUESTIONS, out, workers=Sending())
    assert (result.rows, result.continued, result.errors) == (6, 4, 0)
    assert rows_in(out) == rows_in(whole)


def test_an_episode_that_was_recorded_anew_is_another(episodes):
    episode, before = episodes[0], episodes[0].stamp()
    assert episode.stamp() == before
    assert replace(episode, fps=10.0).stamp() != before
    path = episode.data_set.video_of(episode.episode, CAMERA)
    path.write_bytes(path.read_bytes() + b"more")
    assert episode.stamp() != before
