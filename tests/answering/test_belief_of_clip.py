"""What is believed of a clip by alignment: sign, amount and doubt of what was moved."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from geotlm_lm.answering import Answerer
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component

ROWS, COLUMNS = 240, 320


def moving(turn=0.0, right=0.0, down=0.0):
    """A blotchy imprint in four frames which turns about the middle and slides, all told in all."""
    rng = np.random.default_rng(0)
    blotches = cv2.GaussianBlur(rng.normal(0, 600, (ROWS, COLUMNS)), (0, 0), 5)
    y, x = np.mgrid[:ROWS, :COLUMNS]
    blotches *= np.exp(-((x - 160) ** 2 + (y - 120) ** 2) / (2 * 45.0**2))
    frames = []
    for part in np.linspace(0, 1, 4):
        way = cv2.getRotationMatrix2D((160, 120), -turn * part, 1.0)
        way[:, 2] += np.array([right, down]) * part
        frames.append(100 + cv2.warpAffine(blotches, way, (COLUMNS, ROWS)))
    images = np.repeat(np.clip(frames, 0, 255).astype(np.uint8)[..., None], 3, axis=-1)
    return Clip(images, background=np.full((ROWS, COLUMNS, 3), 100, np.uint8))


def believed_of(bundle, clip):
    return Answerer(bundle).encode(clip).belief


@pytest.mark.parametrize("turn", [-8.0, 5.0])
@pytest.mark.parametrize(("right", "down"), [(10.0, -4.0), (-3.0, 12.0)])
def test_every_component_of_a_mixed_motion_is_found(bundle, turn, right, down):
    belief = believed_of(bundle, moving(turn, right, down))
    assert belief.mean.turn_deg == pytest.approx(turn, abs=0.7)
    assert belief.mean.right_px == pytest.approx(right * 224 / 320, abs=0.7)
    assert belief.mean.down_px == pytest.approx(down * 224 / 240, abs=0.7)
    assert belief.counts(Component.TURN) > 0.95
    assert belief.counts(Component.SLIDE) > 0.95
    assert sum(belief.ways.values()) <= len(Component)


def test_what_rests_is_not_believed_to_move(bundle):
    belief = believed_of(bundle, moving())
    assert all(belief.counts(one) < 0.2 for one in Component)
    assert belief.contact > 0.9


def test_a_clip_played_backwards_is_believed_reversed(bundle):
    clip = moving(6.0, 9.0)
    back = believed_of(bundle, replace(clip, frames=clip.frames[::-1]))
    there = believed_of(bundle, clip).reversed()
    assert back.way(Component.TURN) is there.way(Component.TURN) is Motion.COUNTERCLOCKWISE
    assert back.way(Component.SLIDE) is there.way(Component.SLIDE) is Motion.LEFT
