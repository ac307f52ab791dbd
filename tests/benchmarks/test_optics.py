"""Expected values are the numbers the images were made with, or closed forms of them."""

import csv

import cv2
import numpy as np
import pytest

from geotlm_lm.benchmarks.optics import (
    ALIKE,
    AREA,
    COLOURS,
    GRADIENT,
    NOISE,
    OPTICS,
    STRENGTH,
    compared,
    imprint_statistics,
    noise_statistics,
    optics_rows,
    simulated_touch,
    touched_region,
)
from geotlm_lm.benchmarks.rendering import tables
from geotlm_lm.benchmarks.rows import Row, Run
from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.scene import Body, Path, Scene

SIDE = 224
PATH = Path((0.6,) * 4, (0.0,) * 4, (0.0,) * 4, (0.0,) * 4)
IDLE = np.full((SIDE, SIDE, 3), 100.0, np.float32)


def noise(seed, *shape):
    return np.random.default_rng(seed).standard_normal(shape).astype(np.float32)


def disc(radius, row=112, column=112):
    rows, columns = np.mgrid[:SIDE, :SIDE]
    return np.hypot(rows - row, columns - column) < radius


def test_white_noise_is_measured_as_it_was_made():
    sigmas = (2.0, 1.24, 1.7)
    found = noise_statistics(IDLE + noise(0, 4, SIDE, SIDE, 3) * np.float32(sigmas))
    # A Gaussian of 3 px takes 1.4 % of white noise along.
    assert [found[f"{NOISE}, {c}"] for c in COLOURS] == pytest.approx(sigmas, rel=0.025)


@pytest.mark.parametrize("frame", [IDLE + 2 * noise(0, SIDE, SIDE, 3), IDLE + 15])
def test_noise_and_a_brighter_lamp_are_no_imprint(frame):
    assert imprint_statistics(frame, IDLE) == {}


def test_a_region_is_found_where_it_is_rim_and_crumbs_apart():
    change = 0.2 * (disc(40) | disc(5, 30, 190)).astype(np.float32)
    change[:8] = 0.5
    found = touched_region(np.repeat(change[..., None], 3, axis=-1))
    # Smoothed by 2 px, a step of 0.2 stands above 0.06 up to 1 px outside.
    assert found.sum() == pytest.approx(np.pi * 41**2, rel=0.02)
    assert not found[:70].any()


def test_area_and_strength_of_a_known_change():
    frame = IDLE.copy()
    frame[disc(50)] += np.float32([40.0, -20.0, 30.0])
    found = imprint_statistics(frame, IDLE)
    # Smoothed by 2 px, a step of 0.31 RMS stands above 0.06 up to 1.75 px outside.
    assert found[AREA] == pytest.approx(100 * np.pi * 51.75**2 / SIDE**2, rel=0.01)
    assert [found[f"{STRENGTH}, {c}"] for c in COLOURS] == pytest.approx([40, 20, 30], rel=0.04)


def test_channels_are_as_correlated_as_they_were_made():
    fields = [cv2.GaussianBlur(noise(seed, SIDE, SIDE), (0, 0), 2.0) for seed in (1, 2)]
    first, second = (field / field.std() for field in fields)
    change = np.stack([first, first, -0.79 * first + np.sqrt(1 - 0.79**2) * second])
    found = imprint_statistics(IDLE + 40 * np.moveaxis(change, 0, -1) * disc(70)[..., None], IDLE)
    # The weakest pixels fall out of the region: measured to shift this by up to 0.05.
    assert found[ALIKE] == pytest.approx(-0.79, abs=0.1)


def test_the_gradient_of_a_roof_is_its_slope():
    rise = np.clip(45 - np.abs(np.arange(SIDE) - 112), 0, None).astype(np.float32)
    roof = np.zeros((SIDE, SIDE, 3), np.float32)
    roof[20:204] = 2 * rise[:, None]
    assert imprint_statistics(IDLE + roof, IDLE)[f"{GRADIENT}, B"] == pytest.approx(2, rel=0.02)


@pytest.mark.parametrize(("middle", "outside"), [(5.0, 0.0), (-1.0, 2.0), (12.0, 3.0)])
def test_a_median_is_outside_by_its_distance_from_the_spread(middle, outside):
    found = compared("noise", "grey", [list(range(11))], [middle - 20, middle, middle + 20])
    assert found.error == outside


def test_shares_count_what_is_inside_the_other_spread():
    found = compared("x", "1", [[0.0, 1.0], [1.0, 8.0, 8.0, 9.0]], [0.5, 1.0, 2.0, 30.0])
    assert found.detail["real"][::2] == [0, 9]
    assert found.detail["covered"] == 0.75  # inside 0.5 to 30: half of the first, all of the second


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder of one still and three recordings with noise of known size."""
    root = tmp_path_factory.mktemp("real")
    touch = simulated_touch(Scene(Body("ball_medium"), PATH, Motion.STILL), 0)
    still = root / "calibration" / "unit"
    still.mkdir(parents=True)
    for name, image in (("background", touch.idle), ("ball", touch.touched[0])):
        cv2.imwrite(str(still / f"{name}.png"), image.astype(np.uint8)[..., ::-1])
    (root / "physiclear").mkdir()
    rows = [["clip", "fps", "contact_start", "contact_end"]]
    for number in range(3):
        frames = touch.idle + np.random.default_rng(number).normal(0, 1.5, (26, SIDE, SIDE, 3))
        frames[20:24] += touch.touched[0] - touch.idle
        np.save(root / "physiclear" / f"{number}.npy", frames.clip(0, 255).round().astype(np.uint8))
        rows.append([f"{number}.npy", "25.0", "20", "23"])
    with (root / "physiclear" / "clips.csv").open("w", newline="") as stream:
        csv.writer(stream).writerows(rows)
    return root


def test_one_row_per_statistic_that_both_sides_have(folder):
    rows = [Row.from_dict(one.to_dict()) for one in optics_rows(Run(is_quick=True, real=folder))]
    found = {row.case: row for row in rows}
    # Rounding to whole grey levels adds a twelfth to the variance.
    expected = np.sqrt(1.5**2 + 1 / 12)
    assert found["noise between idle frames, G"].detail["real"][1] == pytest.approx(
        expected, rel=0.03
    )
    assert {AREA, ALIKE, f"{GRADIENT}, B"} < set(found)
    (text,) = tables(OPTICS, rows)
    assert text.count("\n") == 1 + len(rows)
