"""A turn of the image is read in its sense, as turning a drawn point shows it."""

import numpy as np
import pytest

from geotlm_lm.conversation.frame_facts import read_facts
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion

WAYS = {Motion.LEFT: (0, -1), Motion.RIGHT: (0, 1), Motion.UP: (-1, 0), Motion.DOWN: (1, 0)}
"""Steps of (row, column)."""


@pytest.mark.parametrize(("sense", "turns"), [("clockwise", -1), ("counterclockwise", 1)])
@pytest.mark.parametrize("motion", WAYS)
def test_an_image_turned_as_is_said_is_told_as_before_it_was_turned(sense, turns, motion):
    before = np.zeros((5, 5))
    before[2, 2] = 1
    after = np.roll(before, WAYS[motion], (0, 1))
    # rot90 turns an image counterclockwise.
    recorded = [np.argwhere(np.rot90(one, turns))[0] for one in (before, after)]
    step = tuple(recorded[1] - recorded[0])
    seen = next(way for way, steps in WAYS.items() if steps == step)
    stated = read_facts(f"The image is rotated by 90 degrees {sense}.", FrameSpec())
    assert stated.frame.tell(seen) is motion
