"""What a few words ask is what was asked before."""

import pytest

from geotlm_lm.conversation.follow_ups import asks_again_now, of_another
from geotlm_lm.conversation.kinds import asked_kind

WAY = "Which way does the cap turn?"


@pytest.mark.parametrize(
    ("question", "before", "asked"),
    [
        ("And the object?", WAY, "Which way does the object move?"),
        ("and the sensor?", WAY, "Which way does the sensor move?"),
        ("No, I meant the sensor", WAY, "Which way does the sensor move?"),
        ("what about the object itself?", "How far does the sensor go?", "How far does the object"),
        ("and the object?", "how fast did the sensor go", "How fast does the object move?"),
        ("And the object?", None, "Which way does the object move?"),
    ],
)
def test_another_one_is_asked_the_same(question, before, asked):
    assert of_another(question, before).startswith(asked)


@pytest.mark.parametrize("question", ["and how far?", "the object?", "and the object turns?", "No"])
def test_other_questions_stay_as_they_are(question):
    assert of_another(question, WAY) == question


def test_now_asks_it_again():
    assert asks_again_now("And now?")
    assert asks_again_now("so?")
    assert not asks_again_now("and now which way?")


@pytest.mark.parametrize("who", ["my gripper", "my sensor", "my robot hand", "my finger"])
def test_what_holds_the_sensor_is_asked_its_way(who):
    asked = of_another(f"and {who}?", "How far?")
    assert asked == f"Which way does {who} move?"
    assert asked_kind(asked) == "actor"
