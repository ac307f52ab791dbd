"""A speed is how far it goes in the time, and the frames, in which that itself moves."""

from dataclasses import replace

import pytest

from geotlm_lm.query import types as t
from geotlm_lm.query.decision import Evidence
from geotlm_lm.query.execute import execute
from geotlm_lm.query.quantities import quantities
from geotlm_lm.query.text import read
from tests.query.test_execute import FRAME, RECORDING, certain, whole

FOLLOWED = replace(RECORDING, step_s=0.04)


def decided(text, *, question="", recording=FOLLOWED):
    query = t.filled(read(text), quantities(question))
    evidence = Evidence(certain(turn=20, right=-30), recording=recording, track=whole())
    return execute(query, evidence, FRAME)[0]


@pytest.mark.parametrize(
    ("text", "speed", "unit"),
    [
        ("amount turn per-s", 20.0, "deg/s"),
        ("in-first-half > amount turn per-s", 20.0, "deg/s"),
        ("amount turn per-frame", 0.8, "deg/frame"),
        ("amount slide per-s", 30 * 320 / 224, "px/s"),
    ],
)
def test_a_speed_is_of_the_time_in_which_it_moves(text, speed, unit):
    amount = decided(text).amounts[0]
    assert (amount.mean, amount.unit) == (pytest.approx(speed, rel=0.05), unit)


def test_a_speed_that_is_said_is_of_that_time():
    assert decided("claim turn > #1", question="15 degrees per second").verdict is True
    assert decided("claim turn > #1", question="25 degrees per second").verdict is False
