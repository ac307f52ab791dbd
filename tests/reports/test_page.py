"""The page's waiting times are told by their median and range, and wrong answers are not hidden."""

import pytest

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.page import page_times

NUMBERS = {
    "server_s": [9.5],
    "model_s": [11.25],
    "page_s": [1.0, 1.25, 4.0],
    "first_word_s": [0.1, 0.2, 0.3],
    "last_word_s": [0.4, 0.5, 0.6],
}


@pytest.mark.parametrize(("wrong", "told"), [(0, "20 of them"), (3, "17 of them")])
def test_the_median_the_range_and_the_right_answers_are_told(wrong, told):
    users = {"users": 20, "wrong": wrong, "all_s": 3.21, "median_s": 1.5}
    text = page_times(
        RunRecord("page", "geotlm-lm report page", 0, 60.0, NUMBERS | {"users": users})
    )
    assert "|   1.25 |     1.00-4.00 |" in text
    assert "|   9.50 |     9.50-9.50 |" in text
    assert "|  11.25 |   11.25-11.25 |" in text
    assert f"after 3.2 s (median of one 1.5 s); {told} were word for word" in text
    assert "`geotlm-lm report page`" in text
