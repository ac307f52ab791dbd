"""Legs of a path: one for each way it goes, with its ends where the path bends."""

import numpy as np

from geotlm_lm.track.legs import Leg, Legs, Point

FPS, LEAST = 25.0, 2.5


def legs_of(path, noise=0.0):
    rng, finder, found = np.random.default_rng(0), Legs(LEAST), []
    for place, value in enumerate(np.asarray(path, float)):
        at = np.atleast_1d(value) + rng.normal(0, noise, np.size(value))
        found += finder.push(Point(place, place / FPS, at))
    return found + finder.finish()


def ramp(*stretches):
    """Return a path that goes so far in so many frames, one stretch after the other."""
    steps = [far / frames for far, frames in stretches for _ in range(frames)]
    return np.concatenate([[0.0], np.cumsum(steps)])


def ends_near(found, truth, frames=2):
    assert len(found) == len(truth)
    for leg, (begin, end) in zip(found, truth, strict=True):
        assert abs(leg.begin - begin) <= frames
        assert abs(leg.end - end) <= frames


def test_turn_rest_and_turn_back_are_two_legs_with_their_ends():
    path = ramp((0, 20), (40, 20), (0, 15), (-20, 15), (0, 20))
    ends_near(legs_of(path, noise=0.1), [(20, 40), (55, 70)])


def test_turning_back_without_a_rest_ends_a_leg_where_the_path_bends():
    ends_near(legs_of(ramp((0, 10), (30, 15), (-25, 15), (0, 15))), [(10, 25), (25, 40)])


def test_noise_and_creeping_are_no_legs():
    assert legs_of(np.zeros(100), noise=0.3) == []
    assert legs_of(ramp((4.0, 200))) == []


def test_a_path_in_the_plane_ends_a_leg_at_a_corner():
    along, across = ramp((0, 5), (20, 15), (0, 30)), ramp((0, 20), (20, 15), (0, 15))
    ends_near(legs_of(np.stack([along, across], axis=1)), [(5, 20), (20, 35)])


def test_the_same_path_gives_the_same_legs_wherever_it_starts():
    path = ramp((0, 12), (-15, 12), (0, 20))
    assert legs_of(path) == legs_of(path + 1000) == [Leg(12, 24)]
