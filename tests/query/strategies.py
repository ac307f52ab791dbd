"""Random edits, beliefs and recordings, for the laws."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from geotlm_lm.core.edit import EDIT_WORDS, Edit
from geotlm_lm.core.twist import COMPONENTS, WAYS, Twist
from geotlm_lm.motion.belief import Belief
from geotlm_lm.track.track import Track
from tests.track.tracks import happened, moving_track

edits = st.lists(st.sampled_from(EDIT_WORDS), max_size=5).map(lambda words: Edit.of(*words))


@st.composite
def beliefs(draw) -> Belief:
    values = [draw(st.floats(-30, 30)) for _ in range(3)] + [draw(st.floats(-2, 2))]
    spread = np.diag([draw(st.floats(0.01, 9)) for _ in range(4)])
    contact = draw(st.floats(0, 1))
    ways = {}
    for component in COMPONENTS:
        counts = draw(st.floats(0, 1)) * contact
        shares = np.array([draw(st.floats(0.01, 1)) for _ in WAYS[component]])
        ways |= dict(zip(WAYS[component], (counts * shares / shares.sum()).tolist(), strict=True))
    readable = dict.fromkeys(COMPONENTS, True)
    return Belief(Twist(*values), spread, ways, contact, 30.0, readable)


def turning(turns: list[float], sure: float = 0.99) -> Track:
    """A recording at 25 Hz that is held for a second, turned by each angle in a second, let go."""
    frames = 25 * (len(turns) + 2) + 1
    twists, contact = np.zeros((frames, 4)), np.full(frames, sure)
    contact[-25:] = 1 - sure
    events = [happened("touch", 0, 0, sure=sure), happened("stick", 0, 25, sure=sure)]
    for place, turn in enumerate(turns):
        begin = 25 * (place + 1)
        twists[begin + 1 : begin + 26, 0] = turn / 25
        events.append(happened("turn", begin, begin + 25, turn=turn, sure=sure))
    last = frames - 26
    events.append(happened("release", last, last, inward=-0.3, sure=sure))
    return moving_track(twists, events, contact=contact, frame_size=(240, 320))


tracks = st.builds(
    turning,
    st.lists(st.sampled_from([-40.0, -15.0, 15.0, 40.0]), max_size=6),
    st.floats(0.51, 0.999),
)
