"""Kinds of motion claimed without a direction, and words that may be mistyped ones."""

import pytest

from geotlm_lm.conversation.claims import (
    claimed_class,
    claims_motion,
    motions_named,
    nearly_named,
)
from geotlm_lm.core.labels import Motion, MotionClass, MotionLabel
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize(
    ("question", "claimed"),
    [
        ("Is it rotating?", MotionClass.ROTATION),
        ("hey, did the cap twist", MotionClass.ROTATION),
        ("Is the cable slipping through my fingers?", MotionClass.SLIDE),
        ("If I looked at it, would it be spinning?", MotionClass.ROTATION),
        ("isn't it dragged along?", MotionClass.SLIDE),
        ("rotation sense pls", None),
        ("Which way is it turning?", None),
        ("Is it turning clockwise?", None),
        ("Is it turning or sliding?", None),
        ("Can you tell how it turns?", None),
        ("Is it moving?", None),
    ],
)
def test_a_yes_or_no_question_may_claim_a_kind_of_motion(question, claimed):
    assert claimed_class(question) == claimed


@pytest.mark.parametrize("word", ["clokwise", "lefft", "presing", "cuonterclockwise"])
def test_a_mistyped_motion_is_nearly_named(word):
    assert nearly_named(f"is it going {word}?")


@pytest.mark.parametrize("text", ["what is that light?", "is it slipping?", "shifting sands", ""])
def test_other_words_are_no_mistyped_motions(text):
    assert not nearly_named(text)


def test_upside_down_names_no_motion_and_resting_is_still():
    assert motions_named("if the picture is upside down?") == set()
    assert motions_named("is the coin just resting there?") == {Motion.STILL}


@pytest.mark.parametrize(
    ("question", "claims"),
    [
        ("Is the cable slipping through my fingers?", True),
        ("Does it travel towards the upper edge of the picture?", True),
        ("is it pulled to the bottom end", True),
        ("Did it turn anticlockwise?", True),
        ("Is it just resting there?", True),
        ("Is it the right size?", False),
        ("Is that right?", False),
        ("Is the upper edge sharp?", False),
        ("Will it turn later?", False),
        ("Did it slide before?", False),
        ("Who turned it clockwise?", False),
        ("Is it turning or sliding?", False),
        ("Is it red?", False),
        ("left?", False),
    ],
)
def test_a_claim_of_motion_is_told_from_other_questions(question, claims):
    assert claims_motion(question) is claims


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_question_that_touch_cannot_answer_passes_for_a_claim(wordings):
    label = MotionLabel(Motion.CLOCKWISE, rotation_deg=12.0)
    asked = [
        questions_for(label, generator_for(seed, "claims"), types=["T17"], wordings=wordings)[0]
        for seed in range(1500)
    ]
    assert [one.question for one in asked if claims_motion(one.question)] == []
