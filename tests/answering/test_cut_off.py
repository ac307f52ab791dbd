"""An imprint that the border of the image cuts through is told with less certainty."""

from dataclasses import replace

import pytest

from geotlm_lm.answering.encoded import CUT_OFF_DOUBT
from tests.answering.scripted import feeling, recording

QUESTION = "Which way is it moving?"


def test_the_odds_between_answers_shrink_by_the_stated_power(bundle):
    answerer = feeling(bundle, "press")
    whole = answerer.encode(recording())
    assert not whole.is_cut_off
    sure, unsure = (
        answerer.score(one, QUESTION) for one in (whole, replace(whole, is_cut_off=True))
    )
    likely, *_, unlikely = sorted(sure, key=sure.get, reverse=True)
    odds = sure[likely] / sure[unlikely]
    assert odds > 1
    assert unsure[likely] / unsure[unlikely] == pytest.approx(odds ** (1 / CUT_OFF_DOUBT))
    assert sum(unsure.values()) == pytest.approx(1)


def test_it_is_said_that_the_imprint_is_cut_off(bundle):
    answerer = feeling(bundle, "press")
    clip = recording()
    columns = clip.frames.shape[2]
    frames = clip.frames.copy()
    frames[:] = clip.frames[0]
    frames[1:, :, : columns // 12] //= 2
    note = "The border of the image cuts the imprint off: answers are less sure."
    assert note in answerer.ask(answerer.encode(replace(clip, frames=frames)), QUESTION).notes
    assert note not in answerer.ask(answerer.encode(clip), QUESTION).notes
