"""What is decided follows from the belief alone, whatever the wording."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.twist import COMPONENTS, WAYS, Twist
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import Recording
from geotlm_lm.query.decision import Evidence
from geotlm_lm.query.execute import decide, execute
from geotlm_lm.query.forms import in_form
from geotlm_lm.query.quantities import quantities
from geotlm_lm.query.tell import tell
from geotlm_lm.query.text import read
from geotlm_lm.track.track import Track
from tests.query.strategies import beliefs, edits, queries
from tests.track.tracks import happened, moving_track

FRAME = FrameSpec()
RECORDING = Recording(columns=320, rows=240, rate_hz=25.0, frames=100, used=(10, 15, 20, 25))


def certain(*, turn=0.0, right=0.0, down=0.0, inward=0.0, contact=1.0) -> Belief:
    """A belief that is sure of a motion."""
    ways = dict.fromkeys((way for ways in WAYS.values() for way in ways), 0.0)
    twist = Twist(turn, right, down, inward)
    paths = {"turn": turn, "slide": twist.slide_px, "press": inward}
    for component in COMPONENTS:
        if paths[component.value]:
            ways[twist.way(component)] = 0.99 * contact
    readable = dict.fromkeys(COMPONENTS, True)
    return Belief(twist, np.diag([0.1, 0.1, 0.1, 0.001]), ways, contact, 30.0, readable)


def whole() -> Track:
    """A recording of four seconds at 25 Hz: held, turned by 20 degrees, slid left, let go."""
    twists = np.zeros((101, 4))
    twists[26:51, 0], twists[51:76, 1] = 20 / 25, -30 / 25
    events = (
        happened("touch", 0, 0),
        happened("stick", 0, 25),
        happened("turn", 25, 50, turn=20),
        happened("slide", 50, 75, right=-30),
        happened("release", 75, 75, inward=-0.3),
    )
    contact = np.arange(101) < 75
    return moving_track(twists, events, contact=contact.astype(float), frame_size=(240, 320))


def answer(text, belief, *, question="", frame=FRAME, **more):
    query = t.filled(read(text), quantities(question))
    return execute(query, Evidence(belief, recording=RECORDING, **more), frame)[0]


propositions = st.builds(
    t.Proposition,
    st.lists(st.builds(t.Literal, st.sampled_from((*t.WAY_ATOMS, "turn", "slide", "press", "move",
                                                   "still", "touch", "none", "x", "y")),
                       st.none(), st.booleans()), min_size=1, max_size=3).map(tuple),
    st.sampled_from(("and", "or")),
)  # fmt: skip


@given(propositions, beliefs(), edits)
@settings(max_examples=40, deadline=None)
def test_a_claim_and_its_denial_are_never_both_so(proposition, belief, edit):
    one, two = (
        decide(t.Part(t.Ask("how-sure", said), edit), Evidence(belief), FRAME)
        for said in (proposition, proposition.deny())
    )
    assert one.chances[0] + two.chances[0] == pytest.approx(1)
    assert proposition.deny().deny().literals == proposition.literals


bounds = st.tuples(
    st.sampled_from(("more", "less", "about", "between")), st.floats(-30, 30), st.floats(-30, 30)
)


@given(st.sampled_from(sorted(t.WAY_ATOMS)), bounds, beliefs(), edits)
@settings(max_examples=40, deadline=None)
def test_a_way_and_an_amount_are_no_likelier_than_the_way(atom, bound, belief, edit):
    relation, low, high = bound
    ends = t.Quantity(low), t.Quantity(high) if relation == "between" else None
    plain, bounded = (
        decide(t.Part(t.Ask("how-sure", t.Proposition((said,))), edit), Evidence(belief), FRAME)
        for said in (t.Literal(atom), t.Literal(atom, t.Bound(relation, *ends)))
    )
    assert bounded.chances[0] <= plain.chances[0] + 1e-9


@given(beliefs(), edits)
@settings(max_examples=40, deadline=None)
def test_claim_choice_and_open_question_agree(belief, edit):
    evidence = Evidence(belief)
    open_ = decide(t.Part(t.Ask("way", of="turn"), edit), evidence, FRAME)
    claims = {
        one: decide(t.Part(read(f"claim {one}").parts[0].ask, edit), evidence, FRAME)
        for one in ("cw", "ccw")
    }
    choice = decide(t.Part(read("choice cw , ccw , not turn").parts[0].ask, edit), evidence, FRAME)
    assert choice.chances[2] == pytest.approx(1 - choice.chances[0] - choice.chances[1])
    so = [one for one in claims if claims[one].verdict]
    if so:
        assert open_.movements[0].way == t.WAY_ATOMS[so[0]]
        assert choice.options == ((0,) if so == ["cw"] else (1,))
    if open_.denied or open_.rest:
        assert not so


@given(beliefs(), edits, st.sampled_from(["x", "y"]))
@settings(max_examples=60, deadline=None)
def test_the_way_along_an_axis_agrees_with_the_claim_that_there_is_one(belief, edit, axis):
    def decided(text):
        part = read(text).parts[0]
        return decide(replace(part, edit=edit), Evidence(belief, recording=RECORDING), FRAME)

    claim, way, amount = (decided(f"{kind} {axis}") for kind in ("claim", "way", "amount"))
    moves = way.rest is None and way.still_axis is None and not way.denied
    assert moves == claim.verdict
    assert way.still_axis == amount.still_axis
    if not moves:
        assert "does not" in tell(way) or "othing touches" in tell(way)
    if way.still_axis:
        assert in_form([way], "sign", RECORDING) not in ("+", "-")
        assert json.loads(in_form([way], "json", RECORDING))[axis] is None


@given(st.sampled_from(["way", "way turn", "claim cw", "claim left or out", "choice left , right"]),
       beliefs(), edits)  # fmt: skip
@settings(max_examples=40, deadline=None)
def test_an_edit_acts_as_on_the_belief(text, belief, edit):
    ask = read(text).parts[0].ask
    asked = decide(t.Part(ask, edit), Evidence(belief), FRAME)
    seen = decide(t.Part(ask), Evidence(belief.seen(edit)), FRAME)
    assert replace(asked, part=seen.part) == seen


@given(queries, beliefs(), st.sampled_from([None, whole()]), st.booleans())
@settings(max_examples=30, deadline=None)
def test_every_query_is_decided_and_told(query, belief, track, has_second):
    numbers = (t.Quantity(12.5, "deg"), t.Quantity(0.06, "mm/px"), t.Quantity(0.5, "s"))
    evidence = Evidence(belief, Evidence(belief) if has_second else None, RECORDING, track)
    found = execute(t.filled(query, numbers), evidence, FRAME)
    assert len(found) == len(query.parts)
    assert all(tell(one, RECORDING) for one in found)


@pytest.mark.parametrize(
    ("question", "text", "verdict"),
    [
        ("more than 10 degrees?", "claim turn > #1", True),
        ("more than an eighth of a turn?", "claim turn > #1", False),
        ("between 10 and 20 degrees?", "claim turn in-range #1 #2", True),
        ("clockwise and more than 10 degrees?", "claim cw and turn > #1", True),
        ("counterclockwise by less than 20 degrees?", "claim ccw < #1", False),
        ("faster than 10 degrees per second?", "claim turn > #1", True),
        ("more than 10 degrees?", "claim move > #1", True),
    ],
)
def test_an_amount_that_is_said_is_judged_in_its_unit(question, text, verdict):
    assert answer(text, certain(turn=14), question=question).verdict is verdict
    still = certain(right=9)
    assert answer("claim turn ~ #1", still, question="half a degree?").verdict is False
    assert answer("claim turn < #1", still, question="less than 5 degrees?").verdict is True


def test_a_fact_holds_for_what_is_asked_with_it():
    far = answer("fact scale #1 ; amount slide", certain(right=10), question="0.06 mm per pixel")
    assert (far.amounts[0].unit, far.amounts[0].mean) == ("mm", pytest.approx(0.857, abs=0.001))


def test_a_thread_tightens_as_its_facts_say():
    facts = "fact thread left ; fact side head ; claim loosen"
    assert answer(facts, certain(turn=14)).verdict is True
    assert answer("claim tighten", certain(turn=14)).missing == "thread"
    assert answer("claim tighten", certain(right=9)).verdict is False
    frame = FrameSpec(thread="right", contact_side="head")
    assert answer("claim tighten", certain(turn=14), frame=frame).verdict is True
    assert answer("backwards > claim tighten", certain(turn=14), frame=frame).verdict is False
    assert answer("behind > claim tighten", certain(turn=14), frame=frame).verdict is True


@pytest.mark.parametrize(
    ("text", "times"),
    [
        ("when turn begin", (1.0,)),
        ("backwards > when turn begin", (2.0,)),
        ("when touch end", (2.96,)),
        ("when stops begin", (3.0,)),
        ("how-long move", (2.0,)),
        ("how-long touch", (2.96,)),
        ("how-often turn", (1.0,)),
    ],
)
def test_times_are_read_off_the_track(text, times):
    assert answer(text, certain(), track=whole()).times == pytest.approx(times)


def test_order_turns_round_when_played_backwards():
    assert answer("order turn slide", certain(), track=whole()).verdict is True
    assert answer("backwards > order turn slide", certain(), track=whole()).verdict is False


@pytest.mark.parametrize(
    ("text", "question", "turned"),
    [
        ("from #1 to #2 > amount turn", "between 1 and 1.5 s", 9.6),
        ("from #1 to #2 > amount turn", "frames 25 to 50", 20.0),
        ("in-first-half > amount turn", "", 20.0),
        ("in-end to #1 > amount slide", "the last 1.5 seconds", 14.4),
    ],
)
def test_a_span_asks_for_a_part_of_the_track(text, question, turned):
    found = answer(text, certain(turn=1), question=question, track=whole())
    value = found.amounts[0].mean
    assert value == pytest.approx(turned * (320 / 224 if "slide" in text else 1), rel=0.05)


def test_a_recording_is_told_as_a_story():
    told = tell(answer("order", certain(), track=whole()), RECORDING)
    assert told == (
        "It touches at 0.0 s, then it is held still, from 0.0 s to 1.0 s, then it turns clockwise, "
        "about 20 degrees, from 1.0 s to 2.0 s, then it slides left, about 43 px, from 2.0 s to "
        "3.0 s, then it lifts off at 3.0 s, in the camera image."
    )


@pytest.mark.parametrize(
    ("text", "verdict"),
    [
        ("compare opposite turn", True),
        ("compare same way", False),
        ("compare same kind", True),
        ("compare more turn", True),
        ("of-both > claim turn", True),
        ("of-only-one > claim cw", True),
    ],
)
def test_two_clips_are_compared_on_what_is_asked(text, verdict):
    two = Evidence(certain(turn=-10), recording=RECORDING)
    assert answer(text, certain(turn=20), second=two).verdict is verdict
    assert answer("which-clip ccw", certain(turn=20), second=two).options == (1,)


@pytest.mark.parametrize(
    ("text", "belief", "sentence"),
    [
        ("way", certain(turn=12, right=-4),
         "It turns clockwise, about 12 degrees, and slides left, about 6 px, in the camera image."),
        ("way turn", certain(right=9),
         "It does not turn; it slides right, about 13 px, in the camera image."),
        ("claim not turn", certain(turn=12),
         "No, that is not so: it turns clockwise, about 12 degrees, in the camera image."),
        ("mirror backwards > way", certain(turn=12),
         "It turns clockwise, about 12 degrees, in the camera image mirrored, played backwards."),
        ("claim move", certain(), "No: it touches but does not move."),
        ("claim touch", certain(contact=0.0), "No: nothing touches the gel."),
        ("choice A left , B right", certain(right=9),
         "B: it slides right, about 13 px, in the camera image."),
        ("how-often turn", certain(), "One clip does not show that; give me the whole recording."),
    ],
)  # fmt: skip
def test_a_decision_is_told(text, belief, sentence):
    assert tell(answer(text, belief)) == sentence
