"""Events, their legs and their rates: closed forms of paths that are known."""

import numpy as np
import pytest

from geotlm_lm.core.twist import Component
from geotlm_lm.track.events import MOST_SHARE, EventFinder, EventKind, Moment, amount_of
from geotlm_lm.track.legs import Legs, Point
from tests.track.tracks import FPS, moving_track

FRAMES, RADIUS_PX, COUNT, FLOOR = 60, 50.0, 40, 0.4


def events_of(turn_deg, right_px, frames=20, step_variance=1e-3):
    """Events of a contact that turns and slides evenly in its middle."""
    finder, events = EventFinder(), []
    for k in range(FRAMES):
        done = min(max(k - 20, 0) / frames, 1.0)
        way = done * np.array([turn_deg, right_px, 0.0, 0.0])
        doubt = k * step_variance * np.eye(4)
        events += finder.push(Moment(k, k, k / 25, 1.0, True, way, doubt, RADIUS_PX))
    return events + finder.finish()


def kinds(*args, **more):
    return {event.kind for event in events_of(*args, **more)}


@pytest.mark.parametrize(
    ("turn_deg", "right_px", "frames", "is_event"),
    [
        (4.0, 0.0, 20, True),
        (4.0, 20.0, 20, False),  # as a path a sixth of the slide: it may be read of that
        (20.0, 20.0, 20, True),
        (0.9, 0.0, 20, True),  # 0.8 pixels at the contact's radius
        (0.4, 0.0, 20, False),
    ],
)
def test_a_turn_is_event_if_neither_noise_nor_a_slide_explains_it(
    turn_deg, right_px, frames, is_event
):
    assert (EventKind.TURN in kinds(turn_deg, right_px, frames)) == is_event


@pytest.mark.parametrize("sign", [1, -1])
def test_a_turn_is_event_after_a_slide_some_of_which_is_read_of_it(sign):
    finder, events, times = EventFinder(), [], [0, 10, 30, 33, 48, 80]
    turns = sign * np.array([0.0, 0.0, 11.0, 11.0, 26.0, 26.0])
    rights = [0.0, 0.0, -30.0, -30.0, -32.0, -32.0]
    for k in range(80):
        way = np.array([np.interp(k, times, turns), np.interp(k, times, rights), 0.0, 0.0])
        doubt = k * 1e-3 * np.eye(4)
        events += finder.push(Moment(k, k, k / 25, 1.0, True, way, doubt, RADIUS_PX / 2))
    turned = [each for each in events + finder.finish() if each.kind is EventKind.TURN]
    assert [each.amount.mean for each in turned] == pytest.approx([15.0 * sign], abs=1.0)
    assert 32 <= turned[0].begin < turned[0].end <= 49


@pytest.mark.parametrize(("right_px", "is_event"), [(0.9, False), (4.0, True)])
def test_a_slide_is_event_if_no_press_explains_it(right_px, is_event):
    finder, events = EventFinder(), []
    for k in range(FRAMES):
        done = min(max(k - 20, 0) / 20, 1.0)
        way = done * np.array([0.0, right_px, 0.0, 0.4])
        events += finder.push(Moment(k, k, k / 25, 1.0, True, way, np.zeros((4, 4)), RADIUS_PX))
    assert (EventKind.SLIDE in {each.kind for each in events + finder.finish()}) == is_event


def test_what_is_event_depends_on_the_noise_and_no_amount():
    variances = [1e-4, 1e-2, 1e-1, 1.0]
    are = [EventKind.SLIDE in kinds(0.0, 0.9, step_variance=one) for one in variances]
    assert are == [True, True, False, False]
    (slide,) = (one for one in events_of(0.0, 0.9) if one.kind is EventKind.SLIDE)
    assert slide.amount.is_clear


def test_what_is_held_sticks_though_its_last_step_is_measured_wrong():
    finder, events = EventFinder(), []
    for k in range(FRAMES):
        way = np.array([0.0, 0.6, 0.0, 0.0]) * (k == FRAMES - 1)
        events += finder.push(Moment(k, k, k / 25, 1.0, True, way, np.zeros((4, 4)), RADIUS_PX))
    kinds = [event.kind for event in events + finder.finish()]
    assert kinds == [EventKind.TOUCH, EventKind.STICK]


def test_what_is_held_sticks_until_it_is_lifted():
    finder, events = EventFinder(), []
    for k in range(FRAMES):
        way = np.array([0.0, 0.0, 0.0, np.interp(k, [0, 5, 40, 45], [0.0, 1.0, 1.0, 0.0])])
        moment = Moment(k, k, k / 25, 1.0, k <= 45, way, np.zeros((4, 4)), RADIUS_PX)
        events += finder.push(moment)
    kinds = [event.kind for event in events + finder.finish()]
    assert kinds == [EventKind.TOUCH, EventKind.PRESS, EventKind.STICK, EventKind.RELEASE]


def legs_of(path, noise=0.0):
    rng, finder, legs = np.random.default_rng(0), Legs(), []
    for place, value in enumerate(np.asarray(path, float)):
        at = np.atleast_1d(value) + rng.normal(0, noise, np.size(value))
        legs += finder.push(Point(place, place / FPS, at, floor=FLOOR))
    return legs + finder.finish()


def ramp(*stretches):
    """Return a path that goes so far in so many frames, one stretch after the other."""
    steps = [far / frames for far, frames in stretches for _ in range(frames)]
    return np.concatenate([[0.0], np.cumsum(steps)])


def ends_near(legs, truth, frames=2):
    assert len(legs) == len(truth)
    for leg, (begin, end) in zip(legs, truth, strict=True):
        assert abs(leg.begin - begin) <= frames
        assert abs(leg.end - end) <= frames


def test_turn_rest_and_turn_back_are_two_legs_with_their_ends():
    path = ramp((0, 20), (40, 20), (0, 15), (-20, 15), (0, 20))
    ends_near(legs_of(path, noise=0.1), [(20, 40), (55, 70)])


def test_turning_back_without_a_rest_ends_a_leg_where_the_path_bends():
    ends_near(legs_of(ramp((0, 10), (30, 15), (-25, 15), (0, 15))), [(10, 25), (25, 40)])


def test_noise_is_no_leg():
    assert legs_of(np.zeros(100), noise=0.2) == []


def test_what_creeps_is_one_leg_from_where_it_is_no_noise():
    (leg,) = legs_of(ramp((0, 25), (4.0, 200), (0, 25)))
    assert (abs(leg.begin - 25) <= 10, abs(leg.end - 225) <= 10) == (True, True)


def test_a_path_in_the_plane_ends_a_leg_at_a_corner():
    along, across = ramp((0, 5), (20, 15), (0, 30)), ramp((0, 20), (20, 15), (0, 15))
    ends_near(legs_of(np.stack([along, across], axis=1)), [(5, 20), (20, 35)])


def test_the_same_path_gives_the_same_legs_wherever_it_starts():
    path = ramp((0, 12), (-15, 12), (0, 20))
    assert legs_of(path) == legs_of(path + 1000)
    ends_near(legs_of(path), [(12, 24)], frames=0)


def steps_of(turn=0.0, right=0.0, down=0.0, inward=0.0):
    return np.tile([turn, right, down, inward], (COUNT, 1))


def test_what_moves_evenly_has_one_rate():
    rates, _ = moving_track(steps_of(0.6, -0.4, 0.2, 0.01), ()).rates()
    assert rates == pytest.approx(FPS * steps_of(0.6, -0.4, 0.2, 0.01))


def test_a_deviation_is_that_of_the_amount_in_its_time():
    track = moving_track(steps_of(turn=0.6), ())
    first, last = 18, 22  # a tenth of a second on both sides of frame 20, in whole frames
    steps = slice(first + 1, last + 1)
    way, own = track.twists[steps].sum(axis=0), track.covariances[steps].sum(axis=0)
    wanted = amount_of(Component.TURN, way, own, 50.0, MOST_SHARE).deviation / (
        (last - first) / FPS
    )
    assert track.rates()[1][20, 0] == pytest.approx(wanted)


def test_without_contact_nothing_moves_and_that_is_sure():
    contact = np.repeat([0.01, 0.99], COUNT // 2)
    track = moving_track(steps_of() * 0, (), contact=contact)
    rates, deviations = track.rates()
    assert not rates.any()
    assert not deviations[: COUNT // 2 - 3].any()
    assert (deviations[COUNT // 2 :] > 0).all()


def test_a_single_frame_has_no_rate():
    rates, deviations = moving_track(steps_of(0.6)[:1], ()).rates()
    assert (rates.tolist(), deviations.tolist()) == ([[0.0] * 4], [[0.0] * 4])
