"""Random well-typed programs and the evidence that they are evaluated on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.twist import COMPONENTS, WAYS, Twist
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query import lines
from geotlm_lm.query import program as p
from geotlm_lm.query.answers import answers
from geotlm_lm.query.evaluate import ContactArea, Context, Evidence
from geotlm_lm.query.program import Case, Expression, Field, of
from geotlm_lm.query.quantities import Quantity
from geotlm_lm.query.values import Recording
from geotlm_lm.query.worlds import worlds_of_clip, worlds_of_track
from geotlm_lm.track.summed import belief_of_track
from tests.query.strategies import beliefs, tracks, turning
from tests.track.tracks import happened, moving_track

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
    if wanted in p.NAMES:  # the names themselves
        return st.sampled_from(sorted(accepted))
    words = [word for word in accepted if word != "again"]
    leaves = [word for word in words if all(each in p.NAMES for each in accepted[word])]
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


def of_track(track, seed: int = 0, recording: Recording = RECORDING) -> Evidence:
    """Return the evidence of a recording that was followed."""
    recording = replace(recording, step_s=0.04)
    return Evidence(
        worlds_of_track(track, belief_of_track(track, certain()), seed), recording, AREA
    )


def of_clip(belief, seed: int = 0, recording: Recording = RECORDING) -> Evidence:
    """Return the evidence of a clip of four frames."""
    return Evidence(worlds_of_clip(belief, seed), recording, AREA)


def certain(*, turn=0.0, right=0.0, down=0.0, inward=0.0, contact=1.0, share=0.99) -> Belief:
    """Return a belief that is sure of a motion."""
    ways = dict.fromkeys((way for ways in WAYS.values() for way in ways), 0.0)
    twist = Twist(turn, right, down, inward)
    paths = {"turn": turn, "slide": twist.slide_px, "press": inward}
    for component in COMPONENTS:
        if paths[component.value]:
            ways[twist.way(component)] = share * contact
    spread = np.diag([0.1, 0.1, 0.1, 0.001])
    return Belief(twist, spread, ways, contact, 30.0, dict.fromkeys(COMPONENTS, True))


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


def turned_and_slid() -> Evidence:
    """Return a recording touched at 0 s, turned 20 degrees, slid left, let go at 3 s of 4 s."""
    twists = np.zeros((101, 4))
    twists[26:51, 0], twists[51:76, 1] = 20 / 25, -30 / 25
    events = (
        happened("touch", 0, 0),
        happened("stick", 0, 25),
        happened("turn", 25, 50, turn=20),
        happened("slide", 50, 75, right=-30),
        happened("release", 75, 75, inward=-0.3),
    )
    contact = (np.arange(101) <= 75).astype(float)
    return of_track(moving_track(twists, events, contact=contact, frame_size=(240, 320)))


def told(line, *clips, frame=None):
    """Return what a line comes to."""
    return answers(lines.read(line), clips or (there_and_back(),), frame or FrameSpec())[0]
