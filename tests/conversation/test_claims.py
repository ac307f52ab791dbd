"""Kinds of motion claimed without a direction, and words that may be mistyped ones."""

import pytest

from geotlm_lm.conversation.claims import claimed_class, motions_named, nearly_named
from geotlm_lm.core.labels import Motion, MotionClass


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
