"""Laws of rigid motions, and known motions found again between made pictures."""

import math
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.alignment.direct import Picture, Rigid, align
from tests.alignment.pictures import COLUMNS, ROWS, moved, texture, turned

RIGIDS = st.builds(Rigid, *[partial(st.floats, -s, s)() for s in (3.0, 50.0, 50.0)])
PLACES = st.tuples(st.floats(-80, 80), st.floats(-80, 80))
near = partial(pytest.approx, abs=1e-9)


def parts(motion):
    return motion.turn_rad, motion.right_px, motion.down_px


def there(motion, place):
    x, y = place
    cos, sin = math.cos(motion.turn_rad), math.sin(motion.turn_rad)
    return cos * x - sin * y + motion.right_px, sin * x + cos * y + motion.down_px


@given(RIGIDS, RIGIDS, PLACES)
def test_a_motion_after_another_moves_points_by_both(first, then, place):
    assert there(then.after(first), place) == near(there(then, there(first, place)), abs=1e-9)


@given(RIGIDS)
def test_the_inverse_takes_a_motion_back_from_either_side(motion):
    for both in (motion.less(motion), Rigid().less(motion).after(motion)):
        assert parts(both) == near((0.0, 0.0, 0.0), abs=1e-9)


@given(RIGIDS, PLACES)
def test_a_point_has_travelled_from_where_it_was_to_where_it_is(motion, place):
    x, y = there(motion, place)
    assert motion.travel(x, y) == near((x - place[0], y - place[1]), abs=1e-9)


def found(motion, *, before=None, change=lambda image: image, **how):
    first = texture() if before is None else before
    return align(Picture.of(first, 3), Picture.of(change(moved(first, motion)), 3), **how)


def off(aligned, motion):
    """Error of turn, degrees, and of shift, pixels."""
    error = aligned.motion.less(motion)
    return abs(math.degrees(error.turn_rad)), math.hypot(error.right_px, error.down_px)


@settings(max_examples=25, deadline=None)
@given(st.floats(-10, 10), st.floats(-4, 4), st.floats(-4, 4))
def test_known_turns_and_shifts_are_found_again(degrees, right, down):
    motion = turned(degrees, right, down)
    turn_deg, shift_px = off(found(motion), motion)
    assert (turn_deg < 0.2, shift_px < 0.1) == (True, True)


@pytest.mark.parametrize("change", [lambda a: 1.4 * a, lambda a: 0.6 * a - 30, lambda a: a + 25])
def test_gain_and_offset_do_not_matter(change):
    motion = turned(6.0, 2.0, -3.0)
    aligned = found(motion, change=change)
    turn_deg, shift_px = off(aligned, motion)
    assert (turn_deg < 0.2, shift_px < 0.1, aligned.correlation > 0.98) == (True, True, True)


def test_laid_the_other_way_round_the_motion_is_the_inverse():
    first = texture()
    later = moved(first, turned(7.0, 3.0, -2.0))
    there, back = (align(*map(Picture.of, pair)) for pair in ((first, later), (later, first)))
    turn_deg, shift_px = off(there, Rigid().less(back.motion))
    assert (turn_deg < 0.1, shift_px < 0.1) == (True, True)


def test_what_stands_still_while_the_object_turns_does_not_hold_the_fit_back():
    """A domed pad keeps a flat object's outline where it is, here broken so that it tells turns."""
    y, x = np.mgrid[:ROWS, :COLUMNS] - np.array([(ROWS - 1) / 2, (COLUMNS - 1) / 2])[:, None, None]
    ring = 40 * np.exp(-((np.hypot(x, y) - 36) ** 2) / 8) * (np.cos(5 * np.arctan2(y, x)) > 0)
    first, motion, ring = texture(radius_px=18), turned(5.0), ring.astype(np.float32)
    pair = (Picture.of(first + ring, 3), Picture.of(moved(first, motion) + ring, 3))
    plain, weighted = align(*pair), align(*pair, still_grey=3.6)
    assert off(weighted, motion)[0] < 0.6 * off(plain, motion)[0]


def noisy(deviation, seed):
    rng = np.random.default_rng(seed)
    return lambda image: image + rng.normal(0, deviation, image.shape).astype(np.float32)


def spread(aligned):
    """Deviations of turn (at half the picture's width), right and down, pixels."""
    return np.sqrt(np.diag(aligned.covariance)) * aligned.residual


def test_noise_widens_the_spread_and_lowers_the_correlation():
    levels = [found(turned(3.0, 1.0), change=noisy(grey, 0)) for grey in (0.5, 4.0, 16.0)]
    spreads = [spread(one) for one in levels]
    assert all((later > 2 * earlier).all() for earlier, later in pairwise(spreads))
    correlations = [one.correlation for one in levels]
    assert correlations == sorted(correlations, reverse=True)
    assert 0 <= correlations[-1] < correlations[0] <= 1


def test_an_edge_hides_how_far_it_went_along_itself():
    x = np.arange(COLUMNS) - (COLUMNS - 1) / 2
    edge = np.repeat((30 * np.tanh(x / 3))[None], ROWS, axis=0).astype(np.float32)
    aligned = align(Picture.of(noisy(0.3, 0)(edge)), Picture.of(noisy(0.3, 1)(edge)))
    _, across, along = spread(aligned)
    assert along > 10 * across


def test_a_flat_picture_has_not_moved():
    flat = Picture.of(np.full((ROWS, COLUMNS), 90.0, np.float32))
    aligned = align(flat, flat)
    assert parts(aligned.motion) == near((0.0, 0.0, 0.0), abs=1e-6)
    assert np.isfinite([*aligned.covariance.ravel(), aligned.correlation]).all()


@pytest.mark.parametrize("gain", [0.2, 0.4, 2.0, 4.0])
@pytest.mark.parametrize("motion", [Rigid(), turned(3, 2, -1)])
def test_an_imprint_that_deepens_or_fades_does_not_run_away(gain, motion):
    first = texture()
    later = (gain * moved(first, motion)).astype(np.float32)
    error = align(Picture.of(first, 3), Picture.of(later, 3)).motion.less(motion)
    assert np.degrees(abs(error.turn_rad)) < 0.2
    assert np.hypot(error.right_px, error.down_px) < 0.15
