"""Where gradients lose the way the search finds it, and of two equal ways it takes the shorter."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.alignment.direct import Picture, align
from geotlm_lm.alignment.search import LOST_CORRELATION, align_or_search, search
from tests.alignment.pictures import COLUMNS, ROWS, moved, texture, turned


@pytest.mark.parametrize("motion", [turned(30.0), turned(-40, 5, -4), turned(8, 22, 12)])
def test_a_large_step_is_lost_from_rest_and_found_by_a_search(motion):
    first = texture(grain_px=2.0)
    before, after = Picture.of(first, 3), Picture.of(moved(first, motion), 3)
    assert align(before, after).correlation < LOST_CORRELATION
    aligned = align_or_search(before, after)
    error = aligned.motion.less(motion)
    assert np.degrees(abs(error.turn_rad)) < 0.2
    assert np.hypot(error.right_px, error.down_px) < 0.15
    assert aligned.correlation > 0.95


@pytest.mark.parametrize("share", [-0.4, -0.2, 0.2, 0.4])
def test_a_repeating_texture_is_found_the_short_way(share):
    period = 16.0
    y, x = np.mgrid[:ROWS, :COLUMNS]

    def mesh(right):
        waves = np.cos(2 * np.pi * (x - right) / period) + np.cos(2 * np.pi * y / period)
        return (20 * waves).astype(np.float32)

    before, after = Picture.of(mesh(0)), Picture.of(mesh(share * period))
    begun = search(before.image, after.image)
    aligned = align(before, after, begun)
    assert aligned.motion.right_px == pytest.approx(share * period, abs=0.2)
    assert (abs(aligned.motion.down_px) < 0.2, abs(aligned.motion.turn_rad) < 0.01) == (True, True)


def test_what_has_not_moved_is_found_where_it_is():
    still = Picture.of(texture()).image
    assert search(still, still) == turned(0.0)


@pytest.mark.parametrize(("share_left", "is_taken"), [(0.9, False), (0.7, False), (0.4, True)])
def test_a_farther_motion_has_to_fit_clearly_better(monkeypatch, share_left, is_taken):
    before, after = (Picture.of(texture(seed), 3) for seed in (1, 2))
    near = align(before, after)
    assert near.correlation < LOST_CORRELATION
    left = (share_left * (1 - near.correlation**2)) ** 0.5
    far = replace(near, motion=turned(0, 14, 0), residual=left * near.contrast)
    monkeypatch.setattr(
        sys.modules["geotlm_lm.alignment.search"],
        "align",
        lambda first, second, start=None: near if start is None else far,
    )
    assert align_or_search(before, after) is (far if is_taken else near)
