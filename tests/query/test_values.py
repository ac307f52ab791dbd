"""What programs come to: counts, times, speeds, threads, reasons, axes, and two clips."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.core.edit import MIRRORED, opposite
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.query import lines
from geotlm_lm.query.answers import answers
from geotlm_lm.query.program import WAY_ATOMS
from geotlm_lm.query.telling import Teller
from geotlm_lm.query.values import Truth
from geotlm_lm.query.written import worded
from tests.answering.scripted import believed
from tests.query.programs import (
    RECORDING,
    certain,
    of_clip,
    of_track,
    told,
    turned_and_slid,
)
from tests.query.strategies import beliefs, edits, tracks, turning

FRAME = FrameSpec()
THREAD = FrameSpec(thread="right", contact_side="head")
BACK_AND_FORTH = of_track(turning([40.0, -15.0, 40.0, 15.0, -40.0]))
"""It turns back three times, twice of them by 40 degrees, and touches for six seconds of seven."""


@pytest.mark.parametrize(("line", "value"), [
    ("count reverse-events", 3),
    ("backwards count reverse-events", 3),
    ("within part 1 2 contact count reverse-events", 1),
    ("count move-events", 5),
    ("count touch-events", 1),
    ("count such > amount turn 20.0:deg reverse-events", 2),
    ("count such > amount turn 50.0:deg reverse-events", 0),
    ("count such < amount turn 20.0:deg reverse-events", 1),
    ("count such > speed turn 1.0:turn/min reverse-events", 3),
    ("time-while touch", 6),
    ("time-while turn", 5),
    ("time-while ccw", 2),
    ("within recording time-while none", 1),
])  # fmt: skip
def test_how_often_and_how_long(line, value):
    assert told(line, BACK_AND_FORTH).amount.mean == pytest.approx(value, abs=0.07)


@pytest.mark.parametrize(("line", "seconds"), [
    ("turn", 5), ("ccw", 2), ("touch", 6), ("still", 1),
])  # fmt: skip
def test_what_lasts_is_as_long_as_from_its_begin_to_its_end(line, seconds):
    lasting = told(f"time-while {line}", BACK_AND_FORTH).amount
    assert lasting.mean == pytest.approx(seconds, abs=1e-9)
    share = told(f"share {line}", BACK_AND_FORTH).amount
    assert share.mean == pytest.approx(100 * seconds / 6)
    if line in ("turn", "ccw"):
        assert lasting.is_near(told(f"lasts {line}-events", BACK_AND_FORTH).amount)


@pytest.mark.parametrize(("line", "holds"), [
    ("> count reverse-events 4", False),
    ("= count reverse-events 3", True),
    ("not < count reverse-events 3", True),
    ("in-range count reverse-events 2 3", True),
    ("> time-while touch 2.0:s", True),
    ("> time-while touch 0.2:min", False),
    ("> time-while touch 140.0:frame", True),
    ("within recording < time-while none 1500.0:ms", True),
    ("> time-while slide 1.0:s", False),
    ("not > time-while turn 4.0:s", False),
])  # fmt: skip
def test_counts_and_durations_are_judged_in_the_unit_that_is_stated(line, holds):
    assert told(line, BACK_AND_FORTH).holds is holds


@given(st.sampled_from(("reverse", "turn", "cw", "touch")), st.integers(0, 6), tracks, edits)
@settings(max_examples=30, deadline=None)
def test_more_less_and_as_many_exclude_each_other(kind, number, track, edit):
    clip, view = of_track(track), " ".join(edit.words)
    signs = {sign: told(f"{view} {sign} count {kind}-events {number}", clip) for sign in "><="}
    assert sum(each.chance for each in signs.values()) == pytest.approx(1)
    count = told(f"{view} count {kind}-events", clip)
    exact = told(f"{view} = count {kind}-events {count.amount.value:g}", clip)
    assert exact.chance == pytest.approx(count.probability)


@given(st.sampled_from(("touch", "none", "still", "move", "cw")), st.floats(0, 9), tracks)
@settings(max_examples=30, deadline=None)
def test_what_is_so_and_what_is_not_last_as_long_as_all(trait, seconds, track):
    clip = of_track(track)
    so, denied = (told(f"within recording time-while {said}", clip).amount.mean
                  for said in (trait, f"not {trait}"))  # fmt: skip
    assert so + denied == pytest.approx(track.seconds, abs=0.05)
    line = f"within recording > time-while {trait} {seconds}:s"
    yes, no = told(line, clip), told(f"within recording not > time-while {trait} {seconds}:s", clip)
    assert yes.chance + no.chance == pytest.approx(1)
    assert (
        yes.holds == (told(f"within recording time-while {trait}", clip).amount.mean > seconds)
        or yes.probability < 0.6
    )


@given(st.floats(0.51, 1.0))
@settings(max_examples=10, deadline=None)
def test_what_happens_is_as_sure_as_its_events(sure):
    clip = of_track(turning([40.0, -15.0], sure))
    for line in ("happens cw-events", "happens none-events", "not happens cw-events"):
        assert told(line, clip).probability == pytest.approx(sure, abs=0.005)


@pytest.mark.parametrize(("line", "value", "unit"), [
    ("speed turn", 20, "deg/s"),
    ("within part 1 2 recording speed turn", 20, "deg/s"),
    ("per per-frame speed turn", 0.8, "deg/frame"),
    ("speed slide", 30 * 320 / 224, "px/s"),
    ("top-speed turn", 20, "deg/s"),
    ("peak left", 30 * 320 / 224, "px"),
    ("within between t 1.0:s t 1.5:s amount turn", 10, "deg"),
    ("within between t 25.0:frame t 50.0:frame amount turn", 20, "deg"),
    ("within final 1.5:s recording amount slide", 0.5 * 30 * 320 / 224, "px"),
    ("within recording time-while and touch not move", 1, "s"),
])  # fmt: skip
def test_speeds_and_parts_are_of_the_time_in_which_it_moves(line, value, unit):
    amount = told(line, turned_and_slid()).amount
    assert (amount.mean, amount.unit) == (pytest.approx(value, rel=0.05, abs=0.03), unit)


@pytest.mark.parametrize(("line", "at_s"), [
    ("peak turn", 2.0),
    ("backwards peak turn", 3.0),
    ("peak left", 3.0),
    ("top-speed turn", 1.5),
])  # fmt: skip
def test_a_greatest_amount_is_told_with_its_moment(line, at_s):
    assert told(line, turned_and_slid()).at_s == pytest.approx(
        at_s, abs=0.5 if "top" in line else 0.05
    )


@pytest.mark.parametrize(("line", "times"), [
    ("begin first turn-events", (1.0,)),
    ("backwards begin first turn-events", (2.0,)),
    ("end contact", (3.0,)),
    ("begin first none-events", (3.0,)),
    ("end last move-events", (3.0,)),
    ("first-time > amount turn 10.0:deg", (1.52,)),
    ("backwards first-time > amount turn 10.0:deg", (2.52,)),
    ("begin first such < amount turn 25.0:deg turn-events", (1.0,)),
    ("begin first such > amount turn 50.0:deg turn-events", ()),
    ("backwards begin first such > amount cw 10.0:deg cw-events", ()),
    ("first still-events", (0.0, 1.0)),
    ("backwards last still-events", (3.0, 4.0)),
])  # fmt: skip
def test_times_are_those_of_which_all_is_so_that_is_said(line, times):
    assert told(line, turned_and_slid()).times_s == pytest.approx(times, abs=0.05)


@pytest.mark.parametrize(("line", "text"), [
    ("end contact", "It is still held when the recording ends (2.8 s)."),
    ("backwards begin contact", "It is touched from the start."),
    ("backwards end first contact-events", "It is still held when the recording ends (2.8 s)."),
    ("ends contact-events", "It is still held when the recording ends (2.8 s)."),
    ("delay end first turn-events end contact",
     "It is still held when the recording ends (2.8 s)."),
    ("begin first touch-events", "It is touched from the start."),
    ("begin contact ; as json", '{"begin": null, "probability": 0.0}'),
    ("end first turn-events", "At 2.0 s."),
    ("length contact", "2.8 s."),
    ("happens none-events", "No."),
])  # fmt: skip
def test_what_outlasts_the_recording_is_not_let_go_at_its_end(line, text):
    held = of_track(turning([40.0, 40.0]).between(0, 70))
    (value,) = answers(program := lines.read(line), (held,), FRAME)
    assert worded([value], program.form, Teller(RECORDING, FRAME), value.probability).text == text


@pytest.mark.parametrize(("line", "turn", "holds"), [
    ("> amount turn 10.0:deg", 14, True),
    ("> amount turn 0.125:turn", 14, False),
    ("in-range amount turn 10.0:deg 20.0:deg", 14, True),
    ("and cw > amount turn 10.0:deg", 14, True),
    ("and ccw < amount turn 20.0:deg", 14, False),
    ("> speed turn 10.0:deg/s", 14, True),
    ("> amount move 10.0:deg", 14, True),
    ("< amount turn 5.0:deg", 0, True),
    ("tighten", 14, True),
    ("loosen", 14, False),
    ("backwards tighten", 14, False),
    ("behind tighten", 14, True),
    ("tighten", 0, False),
    ("fact thread left ; loosen", 14, True),
])  # fmt: skip
def test_a_turn_is_judged_by_its_amount_and_its_thread(line, turn, holds):
    clip = of_clip(certain(turn=turn) if turn else certain(right=9))
    assert told(line, clip, frame=THREAD).holds is holds


@pytest.mark.parametrize(("line", "reason"), [
    ("count reverse-events", "track"),
    ("> time-while touch 2.0:s", "track"),
    ("always cw", "track"),
    ("count such > amount turn 20.0:s reverse-events", "unit"),
    ("unit deg amount slide", "unit"),
    ("> amount turn 10.0:mm", "unit"),
    ("fact thread left ; fact side side ; tighten", "side"),
    ("fact scale 50.0:mm ; way all", "pixel"),
    ("again", "before"),
    ("unit s length contact", "rate"),
    ("top-speed slide", "track"),
    ("speed turn", "rate"),
])  # fmt: skip
def test_what_cannot_be_told_has_its_reason(line, reason):
    untimed = replace(RECORDING, rate_hz=None)
    clip = of_clip(certain(turn=14), recording=untimed if reason == "rate" else RECORDING)
    if reason == "unit" or "length" in line:
        clip = of_track(turning([40.0]), recording=untimed)
    assert told(line, clip).reason == reason


def test_what_the_picture_does_not_tell_is_not_made_up():
    belief = certain(right=-9)
    clip = of_clip(replace(belief, readable=belief.readable | {Component.SLIDE: False}))
    for line in ("amount slide", "> amount slide 3.0:px"):
        assert told(line, clip).reason == "unreadable"
    assert told("slide", clip).holds
    assert told("way slide", clip).movements[0].amount is None
    unknown = of_clip(replace(certain(turn=20), is_contact_known=False))
    for line in ("none", "press", "in"):
        assert told(line, unknown).reason == "contact"
    assert told("turn", unknown).holds
    assert told("touch", unknown).holds  # what turns touches
    still = of_clip(replace(certain(), is_contact_known=False))
    assert told("touch", still).reason == "reference"


@given(st.sampled_from(("way turn", "cw", "or left out", "choose left | right", "amount turn")),
       beliefs(), edits)  # fmt: skip
@settings(max_examples=40, deadline=None)
def test_a_view_acts_as_on_the_belief(line, belief, edit):
    asked = told(" ".join((*edit.words, line)), of_clip(belief))
    seen = told(line, of_clip(belief.seen(edit)))
    assert type(asked) is type(seen)
    assert asked.probability == pytest.approx(seen.probability, abs=0.05)
    if max(asked.probability, seen.probability) > 0.7 and isinstance(asked, Truth):
        assert asked.holds == seen.holds


@given(beliefs(), edits, st.sampled_from("xy"))
@settings(max_examples=40, deadline=None)
def test_the_way_along_an_axis_agrees_with_the_claim_that_there_is_one(belief, edit, axis):
    claim, way = (
        told(" ".join((*edit.words, line)), of_clip(belief)) for line in (axis, f"way {axis}")
    )
    moves = way.rest is None and way.still_axis is None and not way.denied
    assert moves == claim.holds or claim.probability < 0.55


@given(st.sampled_from(sorted(WAY_ATOMS)), st.floats(-30, 30), beliefs())
@settings(max_examples=40, deadline=None)
def test_a_way_and_an_amount_are_no_likelier_than_the_way(way, number, belief):
    plain, bounded = (told(line, of_clip(belief))
                      for line in (way, f"and {way} > amount {way} {number}:"))  # fmt: skip
    assert bounded.chance <= plain.chance + 1e-9


WAYS = (*DIRECTED, Motion.PRESS, Motion.RELEASE)


@pytest.mark.parametrize("one", WAYS)
def test_two_ways_are_the_same_opposite_or_mirrored(one):
    for other in WAYS:
        clips = of_clip(believed(one)), of_clip(believed(other), 1)
        holds = {word: told(f"{word} way all", *clips).holds
                 for word in ("same", "opposite", "mirrored")}  # fmt: skip
        assert holds == {
            "same": one is other,
            "opposite": other is opposite(one),
            "mirrored": other is MIRRORED.of_way(one),
        }


@pytest.mark.parametrize(("line", "one", "other", "chosen"), [
    ("which-more amount turn", "left", "clockwise", (1,)),
    ("which-less amount turn", "left", "clockwise", (0,)),
    ("which-more amount turn", "left", "right", ()),
    ("which-clip turn", "clockwise", "left", (0,)),
    ("which-clip turn", "clockwise", "counterclockwise", (0, 1)),
    ("which-clip turn", "left", "right", ()),
])  # fmt: skip
def test_which_of_two_clips(line, one, other, chosen):
    found = told(line, of_clip(believed(one)), of_clip(believed(other), 1))
    assert (found.chosen, found.probability > 0.9) == (chosen, True)


def test_which_goes_further_is_as_sure_as_their_spreads_are_apart():
    sure = []
    for spread in (0.05, 0.3, 1.0):
        far, near = (of_clip(believed("clockwise", deg=deg, spread=spread), seed)
                     for seed, deg in enumerate((20, 12)))  # fmt: skip
        found = told("which-more amount turn", far, near)
        assert found.chosen == (0,)
        sure.append(found.probability)
    assert sure == sorted(sure, reverse=True)
    assert sure[0] > 0.9 > 0.7 > sure[-1]


def test_only_like_amounts_of_two_clips_are_compared():
    turn, slide = (of_clip(believed(way), seed) for seed, way in enumerate(("clockwise", "left")))
    assert told("which-more amount move", turn, slide).reason == "unlike"
    assert told("same way turn", turn).reason == "second"


def test_each_clip_is_asked_by_itself():
    held = of_track(turning([]), 1)
    found = told("each-clip count turn-events", turned_and_slid(), held)
    assert [(each.clip, each.amount.mean) for _, each in found.fields] == [
        ("first", 1),
        ("second", 0),
    ]
