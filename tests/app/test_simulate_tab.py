"""The sentence of the Simulate tab: what is said beside an answer is no direction."""

import pytest

from app.simulate_tab import sentence_of


@pytest.mark.parametrize(
    ("is_right", "ways", "told"),
    [
        (True, ["left"], "Left, in the camera image.  (correct: it was left)"),
        (
            True,
            ["clockwise", "left"],
            "Left, in the camera image.  (correct: it was clockwise and left)",
        ),
        (False, [], "Left, in the camera image.  (wrong: it was still)"),
    ],
)
def test_an_answer_is_judged_by_all_that_the_touch_did(is_right, ways, told):
    facts = {"answer": "Left, in the camera image.", "is_right": is_right}
    assert sentence_of(facts | {"true_ways": ways, "true_motion": "still"}) == told
