"""The rate of a recording by the times of its frames, and what a changing size is."""

import numpy as np
import pytest

from geotlm_lm.recordings.policy import rate_by, uneven_times_s


@pytest.mark.parametrize(
    ("times_ms", "header_fps"),
    [
        (np.delete(np.arange(50) * 40.0, [7, 20]), 25.0),  # two frames were dropped
        *((np.rint(np.arange(100) * 1000 / fps), fps) for fps in (30.0, 60.0, 240.0, 400.0)),
        ([0.0] * 9, 25.0),
    ],
)
def test_a_headers_rate_is_kept_where_the_times_are_rounded_or_missing(times_ms, header_fps):
    assert rate_by(times_ms, header_fps) == (header_fps, ())


def test_a_rate_that_changes_is_none():
    times_ms = np.cumsum(np.r_[np.full(25, 40.0), np.full(25, 200.0)])
    fps, notes = rate_by(times_ms, 8.3)
    assert fps is None
    assert "40 to 200 ms" in notes[0]
    assert notes[0].endswith("give that of the frames used by fps.")


def test_uneven_times_are_kept_from_the_first_frame_on():
    times_ms = 500 + np.cumsum([0, 40, 40, 200, 40])
    assert uneven_times_s(times_ms, None) == pytest.approx((0, 0.04, 0.08, 0.28, 0.32))
    assert uneven_times_s(times_ms, 25.0) != ()


def test_even_times_and_none_are_left_to_the_rate():
    assert uneven_times_s(np.rint(np.arange(100) * 1000 / 30), 30.0) == ()
    assert uneven_times_s([0.0] * 9, 25.0) == ()
    assert uneven_times_s([0.0, 40.0, 20.0, 60.0], 25.0) == ()
