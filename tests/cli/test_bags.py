"""A bag goes through every command as the same frames in an array do."""

import json

import pytest

from tests.cli.running import run
from tests.recordings.bag_files import TOPIC, even_ns, raw, write_bag
from tests.track.recordings import there_and_back


@pytest.fixture(scope="module")
def clip():
    return there_and_back().select(range(0, 70))


@pytest.fixture
def bag(tmp_path, clip):
    each = list(zip(clip.frames, even_ns(len(clip)), strict=True))
    topics = {TOPIC: [raw(*one) for one in each], "/wrist": [raw(*one) for one in each[:3]]}
    return write_bag(tmp_path / "run", topics)


def told(capsys, *words):
    code, out, errors = run(capsys, *words)
    assert code == 0, errors
    return json.loads(out.splitlines()[-1])


def test_it_is_answered_about_described_tracked_and_watched(capsys, answerer, bag):
    asked = ("--q", "Which way is it turning?")
    assert "clockwise" in run(capsys, "answer", bag, "--topic", TOPIC, *asked)[1]
    assert told(capsys, "info", bag, "--topic", TOPIC, "--json")["frames"] == 70
    assert told(capsys, "track", bag, "--topic", TOPIC, "--json")["totals"]["frames"] == 70
    account = told(capsys, "watch", bag, "--topic", TOPIC, "--json")
    assert account["frames"] == 70
    facts = told(capsys, "doctor", bag, "--topic", TOPIC, "--json")
    assert "dropped frames" not in facts["faults"]


@pytest.mark.slow
def test_a_folder_of_them_is_answered_in_a_batch(capsys, answerer, tmp_path, bag):
    questions, out = tmp_path / "questions.txt", tmp_path / "rows.jsonl"
    questions.write_text("Which way is it turning?\n")
    words = (tmp_path, "--questions", questions, "--out", out, "--topic", TOPIC)
    code, _, errors = run(capsys, "batch", *words)
    assert code == 0, errors
    [row] = map(json.loads, out.read_text().splitlines())
    assert (row["clip"], row["error"]) == ("run", None)
