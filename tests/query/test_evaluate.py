"""The laws of expressions, over random programs and random evidence."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.twist import Component
from geotlm_lm.motion.belief import SPAN_DEVIATIONS
from geotlm_lm.query import evaluate as evaluating
from geotlm_lm.query import lines
from geotlm_lm.query import program as p
from geotlm_lm.query.answers import answer
from geotlm_lm.query.evaluate import Untold, evaluate
from geotlm_lm.query.program import Case, of
from geotlm_lm.query.telling import Teller
from geotlm_lm.query.values import Amount, Choice, Moved, Record, Times, Truth, Unknown
from geotlm_lm.query.worlds import COUNT, Happening
from geotlm_lm.query.written import worded
from geotlm_lm.track.events import EventKind
from tests.query.programs import (
    RECORDING,
    certain,
    context_of,
    evidence,
    expressions,
    frames,
    of_clip,
    of_track,
    pairs,
    there_and_back,
    told,
)
from tests.query.strategies import turning
from tests.track.tracks import happened, moving_track, track_of_events

FRAME = FrameSpec()
THREAD = FrameSpec(thread="right", contact_side="head")
BACK_AND_FORTH = of_track(turning([40.0, -15.0, 40.0, 15.0, -40.0]))
"""It turns back three times, twice of them by 40 degrees, and touches for six seconds of seven."""


def same(one, two):
    np.testing.assert_array_equal(
        np.broadcast_arrays(one, two)[0], np.broadcast_arrays(one, two)[1]
    )


def both(context, *expressions):
    """Return what expressions are in every world, or None where one of them cannot be told."""
    try:
        return [evaluate(each, context) for each in expressions]
    except Untold:
        return None


@given(expressions(), pairs, frames)
@settings(max_examples=100, deadline=None)
def test_every_program_comes_to_a_value(expression, clips, frame):
    value = answer(expression, context_of(*clips, frame=frame))
    assert 0 <= value.probability <= 1
    if isinstance(value, Amount):
        assert np.isfinite(value.amount.value)


@given(expressions("bool", 3), evidence)
@settings(max_examples=50, deadline=None)
def test_denied_twice_is_the_same_again(expression, clip):
    found = both(context_of(clip), expression, of("not", of("not", expression)))
    assert found is None or same(*found) is None


@given(expressions("bool", 2), expressions("bool", 2), evidence)
@settings(max_examples=50, deadline=None)
def test_de_morgan(one, two, clip):
    denied = of("not", of("and", one, two)), of("or", of("not", one), of("not", two))
    found = both(context_of(clip), *denied)
    assert found is None or same(*found) is None


@given(expressions("bool", 3), evidence)
@settings(max_examples=40, deadline=None)
def test_a_claim_and_its_denial_add_up_to_what_can_be_told(expression, clip):
    context = context_of(clip)
    yes, no = answer(expression, context), answer(of("not", expression), context)
    if isinstance(yes, Truth) and isinstance(no, Truth):
        known = yes.chance + no.chance
        assert known <= 1 + 1e-9
        assert yes.holds != no.holds or yes.chance == pytest.approx(no.chance)


@given(evidence, frames)
@settings(max_examples=40, deadline=None)
def test_claim_choice_and_open_question_agree(clip, frame):
    frame = replace(frame, thread=None)
    context = context_of(clip, frame=frame)
    open_ = answer(of("way", "turn"), context)
    cases = tuple(Case(of(way)) for way in ("cw", "ccw")) + (Case(of("other")),)
    choice = answer(of("choose", cases), context)
    for place, way in enumerate(("cw", "ccw")):
        claim = answer(of(way), context)
        assert claim.chance == choice.chances[place]
        if isinstance(open_, Moved) and open_.movements and open_.movements[0].component == "turn":
            is_way = (
                open_.movements[0].way.value == {"cw": "clockwise", "ccw": "counterclockwise"}[way]
            )
            assert claim.holds or not is_way or open_.probability < 0.5


@given(st.lists(expressions("answer", 2), min_size=1, max_size=3), evidence)
@settings(max_examples=40, deadline=None)
def test_a_template_is_its_fields_asked_one_by_one(wanted, clip):
    context = context_of(clip)
    found = answer(of("record", tuple(p.Field(each) for each in wanted)), context)
    assert isinstance(found, Record)
    for (_, value), each in zip(found.fields, wanted, strict=True):
        alone = answer(each, context)
        assert type(value) is type(alone)
        assert value.probability == pytest.approx(alone.probability, abs=1e-12)


@given(st.sampled_from(("turn", "slide", "cw", "left")), st.floats(0.05, 0.95))
@settings(max_examples=40, deadline=None)
def test_adjacent_spans_add_up(atom, share):
    cut = f"t {share * 100}:percent"
    whole, first, second = (
        evaluate(lines.read(line).answers[0], context_of(there_and_back())).values
        for line in (
            f"within recording path {atom}",
            f"within between begin recording {cut} path {atom}",
            f"within between {cut} end recording path {atom}",
        )
    )
    np.testing.assert_allclose(first + second, whole, atol=1e-9)


@given(evidence, st.sampled_from((("deg", "rad", 57.29577951308232), ("deg", "turn", 360.0))))
@settings(max_examples=20, deadline=None)
def test_units_convert(clip, units):
    unit, other, factor = units
    one, two = (evaluate(of("unit", each, of("amount", "turn")), context_of(clip))
                for each in (unit, other))  # fmt: skip
    np.testing.assert_allclose(one.values, two.values * factor)


@given(expressions("bool", 2), evidence, st.sampled_from(p.EDIT_WORDS))
@settings(max_examples=40, deadline=None)
def test_a_view_that_is_taken_back_changes_nothing(expression, clip, word):
    back = {"quarter-cw": "quarter-ccw", "quarter-ccw": "quarter-cw"}.get(word, word)
    found = both(context_of(clip), expression, of(word, of(back, expression)))
    assert found is None or same(*found) is None


def test_a_share_is_a_time_over_a_time():
    share, during, whole = (told(line).amount.mean for line in (
        "share turn", "time-while turn", "length contact"))  # fmt: skip
    assert share == pytest.approx(100 * during / whole, rel=1e-6)


@pytest.mark.parametrize(("line", "value", "unit"), [
    ("amount cw", 65, "deg"),
    ("path turn", 95, "deg"),
    ("path ccw", 15, "deg"),
    ("count turn-events", 3, ""),
    ("count reverse-events", 2, ""),
    ("count such > amount turn 30.0:deg turn-events", 2, ""),
    ("count such > length here 0.5:s turn-events", 3, ""),
    ("count such > length here 2.0:s turn-events", 0, ""),
    ("within part 1 2 contact amount cw", 40 - 0, "deg"),
    ("within final 1.0:s contact amount cw", 40, "deg"),
    ("within between end first turn-events begin last turn-events amount cw", -15, "deg"),
    ("delay begin contact begin first turn-events", 1.0, "s"),
    ("unit frame delay begin contact begin first turn-events", 25, "frame"),
    ("percent-of amount cw 130.0:deg", 50, "percent"),
    ("- path turn amount cw", 30, "deg"),
    ("/ path cw path ccw", 80 / 15, ""),
    ("at t 2.0:s amount cw", 40, "deg"),
    ("speed cw", 65 / 3, "deg/s"),
    ("per per-min within first turn-events speed turn", 2400, "deg/min"),
    ("peak cw", 65, "deg"),
    ("clock first-time > amount cw 30.0:deg", 1.75, "s"),
    ("time-while not turn", 1.0, "s"),
    ("if > amount cw 60.0:deg 1 0", 1, ""),
    ("mean-of turn-events amount turn", 95 / 3, "deg"),
    ("median-of turn-events amount turn", 40, "deg"),
    ("sum-of turn-events amount turn", 95, "deg"),
    ("most-of turn-events amount turn", 40, "deg"),
    ("least-of turn-events amount turn", 15, "deg"),
    ("spread-of turn-events amount turn", 11.79, "deg"),
    ("nearest 20.0: amount cw", 60, "deg"),
    ("floor / amount cw 10", 6, "deg"),
    ("ceil / amount cw 10", 7, "deg"),
    ("margin > amount cw 30.0:deg", 35, "deg"),
    ("/ count turn-events length contact", 0.75, "/s"),
    ("per per-min / count turn-events length contact", 45, "/min"),
    ("/ amount cw length contact", 16.25, "deg/s"),
    ("* amount cw 10.0:mm", 11.34, "mm"),
    ("* unit rad amount cw 10.0:mm", 11.34, "mm"),
    ("* unit turn amount cw 10.0:mm", 1.81, "mm"),  # a pitch
    ("unit mrad amount cw", 1134, "mrad"),
    ("count contact-events", 1, ""),
    ("count gaps touch-events", 0, ""),
])  # fmt: skip
def test_numbers_of_a_recording(line, value, unit):
    found = told(line)
    assert isinstance(found, Amount)
    assert found.amount.unit == unit
    assert found.amount.mean == pytest.approx(value, rel=0.04, abs=0.05)


def test_what_is_being_pressed_against_the_gel_is_not_at_rest():
    events = (
        happened("touch", 25, 25),
        happened("press", 25, 50, inward=0.5),
        happened("stick", 50, 75),
        happened("release", 75, 100, inward=-0.5),
    )
    steps = np.zeros((101, 4))
    steps[26:51, 3], steps[76:, 3] = 0.02, -0.02
    contact = np.isin(np.arange(101), range(25, 100)).astype(float)
    clip = of_track(moving_track(steps, events, contact=contact))
    rests = evaluate(lines.read("time-while still").answers[0], context_of(clip))
    assert np.median(rests.values) == pytest.approx(1.0, abs=0.1)
    assert not told("move", clip).holds  # of the whole contact that is the touch itself
    assert not told("at t 1.5:s still", clip).holds
    assert told("at t 2.5:s still", clip).holds


def test_how_far_a_sudden_release_goes_is_not_known():
    (clip,) = context_of(BACK_AND_FORTH).clips
    assert any(each.kind is EventKind.RELEASE for each in clip.worlds.happenings)
    coarse = replace(clip, worlds=replace(clip.worlds, unseen=clip.worlds.unseen + 0.1, views={}))
    pressed = evaluate(lines.read("within recording amount press").answers[0], context_of(coarse))
    assert (pressed.values > 0).all()


def test_a_whole_contact_lifts_off_as_far_as_it_was_pressed():
    events = [
        happened("touch", 10, 10),
        happened("press", 10, 16, inward=0.3),
        happened("release", 90, 100, inward=-1.0),
    ]
    clip = of_track(track_of_events(events))
    pressed, lifted = (each.twist[:, 3] for each in clip.worlds.motions(Component.PRESS))
    both = (pressed != 0) & (lifted != 0)
    assert both.mean() > 0.9
    assert np.allclose((pressed + lifted)[both], 0)
    value = told("within recording peak in", clip)
    assert 0.3 < value.amount.mean < 1.0
    cut_off = of_track(track_of_events(events[:2]))  # nothing lifts off
    (alone,) = (each.twist[:, 3] for each in cut_off.worlds.motions(Component.PRESS))
    assert np.median(alone) == pytest.approx(0.3, abs=0.05)


def test_what_may_well_be_nothing_is_told_by_its_most():
    noise = 0.1 * np.random.default_rng(0).standard_normal((COUNT, 4))
    coarse = replace(BACK_AND_FORTH, worlds=replace(BACK_AND_FORTH.worlds, unseen=noise, views={}))
    value = told("within recording > amount in 0.2:mm", coarse)
    text = worded([value], "sentence", Teller(RECORDING, FRAME), value.probability).text
    assert text == "No, at most 0.17 mm."


@pytest.mark.parametrize(
    "line", ["amount turn", "peak turn", "top-speed turn", "at peak-time turn amount turn"]
)
def test_what_is_too_small_to_be_seen_is_no_part_of_what_is_seen(line):
    (seen,) = context_of(BACK_AND_FORTH).clips
    coarse = replace(seen, worlds=replace(seen.worlds, unseen=50 * seen.worlds.unseen, views={}))
    fine, other = (answer(lines.read(line).answers[0], context_of(each)) for each in (seen, coarse))
    assert other.amount == fine.amount


@pytest.mark.parametrize(("line", "holds"), [
    ("cw", True),
    ("ccw", False),
    ("happens ccw-events", True),
    ("always touch", True),
    ("ever ccw", True),
    ("within recording always touch", False),
    ("within final 0.5:s contact turn", True),
    ("within until begin first turn-events turn", False),
    ("at t 0.5:s turn", False),
    ("at t 1.5:s turn", True),
    ("before begin first cw-events begin first ccw-events", True),
    ("= count turn-events 3", True),
    ("= count turn-events 3.0:turn", True),
    ("xor cw ccw", True),
    ("xor cw happens ccw-events", False),
    ("and > amount cw 50.0:deg < amount cw 80.0:deg", True),
    ("in-range amount turn 50.0: 80.0:deg", True),
    ("happens such > length here 0.5:s still-events", True),
    ("> within part 1 3 contact path turn within part 2 3 contact path turn", False),
])  # fmt: skip
def test_truths_of_a_recording(line, holds):
    found = told(line)
    assert isinstance(found, Truth)
    assert found.holds is holds
    assert found.probability > 0.8


def test_what_comes_back_is_as_far_as_it_got():
    clip = of_track(turning([40.0, -38.0]))
    far = told("amount turn", clip)
    assert far.amount.mean == pytest.approx(40, rel=0.04)
    assert far.at_s == pytest.approx(2.0)
    assert told("net turn", clip).amount.mean == pytest.approx(2, abs=0.5)
    assert told("> amount turn 30.0:deg", clip).holds
    assert told("amount ccw", clip).amount.mean == pytest.approx(38, rel=0.04)
    assert told("net cw", clip).amount.mean == pytest.approx(2, abs=0.5)
    assert not told("> amount ccw 45.0:deg", clip).holds


def test_the_ends_of_a_number_lie_as_far_apart_as_its_span():
    low, high, deviation = (
        told(f"{end} amount cw").amount.mean for end in ("low", "high", "sigma")
    )  # fmt: skip
    assert low < told("amount cw").amount.mean < high
    assert deviation == pytest.approx((high - low) / (2 * SPAN_DEVIATIONS))


def test_a_difference_may_be_below_zero_and_is_as_sure_as_its_terms():
    clip = of_clip(certain(turn=94))
    whole, rest = told("amount turn", clip), told("- 90.0:deg amount turn", clip)
    assert rest.amount.value == pytest.approx(-4, abs=1)
    low, high = rest.amount.span
    assert low < -4 < high
    assert rest.probability >= whole.probability - 0.01


def test_a_span_has_limits_of_its_own():
    clip = there_and_back()
    whole = dict(told("slide", clip).motion.limits)[Component.SLIDE][0]
    part = dict(told("within part 1 4 contact slide", clip).motion.limits)[Component.SLIDE][0]
    assert 0 < part.mean < whole.mean


def test_moments_of_a_recording():
    assert told("begin first turn-events").times_s == pytest.approx((1.0,))
    assert told("begins turn-events").times_s == pytest.approx((1.0, 2.0, 3.0))
    assert told("backwards begin first turn-events").times_s == pytest.approx((1.0,))
    assert told("last-time cw").times_s == pytest.approx((4.0,))
    assert told("largest ccw-events").times_s == pytest.approx((2.0, 3.0))
    assert isinstance(told("begin first slide-events"), Times)


def test_what_a_recording_lacks_is_said_with_its_reason():
    assert told("amount slide", of_clip(certain(turn=20))).denied
    assert told("begin first turn-events", of_clip(certain(turn=20))).reason == "track"
    assert told("of-second amount turn").reason == "second"
    assert told("unit mm amount slide", of_clip(certain(right=9))).reason == "scale"
    assert told("tighten").reason == "thread"
    assert isinstance(told("within first slide-events amount turn"), Unknown)


def test_two_recordings_are_compared_by_the_same_operators():
    clips = of_clip(certain(turn=40)), of_clip(certain(turn=-10), 1)
    assert not told("same way turn", *clips).holds
    assert told("opposite way turn", *clips).holds
    assert told("more amount turn", *clips).holds
    assert told("which-more amount turn", *clips).chosen == (0,)
    assert told(
        "/ of-first amount turn of-second amount turn", *clips
    ).amount.value == pytest.approx(4, abs=0.3)
    assert told("which-clip ccw", *clips).chosen == (1,)
    assert told("either ccw", *clips).holds
    assert not told("both ccw", *clips).holds


def test_own_labels_are_chosen_by_what_holds():
    found = told("choose A > amount cw 30.0:deg | B other")
    assert isinstance(found, Choice)
    assert found.chosen == (0,)


def test_a_doubtful_small_motion_does_not_make_a_sure_large_one_doubtful():
    belief = certain(turn=40)
    ways = {way: 0.3 if way.value == "right" else share for way, share in belief.ways.items()}
    found = told("way turn", of_clip(replace(belief, ways=ways)))
    assert found.probability > 0.95


def test_cost_grows_no_faster_than_the_recording(monkeypatch):
    """Of four times as many frames and turns four times as many shares are looked up, no more."""
    monkeypatch.setattr(evaluating, "GRID", 128)
    share_at, looked_up = Happening.share_at, []

    def counted(happening, time_s):
        looked_up.append(np.size(time_s))
        return share_at(happening, time_s)

    monkeypatch.setattr(Happening, "share_at", counted)
    sums = []
    for turns in (20, 80):
        clip = of_track(turning([15.0, -15.0] * (turns // 2)))
        looked_up.clear()
        for line in ("first-time > amount cw 10.0:deg", "time-while > amount turn 5.0:deg"):
            told(line, clip)
        sums.append(sum(size for size in looked_up if size > 1))
    assert 3 < sums[1] / sums[0] < 5


def test_how_far_it_gets_is_the_same_at_every_moment():
    clip = of_track(turning([40.0, -38.0]))
    assert told("ever > peak turn 30.0:deg", clip).holds
    assert not told("ever > peak turn 60.0:deg", clip).holds


def test_every_slide_is_a_slip_and_a_turn_after_a_rest_is():
    events = (
        happened("touch", 10, 10),
        happened("turn", 12, 30, turn=20),
        happened("slide", 30, 50, right=8),
        happened("stick", 50, 70),
        happened("turn", 70, 90, turn=-15),
    )
    clip = of_track(track_of_events(events))
    slips = told("count slip-events", clip).amount.value
    assert slips == told("count slide-events", clip).amount.value + 1 == 2


@pytest.mark.parametrize(("middle", "is_sure"), [(30, False), (29, False), (20, True)])
def test_parts_of_one_motion_are_compared_with_doubt(middle, is_sure):
    clip = of_track(track_of_events((happened("touch", 0, 0), happened("turn", 10, 50, turn=80))))
    half = f"within until t {middle / 25}:s amount turn"
    line = f"> {half} within since t {middle / 25}:s amount turn"
    assert (told(line, clip).probability > 0.9) is is_sure
