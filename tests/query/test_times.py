"""What happens when, how long and how often is that of which all is so that the question says."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.core.edit import Edit
from geotlm_lm.query.intervals import outside, within_all, within_any
from geotlm_lm.query.paths import played
from geotlm_lm.query.tell import tell
from tests.query.test_execute import RECORDING, answer, certain, whole


@pytest.mark.parametrize(
    ("text", "question", "times"),
    [
        ("how-often turn > #1", "50 degrees", (0.0,)),
        ("how-often ccw > #1", "15 degrees", (0.0,)),
        ("how-often turn > #1", "15 degrees per second", (1.0,)),
        ("how-long move > #1", "15 degrees", (1.0,)),
        ("when turn > #1 begin", "50 degrees", ()),
        ("when turn < #1 begin", "25 degrees", (1.0,)),
        ("when turn > #1 begin", "10 degrees per second", (1.0,)),
        ("when turn > #1 begin", "10 degrees", (1.52,)),
        ("backwards > when turn > #1 begin", "10 degrees", (2.52,)),
        ("backwards > when cw > #1 begin", "10 degrees", ()),
    ],
)
def test_a_bound_is_kept_in_times(text, question, times):
    found = answer(text, certain(), question=question, track=whole())
    assert found.times == pytest.approx(times, abs=0.05)


def test_what_never_goes_so_far_is_not_said_never_to_move():
    far = answer("when turn > #1 begin", certain(), question="50 degrees", track=whole())
    assert tell(far, RECORDING) == "That does not happen in this recording."


def test_played_twice_backwards_is_as_recorded():
    track = whole()
    back = played(track, Edit(backwards=True))
    assert back.path_from_start[-1] == pytest.approx(track.path_from_start[-1])
    assert played(back, Edit(backwards=True)).twists == pytest.approx(track.twists)
    assert played(back, Edit(backwards=True)).times_s == pytest.approx(track.times_s)


@pytest.mark.parametrize(
    ("text", "times", "told"),
    [
        ("how-long not touch", (1.04,), "For 1.04 s: it lifts off at 3.0 s."),
        ("how-long touch and not move", (1.0,), "For 1.0 s."),
        ("how-often not touch", (1.0,), "1 time: it lifts off at 3.0 s."),
        ("when not touch begin", (3.0,), "At 3.0 s: it lifts off at 3.0 s."),
        ("when not move begin", (0.0, 1.0), "From 0.0 s to 1.0 s."),
        ("backwards > when not move begin", (0.0, 1.0), "From 0.0 s to 1.0 s."),
    ],
)
def test_a_denial_is_told_of_the_other_times(text, times, told):
    found = answer(text, certain(), track=whole())
    assert found.times == pytest.approx(times, abs=1e-6)
    assert tell(found, RECORDING) == told


@pytest.mark.parametrize("atom", ["touch", "move", "turn", "left", "still", "none"])
def test_what_is_so_and_what_is_not_last_as_long_as_all(atom):
    so, denied = (
        answer(f"how-long {said}", certain(), track=whole()).times[0]
        for said in (atom, f"not {atom}")
    )
    assert so + denied == pytest.approx(whole().seconds)


_spans = st.lists(st.tuples(st.integers(0, 9), st.integers(1, 5)), max_size=4).map(
    lambda found: [(at, at + far) for at, far in found]
)


@given(_spans, _spans)
def test_what_lies_outside_either_lies_outside_both(one, other):
    whole = (0, 10)
    apart = within_all([outside(one, whole), outside(other, whole)])
    assert apart == outside(within_any([one, other]), whole)


@given(st.floats(0.51, 1.0), st.sampled_from(["starts", "stops", "lost", "made", "reverses"]))
@settings(max_examples=20, deadline=None)
def test_what_happens_is_as_sure_as_its_events(sure, atom):
    events = tuple(replace(one, probability=sure) for one in whole().events)
    track = replace(whole(), events=events)
    found, denied = (
        answer(f"claim {said}", certain(turn=20), track=track) for said in (atom, f"not {atom}")
    )
    assert (found.probability, denied.probability) == pytest.approx((sure, sure))
    assert found.verdict is (atom != "reverses")
    both = answer(f"how-sure {atom} and starts", certain(turn=20), track=track)
    assert both.chances[0] == pytest.approx(sure if atom != "reverses" else 1 - sure)
