"""The published schema against what is really answered, and against answers broken on purpose."""

import json

import pytest
from jsonschema import Draft202012Validator

from geotlm_lm import answer_schema
from geotlm_lm.answering import Answerer
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.query.types import ASKS
from tests.answering.scripted import feeling, recording

SCHEMA = answer_schema()
is_valid = Draft202012Validator(SCHEMA).is_valid


@pytest.fixture(scope="module")
def encoded(bundle):
    return Answerer(bundle).encode(recording(fps=25.0))


def as_json(answer):
    return json.loads(json.dumps(answer.to_dict()))


LINES = (
    "way", "kind", "claim cw", "choice A left , B right", "amount", "amount turn deg per-s",
    "when turn begin", "how-long turn", "how-often turn", "order", "why", "how-sure cw", "place",
    "alternatives", "compare same", "which-clip cw", "recording frames", "setup frame",
    "again", "help", "talk thanks", "unanswerable force", "not-understood", "fact mirrored",
    "undo > way", "way ; amount",
)  # fmt: skip


@pytest.mark.parametrize("line", LINES)
def test_answers_of_every_kind_follow_the_schema(bundle, encoded, line):
    assert is_valid(as_json(feeling(bundle, "clockwise").ask(encoded, line)))
    withheld = feeling(bundle, "left", contact_threshold=1.1)
    assert is_valid(as_json(withheld.ask(encoded, line)))


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
    assert set(SCHEMA["properties"]["kind"]["enum"]) == {*ASKS, "fact"}
    assert set(SCHEMA["$defs"]["frame"]["required"]) == set(FrameSpec().to_dict())
