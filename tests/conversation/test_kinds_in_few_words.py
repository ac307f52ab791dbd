"""Kinds of questions told by few words, as engineers and a chat put them."""

import pytest

from geotlm_lm.conversation.kinds import asked_kind, asks_direction, asks_whether_moving


@pytest.mark.parametrize(
    ("question", "kind"),
    [
        ("px/frame?", "magnitude"),
        ("deg per frame", "magnitude"),
        ("Report theta in radians.", "magnitude"),
        ("Express the rotation in turns", "magnitude"),
        ("angle deg", "magnitude"),
        ("is it up if flipped vertically?", "mirrored"),
        ("give me dx and dy", "magnitude"),
    ],
)
def test_kinds_in_the_words_of_engineers(question, kind):
    assert asked_kind(question) == kind


def test_a_drift_is_a_motion():
    assert asks_whether_moving("Did my part drift?")


def test_a_sense_of_rotation_is_a_direction():
    assert asks_direction("what is the sense of rotation?")
    assert asks_direction("rotation sign")


@pytest.mark.parametrize(
    ("question", "kind"),
    [
        ("What about the sensor?", "actor"),
        ("Tell me about the sensor", "actor"),
        ("I asked about the robot", "actor"),
        ("Did it turn about the gripper?", None),
        ("Is the object pivoting about the fingertip?", None),
        ("Heading?", None),
        ("heading angle?", "magnitude"),
        ("How come?", "evidence"),
        ("How accurate is that?", "confidence"),
        ("What is the uncertainty?", "confidence"),
        ("and why is that?", "evidence"),
        ("Explain your reasoning", "evidence"),
        ("On what basis?", "evidence"),
        ("Certain?", "confidence"),
        ("Really?", "confidence"),
        ("Is that correct?", "confidence"),
        ("Are you guessing?", "confidence"),
        ("Is it right?", None),
        ("Is that right or left?", None),
    ],
)
def test_few_words_tell_a_kind(question, kind):
    assert asked_kind(question) == kind
