"""Questions about certainty, with a motion and without."""

import pytest

from geotlm_lm.conversation.doubts import doubted
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion


@pytest.mark.parametrize(
    ("question", "motions"),
    [
        ("Is it likely that it turns clockwise?", {Motion.CLOCKWISE}),
        ("What is the probability that it slips?", set(SLIDES)),
        ("How sure are you that the cap rotates?", set(ROTATIONS)),
        ("How certain is a slide to the left?", {Motion.LEFT}),
        ("Are you sure?", None),
        ("How sure are you of the right cap?", None),
        ("Are you sure that it does not slip?", None),
        ("Would you bet on that?", None),
    ],
)
def test_the_motion_whose_probability_is_asked_for(question, motions):
    assert doubted(question) == motions


@pytest.mark.parametrize(
    "question",
    [
        "What is the chance that it is right?",
        "How likely is it that you are right?",
        "What is the likelihood that the answer is correct?",
    ],
)
def test_whether_the_answer_is_right_is_no_motion_to_the_right(question):
    assert doubted(question) is None
