"""What happens when, how long and how often is that of which all is so that the question says."""

import pytest

from geotlm_lm.query.edit import Edit
from geotlm_lm.query.paths import played
from geotlm_lm.query.tell import tell
from tests.query.test_execute import RECORDING, answer, certain, whole


@pytest.mark.parametrize(
    ("text", "question", "times"),
    [
        ("how-often turn > #1", "50 degrees", (0.0,)),
        ("how-often turn > #1", "15 degrees", (1.0,)),
        ("how-often ccw > #1", "15 degrees", (0.0,)),
        ("how-often turn > #1", "15 degrees per second", (1.0,)),
        ("how-often turn > #1", "25 degrees per second", (0.0,)),
        ("how-long move > #1", "15 degrees", (1.0,)),
        ("when turn > #1 begin", "50 degrees", ()),
        ("when turn < #1 begin", "5 degrees", ()),
        ("when turn < #1 begin", "25 degrees", (1.0,)),
        ("when turn > #1 begin", "10 degrees per second", (1.0,)),
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
