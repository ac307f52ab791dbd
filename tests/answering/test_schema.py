"""The published schema against what is really answered, and against answers broken on purpose."""

import json

import pytest
from jsonschema import Draft202012Validator

from geotlm_lm import answer_schema
from geotlm_lm.answering import Answerer
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.query.program import _ANSWERS
from tests.answering.scripted import feeling, recording

SCHEMA = answer_schema()
is_valid = Draft202012Validator(SCHEMA).is_valid


@pytest.fixture(scope="module")
def encoded(bundle):
    return Answerer(bundle).encode(recording(fps=25.0))


def as_json(answer):
    return json.loads(json.dumps(answer.to_dict()))


LINES = (
    "way all", "kind", "cw", "choose A left | B right", "amount turn", "speed turn", "extent",
    "unit thou amount slide", "count turn-events", "begin first turn-events", "first turn-events",
    "share cw", "area", "time-while turn", "story", "why", "sure", "sure-of cw", "place",
    "alternatives", "same way all", "which-clip cw", "file frames", "setup frame", "again", "help",
    "talk thanks", "cannot force", "not-understood", "fact mirrored", "undo way all",
    "way all ; extent", "record turn , amount turn end ; as json", "each turn-events way turn",
)  # fmt: skip


@pytest.mark.parametrize("line", LINES)
def test_answers_of_every_kind_follow_the_schema(bundle, encoded, line):
    assert is_valid(as_json(feeling(bundle, "clockwise").ask(encoded, line)))
    withheld = feeling(bundle, "left", contact_threshold=1.1)
    assert is_valid(as_json(withheld.ask(encoded, line)))
    followed = withheld.encode(recording(6, fps=25.0))
    assert is_valid(as_json(withheld.ask(followed, line)))


@pytest.mark.parametrize(
    "broken",
    [
        {"direction": "leftish"},
        {"confidence": 1.5},
        {"frames_used": [0, 1]},
        {"options": {"left": -0.1}},
        {"surplus": 1},
        {"motion": {"turn": 3}},
    ],
)
def test_a_broken_answer_is_refused(bundle, encoded, broken):
    answer = as_json(feeling(bundle, "left").ask(encoded, "Which way?"))
    assert not is_valid(answer | broken)


def test_the_schema_names_every_motion_kind_and_fact():
    assert SCHEMA["$defs"]["motion"]["enum"] == [motion.value for motion in Motion]
    assert set(SCHEMA["properties"]["kind"]["enum"]) == {*_ANSWERS, "fact"}
    assert set(SCHEMA["$defs"]["frame"]["required"]) == set(FrameSpec().to_dict())
