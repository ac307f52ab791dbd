"""Grading of two clips by hand-made truths; groups through a scripted model."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from geotlm_lm.answering import Comparison, Order
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.experiments import language_groups
from geotlm_lm.experiments.language_cases import Touched
from geotlm_lm.experiments.language_groups import ask_groups, compares, orders
from tests.answering.scripted import feeling, recording
from tests.tiny_bundle import tiny_bundle


def touch(motion, degrees=0.0, mm=0.0, encoded=None):
    label = MotionLabel(Motion(motion), rotation_deg=degrees, slide_x_mm=mm, mm_per_px=(0.09, 0.07))
    return Touched(encoded, label, True, motion, motion, None, {})


def compared(relation):
    return Comparison("", relation, 1.0, relation == "unknown", None, None)


@pytest.mark.parametrize(
    ("first", "second", "relation"),
    [
        ("left", "left", "same"),
        ("left", "right", "opposite"),
        ("clockwise", "counterclockwise", "opposite"),
        ("press", "release", "different"),
        ("left", "up", "different"),
        ("still", "still", "same"),
    ],
)
def test_directions_of_two_clips_relate_as_their_labels_do(first, second, relation):
    question, clips = "Do they go the same way?", (touch(first), touch(second))
    right = {
        one
        for one in ("same", "opposite", "different")
        if compares(question, compared(one), *clips)
    }
    assert right == {relation}


@pytest.mark.parametrize(
    ("degrees", "question", "allowed"),
    [
        ((10.0, 30.0), "Which went further?", {"second"}),
        ((10.0, 30.0), "Which one is slower?", {"first"}),
        ((20.0, 21.0), "Which went further?", {"similar"}),
        ((30.0, 22.5), "Which went further?", {"first", "similar"}),
    ],
)
def test_amounts_of_two_clips_relate_as_their_labels_do(degrees, question, allowed):
    clips = [touch("clockwise", degrees=value) for value in degrees]
    relations = ("first", "second", "similar", "unknown")
    assert {one for one in relations if compares(question, compared(one), *clips)} == allowed


def test_a_turn_and_a_slide_cannot_be_compared():
    clips = touch("clockwise", degrees=20.0), touch("left", mm=-1.0)
    assert compares("Which went further?", compared("unknown"), *clips)
    assert not compares("Which went further?", compared("first"), *clips)


def test_a_reply_that_compares_nothing_is_wrong():
    clips = touch("left"), touch("left")
    assert not compares("Do they go the same way?", SimpleNamespace(relation="same"), *clips)
    assert not orders("In which order?", SimpleNamespace(motions=(Motion.LEFT,) * 2), *clips)


def test_the_order_is_that_of_the_clips():
    clips = touch("left"), touch("up")
    told = Order("", (Motion.LEFT, Motion.UP), 1.0, False, ())
    assert orders("In which order?", told, *clips)
    assert not orders("In which order?", told, *clips[::-1])


@pytest.fixture(scope="module")
def groups():
    """What a model that feels "still" whatever it is shown makes of clips that are still."""
    answerer = feeling(tiny_bundle(), "still", temperature=0.1)
    touches = [touch("still", encoded=answerer.encode(recording(seed=seed))) for seed in range(2)]
    found = ask_groups(answerer, touches, 0, lambda done, total: None)
    return {name: [one for one in found if one.name == name] for name in {g.name for g in found}}


def test_every_sort_of_group_is_asked_about_every_clip(groups):
    assert {name: len(found) for name, found in groups.items()} == dict.fromkeys(groups, 2)
    assert len(groups) == 11


def test_a_model_that_feels_what_is_there_gets_whole_groups_right(groups):
    for name in (
        "open question, 4 unseen wordings",
        "clip, mirrored, backwards",
        "T1 after a stated fact",
        "T22 order",
    ):
        assert all(all(group.right) for group in groups[name]), name


def test_a_model_without_an_answer_to_a_claim_fails_the_pair(groups):
    assert not any(all(group.right) for group in groups["claim and its denial"])


def test_amounts_that_nobody_knows_are_not_asked_for(monkeypatch):
    """Of real recordings; a shouted question is one as well."""
    asked = SimpleNamespace(question="WHICH ONE TURNED FURTHER?")
    monkeypatch.setattr(language_groups, "questions_for", lambda *_, **__: [asked])
    answerer = feeling(tiny_bundle(), "left")
    clips = [replace(touch("left", encoded=answerer.encode(recording())), has_amounts=False)] * 2
    found = language_groups._two_clips(answerer, *clips, np.random.default_rng(0))
    assert [group.name for group in found] == ["T22 order"]


def test_a_doubt_does_not_turn_the_answer(groups):
    assert all(group.right == (True, True) for group in groups["kept under doubt"])


def test_groups_depend_on_the_seed_alone():
    answerer = feeling(tiny_bundle(), "left")
    touches = [touch("left", mm=-1.0, encoded=answerer.encode(recording()))]
    heard = []
    for _ in range(2):
        answerer.bundle.speaker.heard.clear()
        ask_groups(answerer, touches, 5, lambda done, total: None)
        heard.append(list(answerer.bundle.speaker.heard))
    assert heard[0] == heard[1]
    assert len(heard[0]) > 10
    assert np.unique(heard[0]).size > 5
