"""Expected values are the numbers the imprints were made with, or closed forms of them."""

import cv2
import numpy as np
import pytest

from geotlm_lm.experiments.optics_imprint import (
    ASPECT,
    contact_statistics,
    depth_statistics,
    touched_region,
)
from geotlm_lm.experiments.optics_statistics import COLOURS, STATISTICS

SIDE = 224
IDLE = np.full((SIDE, SIDE, 3), 100.0, np.float32)


def noise(seed, *shape):
    return np.random.default_rng(seed).standard_normal(shape).astype(np.float32)


def disc(radius=50, row=112, column=112):
    rows, columns = np.mgrid[:SIDE, :SIDE]
    return np.hypot(rows - row, columns - column) < radius


def bump(lights, depth_gain=(0.0, 0.0, 0.0), column=112):
    """Return the picture of a Gaussian dent 1 mm deep under lights (3, 2) in px per unit slope."""
    rows, columns = np.mgrid[:SIDE, :SIDE].astype(np.float32)
    x, y = columns - column, (rows - 112) * ASPECT
    dent = np.exp(-(x**2 + y**2) / (2 * 18**2))
    slope = np.stack([x, y], axis=-1) / 18**2 * dent[..., None]
    shade = slope @ np.asarray(lights, np.float32).T + dent[..., None] * np.float32(depth_gain)
    return IDLE * (1 + shade)


def bar(blur_px):
    """Return a bright bar, 60 px wide, with edges blurred by a Gaussian."""
    image = np.zeros((SIDE, SIDE, 3), np.float32)
    image[62:162, 82:142] = 80
    return IDLE + (cv2.GaussianBlur(image, (0, 0), blur_px) if blur_px else image)


def test_an_untouched_gel_has_no_imprint():
    assert contact_statistics(IDLE + 2 * noise(0, SIDE, SIDE, 3), IDLE) == {}


def test_a_brighter_lamp_is_no_imprint():
    assert contact_statistics(IDLE + 15, IDLE) == {}


def test_a_region_is_found_where_it_is_rim_and_crumbs_apart():
    change = 0.2 * (disc(40) | disc(5, 30, 190)).astype(np.float32)
    change[:8] = 0.5
    found = touched_region(np.repeat(change[..., None], 3, axis=-1))
    assert found[112, 112]
    assert not found[:70].any()
    # Smoothed by 2 px, a step of 0.2 stands above 0.06 up to 1 px outside.
    assert found.sum() == pytest.approx(np.pi * 41**2, rel=0.02)


def test_area_and_strength_of_a_known_change():
    frame = IDLE.copy()
    frame[disc(50)] += np.float32([40.0, -20.0, 30.0])
    found = contact_statistics(frame, 1.25 * IDLE - 25)
    # Smoothed by 2 px, a step of 0.31 RMS stands above 0.06 up to 1.75 px outside.
    assert found["area"] == pytest.approx(100 * np.pi * 51.75**2 / SIDE**2, rel=0.01)
    assert [found[f"residual {c}"] for c in COLOURS] == pytest.approx([40, 20, 30], rel=0.04)
    assert [found[f"shading {c}"] for c in COLOURS] == pytest.approx([40, 20, 30], rel=0.04)


@pytest.mark.parametrize("correlation", [-0.79, 0.0, 0.5])
def test_channels_are_as_correlated_as_they_were_made(correlation):
    fields = [cv2.GaussianBlur(noise(seed, SIDE, SIDE), (0, 0), 2.0) for seed in (1, 2)]
    first, second = (field / field.std() for field in fields)
    change = np.stack([first, first, correlation * first + np.sqrt(1 - correlation**2) * second])
    frame = IDLE + 40 * np.moveaxis(change, 0, -1) * disc(70)[..., None]
    found = contact_statistics(frame, IDLE)
    # The weakest pixels fall out of the region: measured to shift this by up to 0.05.
    assert found["contact B-R"] == pytest.approx(correlation, abs=0.1)
    assert found["contact G-R"] == pytest.approx(1, abs=1e-4)


def test_each_pair_of_channels_has_its_own_correlation():
    fields = [cv2.GaussianBlur(noise(seed, SIDE, SIDE), (0, 0), 2.0) for seed in (1, 2)]
    first, second = (field / field.std() for field in fields)
    change = np.stack([first, -0.6 * first + 0.8 * second, -first], axis=-1)
    found = contact_statistics(IDLE + 40 * change * disc(70)[..., None], IDLE)
    assert found["contact B-R"] == pytest.approx(-1, abs=1e-4)
    assert found["contact G-R"] == pytest.approx(-0.6, abs=0.1)
    assert found["contact G-B"] == pytest.approx(0.6, abs=0.1)


@pytest.mark.parametrize("blur_px", [1.5, 3.0])
def test_sharpness_of_a_blurred_edge_is_its_closed_form(blur_px):
    # An edge of width w has gradient energy 1 / (2 sqrt(pi) w); w^2 = blur^2 + sigma^2.
    expected = ((blur_px**2 + 9) / (blur_px**2 + 1)) ** 0.25
    found = contact_statistics(bar(blur_px), IDLE)
    assert found["sharpness G"] == pytest.approx(expected, rel=0.04)


def test_blur_lowers_sharpness_and_gradient():
    sharp, soft = (contact_statistics(bar(blur), IDLE) for blur in (0, 3))
    assert soft["sharpness R"] < 0.8 * sharp["sharpness R"]
    assert soft["gradient R"] < 0.8 * sharp["gradient R"]


def test_the_gradient_of_a_roof_is_its_slope():
    rise = np.clip(45 - np.abs(np.arange(SIDE) - 112), 0, None).astype(np.float32)
    roof = np.zeros((SIDE, SIDE, 3), np.float32)
    roof[20:204] = 2 * rise[:, None]
    assert contact_statistics(IDLE + roof, IDLE)["gradient B"] == pytest.approx(2, rel=0.02)


def test_directions_of_three_lights_are_found_whatever_the_depth_term():
    degrees = np.array([-96.0, 8.0, 93.0])
    lights = 20 * np.stack([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))], axis=-1)
    found = contact_statistics(bump(lights, (0.1, 0.05, 0.1)), IDLE)
    assert [found[f"light {c}"] for c in COLOURS] == pytest.approx(degrees, abs=1)


def test_shading_cancels_in_the_mean_and_the_depth_term_stays():
    lights = [[0, -20], [20, 0], [0, 20]]
    plain, deep = (
        contact_statistics(bump(lights, gain), IDLE) for gain in ((0, 0, 0), (0.1, 0.05, 0.2))
    )
    assert [plain[f"brightening {c}"] for c in COLOURS] == pytest.approx([0] * 3, abs=0.1)
    means = [deep[f"brightening {c}"] for c in COLOURS]
    assert np.array(means) / means[0] == pytest.approx([1, 0.5, 2], abs=0.03)
    # The mean of a Gaussian dent over a disc of radius r is 2 s^2 (1 - exp(-r^2 / 2 s^2)) / r^2.
    share = 2 * 18**2 / (deep["area"] / 100 * SIDE**2 * ASPECT / np.pi)
    assert means[0] == pytest.approx(100 * 0.1 * share * (1 - np.exp(-1 / share)), rel=0.08)


def test_an_imprint_cut_by_the_border_has_no_direction():
    found = contact_statistics(bump([[0, -20], [20, 0], [0, 20]], column=200), IDLE)
    assert "contact B-R" in found
    assert not {"light R", "brightening R"} & found.keys()


def test_noise_beside_the_contact_is_that_of_the_frame():
    frame = bump([[0, -20], [20, 0], [0, 20]]) + 1.5 * noise(3, SIDE, SIDE, 3)
    found = contact_statistics(frame, IDLE)
    # A Gaussian of 3 px takes 1.4 % of white noise along.
    assert [found[f"beside {c}"] for c in COLOURS] == pytest.approx([1.5] * 3, rel=0.03)


def test_brightening_per_depth_of_a_ball_is_over_its_cap():
    # A region of 10 mm^2 on a 6 mm ball: a cap of 10 / (6 pi) mm.
    view_mm2 = SIDE**2 * 0.09 * 0.07
    contact = {"area": 1000 / view_mm2} | dict.fromkeys(map("brightening {}".format, COLOURS), 3.0)
    found = depth_statistics(contact, 6.0, (0.09, 0.07))
    assert found["depth G"] == pytest.approx(3.0 * 6 * np.pi / 10)
    assert depth_statistics({"area": 5.0}, 6.0, (0.09, 0.07)) == {}


def test_every_key_that_is_measured_has_a_title():
    found = contact_statistics(bump([[0, -20], [20, 0], [0, 20]]), IDLE)
    found |= depth_statistics(found, 6.0, (0.09, 0.07))
    assert found.keys() <= STATISTICS.keys()
