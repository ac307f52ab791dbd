"""The path of an imprint is found roughly, in radii of the imprint, and the same way backwards."""

import cv2
import numpy as np
import pytest

from geotlm_lm.recordings.travel import main_way, travelled_path

ROWS, COLUMNS = 60, 80
PATTERN = cv2.GaussianBlur(np.random.default_rng(1).normal(0, 1, (240, 240)), (0, 0), 3)
PATTERN = (PATTERN + PATTERN[::-1, ::-1]).astype(np.float32)  # its middle is where it turns about
y, x = np.mgrid[:240, :240].astype(np.float32) - 119.5
BODY = PATTERN * np.exp(-(x**2 + y**2) / (2 * 12**2))


def imprints(poses):
    """Draw a rough blob at each pose: pixels to the right and down, degrees clockwise."""
    drawn = []
    for right, down, turn in poses:
        move = cv2.getRotationMatrix2D((119.5, 119.5), -turn, 1)
        move[:, 2] += right - 80, down - 90
        drawn.append(cv2.warpAffine(BODY, move, (COLUMNS, ROWS)))
    return np.stack(drawn)


def radius(images):
    """Return the radius of gyration of what is drawn, all frames together."""
    weight = np.square(images).mean(axis=0)
    weight /= weight.sum()
    down, right = np.mgrid[:ROWS, :COLUMNS]
    middle = (weight * right).sum(), (weight * down).sum()
    return np.sqrt((weight * ((right - middle[0]) ** 2 + (down - middle[1]) ** 2)).sum())


def way(poses):
    images = imprints(poses)
    found = travelled_path(images, np.ones(len(images), bool))[-1]
    return found * radius(images), np.degrees(found[2])


@pytest.mark.parametrize(("right", "down"), [(6, 0), (-6, 0), (0, 5), (4, -4)])
def test_a_slide_is_found_in_pixels(right, down):
    pixels, degrees = way([(right * s, down * s, 0) for s in np.linspace(0, 1, 13)])
    np.testing.assert_allclose(pixels[:2], (right, down), atol=0.5)
    assert abs(degrees) < 2


@pytest.mark.parametrize("turn", [20, -20])
def test_a_turn_is_found_in_degrees_clockwise_as_displayed(turn):
    pixels, degrees = way([(0, 0, turn * s) for s in np.linspace(0, 1, 13)])
    assert degrees == pytest.approx(turn, rel=0.1)
    assert np.abs(pixels[:2]).max() < 0.5


def test_played_backwards_the_path_runs_back():
    images = imprints([(3 * s, s, 25 * s) for s in np.linspace(0, 1, 10)])
    is_full = np.arange(10) > 1
    forwards = travelled_path(images, is_full)
    backwards = travelled_path(images[::-1], is_full[::-1])
    np.testing.assert_allclose(backwards, forwards[::-1] - forwards[-1], atol=1e-4)
    np.testing.assert_allclose(main_way(backwards), -main_way(forwards), atol=1e-4)


def test_an_imprint_that_only_grows_stays_in_place():
    still = imprints([(0, 0, 0)])[0]
    path = travelled_path(np.stack([still * s for s in (1, 1.2, 1.4)]), np.ones(3, bool))
    assert np.abs(path).max() < 0.01


def test_the_main_way_is_the_longest_and_not_the_last():
    path = np.zeros((6, 3))
    path[:, 2] = [0, -0.1, 0.4, 0.9, 0.9, 0.7]
    np.testing.assert_allclose(main_way(path), [0, 0, 1.0])


def test_a_step_out_of_or_into_full_contact_counts_as_resting():
    images = imprints([(2 * s, 0, 0) for s in range(5)])
    path = travelled_path(images, np.array([False, False, True, True, False]))
    assert not path[:3].any()
    assert path[3, 0] > 0
    np.testing.assert_array_equal(path[4], path[3])
