import numpy as np
import pytest

from geotlm_lm.track.events import EventFinder, EventKind, Moment

FRAMES, RADIUS_PX = 60, 50.0


def kinds(turn_deg, right_px, frames=20):
    """Kinds of the events of a contact that turns and slides evenly in its middle."""
    finder, found = EventFinder(), []
    for k in range(FRAMES):
        done = min(max(k - 20, 0) / frames, 1.0)
        way = done * np.array([turn_deg, right_px, 0.0, 0.0])
        doubt = k * 1e-3 * np.eye(4)
        found += finder.push(Moment(k, k, k / 25, 1.0, True, way, doubt, RADIUS_PX))
    return {event.kind for event in found + finder.finish()}


@pytest.mark.parametrize(
    ("turn_deg", "right_px", "frames", "is_told"),
    [
        (4.0, 0.0, 20, True),
        (4.0, 20.0, 20, False),  # as a path a sixth of the slide: it may be read of that
        (20.0, 20.0, 20, True),
        (4.0, 0.0, 1, False),  # one step may be measured wrong
        (8.0, 0.0, 1, True),
    ],
)
def test_a_turn_is_told_if_neither_a_slide_nor_one_wrong_step_explains_it(
    turn_deg, right_px, frames, is_told
):
    assert (EventKind.TURN in kinds(turn_deg, right_px, frames)) == is_told
