"""A speed is how far it goes in the time, and the frames, in which that itself moves."""

from dataclasses import replace

import pytest

from geotlm_lm.query import types as t
from geotlm_lm.query.decision import Evidence
from geotlm_lm.query.execute import execute
from geotlm_lm.query.forms import in_form
from geotlm_lm.query.quantities import quantities
from geotlm_lm.query.tell import tell
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


@pytest.mark.parametrize(
    ("text", "peak", "unit", "at_s"),
    [
        ("amount turn per-s peak", 20.0, "deg/s", None),
        ("amount turn per-frame peak", 0.8, "deg/frame", None),
        ("amount turn peak", 20.0, "deg", 2.0),
        ("backwards > amount turn peak", 20.0, "deg", 3.0),
        ("amount left peak", 30 * 320 / 224, "px", 3.0),
    ],
)
def test_a_peak_is_told_in_its_unit_where_it_is(text, peak, unit, at_s):
    found = decided(text)
    amount = found.amounts[0]
    assert (amount.mean, amount.unit) == (pytest.approx(peak, rel=0.01), unit)
    begin, end = found.movements[0].times
    assert begin - 0.05 <= found.times[0] <= end + 0.05
    assert at_s is None or found.times[0] == pytest.approx(at_s, abs=0.05)


def test_what_never_goes_a_way_has_no_peak_there():
    assert tell(decided("amount right peak"), FOLLOWED).startswith("It slides left")


def test_no_seconds_are_made_up_without_a_rate():
    unknown = replace(FOLLOWED, rate_hz=None)
    assert decided("amount turn per-s peak", recording=unknown).missing == "rate"
    when, long = (decided(one, recording=unknown) for one in ("when turn begin", "how-long turn"))
    assert in_form([when], "number", unknown) == in_form([long], "number", unknown) == "25"
    assert '"at_frame": 25' in in_form([when], "json", unknown)
    story = in_form([decided("order", recording=unknown)], "json", unknown)
    assert '"begin_frame": 25' in story
    assert '_s"' not in story
