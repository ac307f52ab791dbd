"""Turns over frames that are kept: what steps miss is found, what light does is not."""

import cv2
import numpy as np
import pytest

from geotlm_lm.track.angles import KeyAngles, detail_of
from geotlm_lm.track.keyframes import Step

SHAPE = (120, 160, 3)
GEL = np.full(SHAPE, 110, np.uint8)


def turned(picture, degrees):
    rows, columns = picture.shape[:2]
    way = cv2.getRotationMatrix2D(((columns - 1) / 2, (rows - 1) / 2), -degrees, 1)
    return cv2.warpAffine(picture, way, (columns, rows))


def print_of(seed):
    """A random relief within a disc, float32, (rows, columns)."""
    field = np.random.default_rng(seed).normal(size=SHAPE[:2]).astype(np.float32)
    field = cv2.GaussianBlur(field, (0, 0), 3.0)
    y, x = np.indices(SHAPE[:2])
    inside = np.hypot(x - 79.5, y - 59.5) < 48
    return np.where(inside, 40 * field / field.std(), 0).astype(np.float32)


def lit(height, lamp_deg=0.0):
    """The frame of a print under three coloured lamps that stand around it, turned."""
    right, down = np.gradient(height, axis=1), np.gradient(height, axis=0)
    angles = np.radians(lamp_deg + np.array([0, 120, 240]))
    shade = [3 * (np.cos(a) * right + np.sin(a) * down) for a in angles]
    return np.clip(GEL + np.stack(shade, axis=-1), 0, 255).astype(np.uint8)


def followed(frames, steps_deg, apart_s=0.04):
    """What the turn comes to, given what the steps tell."""
    angles, total = KeyAngles(), 0.0
    for k, (frame, step_deg) in enumerate(zip(frames, steps_deg, strict=True)):
        step = Step(np.array([step_deg, 0.0, 0.0]), np.eye(3) * 0.01, 0.95)
        turn = angles.follow(step, k * apart_s, 20.0, lambda frame=frame: detail_of(frame, GEL))
        total += step_deg + (0.0 if turn is None else turn.beyond_deg)
    return total


@pytest.mark.parametrize("share", [0.8, 1.0, 1.2])
def test_a_turn_that_steps_tell_short_or_long_comes_out_whole(share):
    print_, every_deg = print_of(0), 2.0
    frames = [lit(turned(print_, every_deg * k)) for k in range(49)]
    steps = [0.0, *[share * every_deg] * 48]
    assert followed(frames, steps) == pytest.approx(96.0, abs=3.0)


def test_a_turn_that_steps_lose_on_the_way_is_found():
    print_, mark = print_of(1), np.zeros(SHAPE[:2], np.float32)
    mark[20:34, 14:34] = np.random.default_rng(2).normal(scale=15, size=(14, 20))
    frames = [lit(turned(print_, min(2.5 * k, 80.0)) + mark) for k in range(48)]
    assert followed(frames, [2.5 if 0 < k <= 16 else 0.0 for k in range(48)]) == pytest.approx(
        80.0, abs=4.0
    )


def test_what_is_held_under_noise_and_a_lamp_that_dims_does_not_turn():
    rng, still = np.random.default_rng(3), lit(print_of(4)).astype(np.float32)
    frames = [
        np.clip((1 - 0.003 * k) * (still - GEL) + GEL + rng.normal(scale=2, size=SHAPE), 0, 255)
        for k in range(60)
    ]
    assert followed([frame.astype(np.uint8) for frame in frames], [0.0] * 60) == 0.0


def test_what_is_compared_is_the_same_whichever_colours_its_light_comes_from():
    frame = lit(print_of(5))
    first, second = detail_of(frame, GEL), detail_of(frame[..., ::-1].copy(), GEL)
    np.testing.assert_allclose(first, second, atol=1e-3)
