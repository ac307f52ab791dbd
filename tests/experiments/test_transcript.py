"""The file of fresh questions, and what is written down of the answers."""

import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.data.templates import load_templates
from geotlm_lm.experiments import transcript as experiment
from geotlm_lm.experiments.transcript import as_wanted, fresh_questions, transcript
from geotlm_lm.language.parse_answer import KINDS
from geotlm_lm.reports.transcript import transcript_page
from tests.answering.scripted import feeling
from tests.tiny_bundle import tiny_bundle

FILE = """
[[questions]]
clip = "cable_up"
ask = "Up?"
wants = { direction = "up" }

[[questions]]
clip = "cable_up"
ask = "Are you sure?"
after = ["Which way?"]
wants = { direction = "down", abstained = false }
note = "It never goes down."
"""


@pytest.fixture
def record(tmp_path, monkeypatch):
    path = tmp_path / "questions.toml"
    path.write_text(FILE)
    monkeypatch.setattr(experiment, "QUESTIONS", path)
    return transcript(feeling(tiny_bundle(), "up"), model_name="scripted")


def test_there_are_fifty_questions_and_none_is_asked_twice():
    questions = fresh_questions()
    assert len(questions) == 50
    assert len({one.ask.lower() for one in questions}) == 50


def test_what_is_wanted_can_be_had():
    for one in fresh_questions():
        assert one.wants.get("kind", "direction") in KINDS
        assert one.wants.get("direction", "up") in {motion.value for motion in Motion}


def test_no_question_is_a_wording_of_the_templates():
    wordings = {w.text.lower() for kind in load_templates().types.values() for w in kind.wordings}
    assert not wordings & {one.ask.lower() for one in fresh_questions()}


def test_a_question_that_wants_nothing_known_is_refused(tmp_path):
    path = tmp_path / "q.toml"
    path.write_text('[[questions]]\nclip = "x"\nask = "y"\nwants = { mood = "good" }\n')
    with pytest.raises(ValueError, match=r"'y' wants \{'mood': 'good'\}; known: \['abstained'"):
        fresh_questions(path)


def test_everything_wanted_must_be_found():
    told = {"direction": "up", "abstained": False}
    assert as_wanted(told, {"direction": "up"})
    assert not as_wanted(told, {"direction": "up", "kind": "verify"})
    assert not as_wanted(told, {"abstained": True})


def test_answers_are_counted_and_turns_before_are_kept(record):
    assert (record.numbers["questions"], record.numbers["as_wanted"]) == (2, 1)
    second = record.numbers["turns"][1]
    assert second["before"] == [["Which way?", "Up, in the camera image."]]
    assert second["answer"].endswith("Up, in the camera image.")


def test_the_page_explains_what_is_odd(record):
    page = transcript_page(record)
    assert "1 of 2 answers are as wanted." in page
    assert "## cable up" in page
    odd = "*Odd*: wanted direction down, abstained no, found direction up, abstained no. "
    assert f"{odd}It never goes down." in page
    assert page.count("*Odd*") == 1
