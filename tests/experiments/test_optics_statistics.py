"""Expected values are the numbers the images were made with, or closed forms of them."""

import cv2
import numpy as np
import pytest

from geotlm_lm.experiments.optics_statistics import (
    COLOURS,
    STATISTICS,
    camera_statistics,
    idle_statistics,
    pattern_statistics,
)

SIDE = 224
SIGMAS = (2.0, 1.24, 1.7)


def grey(level=100.0):
    return np.full((SIDE, SIDE, 3), level, np.float32)


def noise(seed, *shape):
    return np.random.default_rng(seed).standard_normal(shape).astype(np.float32)


def axis():
    return (np.arange(SIDE, dtype=np.float32) + 0.5) * 2 / SIDE - 1


def test_white_noise_is_measured_as_it_was_made():
    frames = grey() + noise(0, 4, SIDE, SIDE, 3) * np.float32(SIGMAS)
    found = camera_statistics(frames)
    # A Gaussian of 3 px takes 1.4 % of white noise along.
    assert [found[f"noise {c}"] for c in COLOURS] == pytest.approx(SIGMAS, rel=0.025)
    assert found["noise R-B"] == pytest.approx(0, abs=0.02)
    assert found["noise neighbour"] == pytest.approx(0, abs=0.04)
    assert found["drift"] < 0.02


def test_one_frame_says_nothing_of_noise():
    assert camera_statistics(grey()[None]) == {}


def test_noise_that_two_channels_share_is_told():
    own = noise(1, 4, SIDE, SIDE, 3)
    own[..., 2] = 0.6 * own[..., 0] + 0.8 * own[..., 2]
    assert camera_statistics(grey() + own)["noise R-B"] == pytest.approx(0.6, abs=0.02)


def test_noise_averaged_over_two_neighbours_is_correlated_by_half():
    own = noise(2, 4, SIDE, SIDE + 1, 3)
    frames = grey() + 2 * (own[:, :, 1:] + own[:, :, :-1])
    assert camera_statistics(frames)["noise neighbour"] == pytest.approx(0.5, abs=0.04)


def test_drift_is_a_level_that_changes_and_no_noise():
    frames = grey() + np.float32([0.0, 1.0, 0.0, 1.0])[:, None, None, None]
    found = camera_statistics(frames)
    assert found["drift"] == pytest.approx(np.sqrt(0.5), rel=1e-6)
    assert found["noise G"] == pytest.approx(0, abs=1e-4)


def test_a_pattern_is_what_two_noisy_images_share_specks_and_slopes_apart():
    slope = 60 * axis()[:, None, None]
    pattern = 0.8 * noise(3, SIDE, SIDE, 3)
    pattern[100:103, 100:103] += 60
    halves = [grey() + slope + pattern + 1.5 * noise(seed, SIDE, SIDE, 3) for seed in (4, 5)]
    found = pattern_statistics(*halves)
    assert [found[f"pattern {c}"] for c in COLOURS] == pytest.approx([0.8] * 3, rel=0.06)


def test_without_a_pattern_none_is_found():
    halves = [grey() + noise(seed, SIDE, SIDE, 3) for seed in (6, 7)]
    assert max(pattern_statistics(*halves).values()) < 0.1


def test_a_slanted_field_is_told_by_its_halves_and_leaves_no_remainder():
    field = grey() * (1 + 0.3 * axis()[None, :, None] - 0.1 * axis()[:, None, None])
    found = idle_statistics(field)
    assert found["level G"] == pytest.approx(100, rel=1e-5)
    # The mean of s over (0, 1) less that over (-1, 0) is 1.
    assert found["right G"] == pytest.approx(30, rel=1e-3)
    assert found["lower G"] == pytest.approx(-10, rel=1e-3)
    assert found["corners G"] == pytest.approx(100, rel=1e-3)
    assert found["remainder G"] < 1e-3


def test_dark_corners_are_a_share_of_the_middle_channel_by_channel():
    vignette = axis()[:, None] ** 2 * axis()[None, :] ** 2
    field = grey() * (1 - vignette[..., None] * np.float32([0.8, 0.4, 0.0]))
    found = idle_statistics(field)
    # The mean of s^2 over a corner's (0.75, 1) is 0.7708.
    expected = [100 * (1 - 0.7708**2 * share) for share in (0.8, 0.4, 0.0)]
    assert [found[f"corners {c}"] for c in COLOURS] == pytest.approx(expected, abs=0.1)


def test_what_no_polynomial_of_degree_four_follows_remains():
    waves = 3 * np.sin(np.pi * 10 * axis())[None, :, None]
    found = idle_statistics(grey() + cv2.merge([np.tile(waves[0, :, 0], (SIDE, 1))] * 3))
    # Averages over 4 px leave sinc(4 / 22.4) of a wave of 22.4 px; the polynomial takes 0.7 %.
    assert found["remainder B"] == pytest.approx(3 / np.sqrt(2) * np.sinc(4 / 22.4), rel=0.01)


def test_every_key_that_is_measured_has_a_title():
    found = idle_statistics(grey()) | camera_statistics(np.stack([grey()] * 2))
    found |= pattern_statistics(grey(), grey())
    assert found.keys() <= STATISTICS.keys()
