"""A condition is read once and judged at every frame, by the frames up to it alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geotlm_lm.answering.monitor import Condition, Monitor, condition_of
from geotlm_lm.core.errors import UnreadableClip, Unsure, UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.twist import Component, Twist
from geotlm_lm.query.evaluate import Context, Evidence
from geotlm_lm.query.lines import read
from geotlm_lm.query.measures import net
from geotlm_lm.query.program import Quantity, filled
from geotlm_lm.query.worlds import with_own_motion, worlds_of_track
from geotlm_lm.track.summed import belief_of_track
from geotlm_lm.track.tracker import Tracker
from tests.track.recordings import there_and_back

CLIP = there_and_back()
CAMERA = FrameSpec()


def condition(line, *numbers):
    quantities = [Quantity(value, unit) for value, unit in numbers]
    holds = filled(read(line), quantities).answers[0]
    return Condition(line, holds, CAMERA, 1.0, line)


def monitor(line, *numbers, **options):
    options = {"fps": CLIP.fps} | options
    return Monitor(Tracker(idle=CLIP.frames[0]), condition(line, *numbers), **options)


def verdicts(watching, clip=CLIP, own=None):
    return [
        watching.push(frame, place / clip.fps, None if own is None else own(place))
        for place, frame in enumerate(clip.frames)
    ]


def probabilities(seen):
    return [each.probability for each in seen]


TURNED = "> amount cw #1", (4.0, "deg")


def test_a_verdict_rests_on_nothing_that_comes_later():
    whole = verdicts(monitor(*TURNED))
    for count in (12, len(CLIP) // 2, len(CLIP) - 3):
        part = verdicts(monitor(*TURNED), CLIP.select(range(count)))
        assert probabilities(part) == probabilities(whole[:count])


def test_what_has_turned_far_enough_holds_from_then_on_and_is_new_once():
    seen = verdicts(monitor("> path cw #1", (4.0, "deg")))
    holds = [each.holds for each in seen]
    first = holds.index(True)
    assert 0 < first < len(holds) - 1
    assert all(holds[first:])
    assert [each.is_new for each in seen].index(True) == first
    assert sum(each.is_new for each in seen) == 1
    assert seen[first].is_relative
    assert "degrees" in seen[first].text


def test_a_look_back_sees_where_it_held_no_later_than_while_it_was_watched():
    watching = monitor("> path cw #1", (4.0, "deg"))
    assert watching.look_back() is None
    live = next(each for each in verdicts(watching) if each.is_new)
    held = watching.look_back()
    assert held.holds
    assert 0 < held.number <= live.number
    assert held.time_s == held.number / CLIP.fps
    fresh = Monitor(watching.tracker, condition("> path cw #1", (400.0, "deg")), fps=CLIP.fps)
    assert fresh.look_back() is None


def test_nothing_can_be_told_of_what_was_not_seen_yet():
    seen = verdicts(monitor(*TURNED, since="begin"))
    assert set(probabilities(seen)) == {None}
    assert not any(each.holds for each in seen)


def test_a_condition_has_to_hold_for_as_long_as_is_wanted():
    plain, lasting = (
        verdicts(monitor("> path cw #1", (4.0, "deg"), lasting_s=lasting)) for lasting in (0, 0.2)
    )
    at = [[each.holds for each in seen].index(True) for seen in (plain, lasting)]
    assert at[1] - at[0] == round(0.2 * CLIP.fps)


def test_what_is_between_sure_and_unsure_stays_as_it_was():
    watching = monitor(*TURNED)
    held = []
    for place, chance in enumerate((0.9, 0.96, 0.7, 0.51, 0.49, 0.7, None, 0.95)):
        watching._settle(chance, place)
        held.append(watching.holds)
    assert held == [False, True, True, True, False, False, False, True]


def test_counted_from_where_it_last_held_it_holds_again():
    once = verdicts(monitor("> path cw #1", (2.5, "deg")))
    again = verdicts(monitor("> path cw #1", (2.5, "deg"), since="last"))
    assert sum(each.is_new for each in once) == 1
    assert sum(each.is_new for each in again) > 1


def test_what_goes_on_is_new_once_though_it_is_counted_from_where_it_last_held():
    seen = verdicts(monitor("touch", since="last"))
    assert sum(each.holds for each in seen) > 5
    assert sum(each.is_new for each in seen) == 1


def test_a_recording_is_opened_when_it_is_iterated_and_closed_when_the_loop_is_left(tmp_path):
    np.savez(tmp_path / "clip.npz", frames=CLIP.frames, fps=CLIP.fps)
    watching = monitor("> path cw #1", (4.0, "deg"), source=tmp_path / "clip.npz")
    (first,) = list(watching)
    pushed = next(each for each in verdicts(monitor("> path cw #1", (4.0, "deg"))) if each.is_new)
    assert (first.number, first.probability) == (pushed.number, pushed.probability)
    unopened = monitor(*TURNED, source=tmp_path / "nowhere.npz")
    with pytest.raises(UnreadableClip):
        next(iter(unopened))
    with pytest.raises(UsageError, match="was given no source"):
        next(iter(monitor(*TURNED)))


def test_counted_from_its_beginning_nothing_before_matters():
    whole = monitor("> path turn #1", (4.0, "deg"))
    late = monitor("> path turn #1", (4.0, "deg"), since="begin")
    for place, frame in enumerate(CLIP.frames):
        verdict, other = (each.push(frame, place / CLIP.fps) for each in (whole, late))
        if place == len(CLIP) - 4:
            late.begin()
    assert verdict.holds
    assert not other.holds


def test_a_sensor_that_turns_with_what_it_holds_tells_its_turn_in_the_world():
    """The clip turns there and back; the sensor turns by two degrees a frame all the time."""
    watching = monitor("> net cw #1", (60.0, "deg"))
    seen = verdicts(watching, own=lambda place: Twist(turn_deg=2.0))
    assert not any(each.is_relative for each in seen)
    assert seen[-1].holds
    plain = verdicts(monitor("> net cw #1", (60.0, "deg")))
    assert plain[-1].probability == 0
    contact = monitor("> net cw #1", (60.0, "deg"), whose="contact")
    assert verdicts(contact, own=lambda place: Twist(turn_deg=2.0))[-1].probability == 0


def test_one_frame_without_its_own_motion_makes_all_relative():
    seen = verdicts(monitor(*TURNED), own=lambda place: None if place == 5 else Twist(2.0))
    assert [each.is_relative for each in seen[:5]] == [False] * 5
    assert all(each.is_relative for each in seen[5:])


def _worlds():
    tracker = Tracker(idle=CLIP.frames[0])
    for place, frame in enumerate(CLIP.frames):
        tracker.feed(frame, place / CLIP.fps)
    from geotlm_lm.answering.monitor import _AT_REST

    track = tracker.now()
    return worlds_of_track(track, belief_of_track(track, _AT_REST)), track


WORLDS, TRACK = _worlds()


@given(st.lists(st.floats(-5, 5), min_size=len(TRACK), max_size=len(TRACK)))
def test_motion_in_the_world_is_that_of_the_sensor_and_that_relative_to_it(steps):
    turns = np.zeros((len(TRACK), 4))
    turns[:, 0] = steps
    moved = with_own_motion(WORLDS, TRACK.times_s, turns)
    first, last = WORLDS.contacts[0][0], WORLDS.contacts[-1][1]
    touched = (TRACK.times_s > first) & (TRACK.times_s <= last)
    before, after = (
        net(Context((Evidence(worlds),), CAMERA), Component.TURN)[0][..., 0]
        for worlds in (WORLDS, moved)
    )
    np.testing.assert_allclose(after - before, turns[touched, 0].sum(), atol=1e-6)


def test_a_sensor_at_rest_changes_nothing():
    still = with_own_motion(WORLDS, TRACK.times_s, np.zeros((len(TRACK), 4)))
    assert still.happenings == WORLDS.happenings


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("it has turned 30 degrees clockwise", "> amount cw #1"),
        ("it has turned 90 degrees clockwise", "> amount cw #1"),
        ("it slips", "slide"),
        ("contact is lost", "happens none-events"),
    ],
)
def test_a_condition_is_read_as_what_is_to_be_reached(answerer, text, line):
    understood = answerer.condition(text)
    assert understood.holds.word == line.split()[0]
    assert understood.probability >= 0.7
    assert understood.restated


def test_the_contrary_is_waited_for_where_something_is_to_stay_so(answerer):
    slips = answerer.condition("it slips")
    stays = answerer.condition("it does not slip", is_negated=True)
    assert stays.holds == slips.holds
    assert answerer.condition("it slips", is_negated=True).holds.word == "not"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("how far", "expected something that holds or does not"),
        ("it slips by more than 0.5 mm", "can never be told: I need the size of a pixel"),
        ("the force exceeds 5 N", "can never be told: I "),
        ("hello there", "expected something that holds|not surely understood"),
        ("", "The question is empty"),
    ],
)
def test_a_condition_that_cannot_be_waited_for_is_refused(answerer, text, why):
    with pytest.raises(UsageError, match=why):
        condition_of(answerer.bundle, text, CAMERA, is_negated=False)


def test_what_is_not_surely_understood_is_refused_with_its_likeliest_reading(answerer, monkeypatch):
    words = answerer.condition("it slips").restated
    monkeypatch.setattr("geotlm_lm.answering.monitor.READ", 1.1)
    with pytest.raises(Unsure, match="the likeliest reading") as refused:
        answerer.condition("it slips")
    assert refused.value.guess == words


@pytest.mark.parametrize(
    ("line", "is_of_depth"),
    [("> amount cw #1", False), ("slide", False), ("happens none-events", False)]
    + [("> amount in #1", True), ("not move", True), ("happens press-events", True)],
)
def test_the_model_is_asked_only_where_depth_is(line, is_of_depth):
    assert condition(line, (4.0, "deg")).is_of_depth == is_of_depth


@pytest.mark.parametrize("options", [{"sure": 0.3}, {"sure": 1.0}, {"lasting_s": -1.0}])
def test_an_option_outside_its_range_is_refused(options):
    with pytest.raises(UsageError, match="was wanted, expected"):
        monitor(*TURNED, **options)
