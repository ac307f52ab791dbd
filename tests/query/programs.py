"""Random well-typed programs and the evidence that they are evaluated on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.twist import COMPONENTS, WAYS, Twist
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query import program as p
from geotlm_lm.query.amounts import Recording
from geotlm_lm.query.decision import ContactArea
from geotlm_lm.query.evaluate import Context, Evidence
from geotlm_lm.query.program import Case, Expression, Field, of
from geotlm_lm.query.quantities import Quantity
from geotlm_lm.query.worlds import worlds_of_clip, worlds_of_track
from geotlm_lm.track.summed import belief_of_track
from tests.query.strategies import beliefs, tracks, turning

RECORDING = Recording(columns=320, rows=240, rate_hz=25.0, frames=100, used=(10, 15, 20, 25))
AREA = ContactArea(0.4, 0.7, 0.1)

_QUANTITIES = (
    *(Quantity(value, "deg") for value in (5.0, 20.0, 80.0)),
    *(Quantity(value, "px") for value in (3.0, 30.0)),
    *(Quantity(0.5, unit) for unit in ("mm", "s", "deg/s")),
    *(Quantity(value, "frame") for value in (10.0, 40.0)),
    *(Quantity(value) for value in (1.0, 2.0)),
    Quantity(25.0, "percent"),
)


def expressions(wanted: str = "answer", depth: int = 4) -> st.SearchStrategy[Expression]:
    """Draw expressions of a type, no deeper than `depth`."""
    accepted = p.ACCEPTED[wanted]
    if wanted in p._NAMES:  # the names themselves
        return st.sampled_from(sorted(accepted))
    words = [word for word in accepted if word != "again"]
    leaves = [word for word in words if all(each in p._NAMES for each in accepted[word])]
    chosen = leaves if depth <= 0 and leaves else words
    plain = st.sampled_from(sorted(chosen)).flatmap(lambda word: _with(word, accepted, depth))
    if wanted != "number":
        return plain
    return st.one_of(plain, st.sampled_from(_QUANTITIES).map(p.number))


def _with(word: str, accepted, depth: int) -> st.SearchStrategy[Expression]:
    drawn = [_argument(takes, depth - 1) for takes in accepted[word]]
    return st.tuples(*drawn).map(lambda arguments: of(word, *arguments))


def _argument(wanted: str, depth: int):
    if wanted == "cases":
        cases = st.builds(
            Case, expressions("bool", min(depth, 1)), st.sampled_from(["A", "B", None])
        )
        return st.lists(cases, min_size=1, max_size=3).map(tuple)
    if wanted == "fields":
        fields = st.builds(Field, expressions("answer", min(depth, 1)))
        return st.lists(fields, min_size=1, max_size=3).map(tuple)
    return expressions(wanted, depth)


def of_track(track, seed: int = 0) -> Evidence:
    """Return the evidence of a recording that was followed."""
    belief = belief_of_track(track, worlds_of_clip_belief())
    recording = replace(RECORDING, step_s=0.04)
    return Evidence(worlds_of_track(track, belief, seed), recording, AREA)


def of_clip(belief, seed: int = 0) -> Evidence:
    """Return the evidence of a clip of four frames."""
    return Evidence(worlds_of_clip(belief, seed), RECORDING, AREA)


def worlds_of_clip_belief():
    """Return what is believed of the window of a recording that holds still."""
    still = Twist()
    ways = dict.fromkeys((way for ways in WAYS.values() for way in ways), 0.0)
    return Belief(still, 0.1 * np.eye(4), ways, 1.0, 30.0, dict.fromkeys(COMPONENTS, True))


evidence = st.one_of(beliefs().map(of_clip), tracks.map(of_track))
pairs = st.one_of(
    evidence.map(lambda one: (one,)),
    st.tuples(evidence, beliefs().map(lambda belief: of_clip(belief, 1))),
)
frames = st.sampled_from([
    FrameSpec(), FrameSpec(mm_per_px=0.08), FrameSpec(thread="right", contact_side="head"),
    FrameSpec(image_mirrored=True, actor="sensor"),
])  # fmt: skip


def context_of(*clips: Evidence, frame: FrameSpec | None = None) -> Context:
    """Return the context of clips."""
    return Context(clips, frame or FrameSpec())


def there_and_back() -> Evidence:
    """Return a recording touched at 0 s, turned 40 degrees, 15 back, 40 again, let go at 4 s."""
    return of_track(turning([40.0, -15.0, 40.0]))
