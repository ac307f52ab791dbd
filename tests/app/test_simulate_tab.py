"""The sentence of the Simulate tab: what is said beside an answer is no direction."""

import pytest

from app.simulate_tab import sentence_of


@pytest.mark.parametrize(
    ("is_right", "told"),
    [
        (True, "Left, in the camera image.  (correct)"),
        (False, "Left, in the camera image.  (wrong: it was down)"),
    ],
)
def test_an_answer_is_judged_in_words_that_name_no_other_direction(is_right, told):
    true = "left" if is_right else "down"
    facts = {"answer": "Left, in the camera image.", "is_right": is_right, "true_motion": true}
    assert sentence_of(facts) == told
