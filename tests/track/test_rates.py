"""How fast it goes around each frame: closed forms, and the spans of amounts told elsewhere."""

import numpy as np
import pytest

from geotlm_lm.core.twist import Component
from geotlm_lm.track.amounts import amount_of
from tests.track.tracks import FPS, moving_track

COUNT = 40


def steps_of(turn=0.0, right=0.0, down=0.0, inward=0.0):
    return np.tile([turn, right, down, inward], (COUNT, 1))


def test_what_moves_evenly_has_one_rate():
    rates, _ = moving_track(steps_of(0.6, -0.4, 0.2, 0.01), ()).rates()
    assert rates == pytest.approx(FPS * steps_of(0.6, -0.4, 0.2, 0.01))


def test_a_speed_is_the_length_of_the_rates():
    track = moving_track(steps_of(turn=-0.6, right=0.3, down=0.4), ())
    assert track.speed(Component.SLIDE) == pytest.approx(np.full(COUNT, 0.5 * FPS))
    assert track.speed(Component.TURN) == pytest.approx(np.full(COUNT, -0.6 * FPS))


def test_a_deviation_is_that_of_the_amount_in_its_time():
    track = moving_track(steps_of(turn=0.6), ())
    first, last = 18, 22  # a tenth of a second on both sides of frame 20, in whole frames
    steps = slice(first + 1, last + 1)
    way, own = track.twists[steps].sum(axis=0), track.covariances[steps].sum(axis=0)
    wanted = amount_of(Component.TURN, way, own).deviation / ((last - first) / FPS)
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
