"""Bodies: formulas by name, profiles placed by a pose, and a user's own height maps."""

import io

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UsageError
from geotlm_lm.simulation.contact import BOX_MM
from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS, INDENTERS, TRAINING_OBJECTS
from geotlm_lm.simulation.profile import build_profile, pool_to_cells
from geotlm_lm.simulation.scene import Body
from geotlm_lm.simulation.shapes import (
    PX_PER_MM,
    height_map_indenter,
    object_grid,
    read_height_map,
    smooth_field,
)


def test_everyday_things_are_never_trained_on():
    trained = {id(INDENTERS[name].height) for name in TRAINING_OBJECTS}
    assert not trained & {id(INDENTERS[name].height) for name in EVERYDAY_OBJECTS}


@pytest.mark.parametrize("name", INDENTERS)
def test_a_body_is_finite_and_has_something_to_touch(name):
    every = 1 if INDENTERS[name].is_extended else 2
    x, y = (axis[::every, ::every] for axis in object_grid())
    height = INDENTERS[name].height(x, y, np.random.default_rng(7))
    assert height.shape == x.shape
    assert height.dtype == np.float32  # an accidental double slows every later pass
    assert np.all(np.isfinite(height))
    reachable = height < height.min() + 1.2
    assert reachable.mean() > 0.002


@pytest.mark.parametrize("correlation_px", [0.5, 3.0, 20.0])
def test_a_random_field_has_unit_moments_and_its_correlation_length(correlation_px):
    field = smooth_field(np.random.default_rng(1), correlation_px / PX_PER_MM)
    assert (field.mean(), field.std()) == pytest.approx((0, 1), abs=0.05)
    near, far = (np.mean(field[:, :-gap] * field[:, gap:]) for gap in (4, 80))
    assert near > 0.85 or correlation_px < 20
    assert abs(far) < 0.2


POSE = (1.5, -2.0, 0.7)


def test_a_tip_narrower_than_a_cell_does_not_vanish():
    fine = np.full((60, 60), 1000.0, np.float32)
    fine[24, 31] = 0.0
    cells = pool_to_cells(fine, 5)
    assert cells[4, 6] == 0.0
    assert (cells < 1).sum() == 1


def test_the_lowest_point_is_zero_whatever_the_lean_and_texture():
    body = Body("block", variant=5, tilt_x=0.1, tilt_y=-0.05, texture_um=30)
    fine = build_profile(body).sample((0.0, 0.0, 0.4), (0.08, 0.08), 320)
    assert fine.min() == pytest.approx(0, abs=0.02)
    assert fine.min() > -0.002


@pytest.mark.parametrize("name", TRAINING_OBJECTS[::6])
def test_outside_its_window_a_body_is_higher_than_asked_for(name):
    profile = build_profile(Body(name, variant=3, tilt_x=0.08))
    whole = profile.sample(POSE, (0.08, 0.07), 224)
    window = profile.window(POSE, (0.08, 0.07), 224, 0.7)
    low = whole < 0.7
    low[window.slices] = False
    assert not low.any()
    # Whole sixteenths of a raster sample, on which the interpolation places its points, apart.
    part = profile.sample(POSE, (0.08, 0.07), 224, window)
    assert np.abs(np.minimum(part, 1) - np.minimum(whole[window.slices], 1)).mean() < 1e-3


def test_a_compact_body_needs_a_small_window_and_one_out_of_view_none():
    profile = build_profile(Body("ball_small"))
    window = profile.window((0.0, 0.0, 0.0), (0.08, 0.08), 224, 0.5)
    assert 0 < (window.bottom - window.top) * (window.right - window.left) < 0.2 * 224**2
    away = profile.window((500.0, 0.0, 0.0), (0.08, 0.08), 224, 0.5)
    assert away.left == away.right
    assert profile.on_cells((500.0, 0.0, 0.0), BOX_MM, 48, 0.5).min() > 500


@pytest.mark.parametrize("name", ["key", "ball_medium", "cloth_coarse"])
def test_cells_within_reach_are_the_same_from_a_window(name):
    profile = build_profile(Body(name, variant=3))
    whole, part = (profile.on_cells(POSE, BOX_MM, 48, reach) for reach in (np.inf, 1.0))
    assert np.abs(np.minimum(part, 0.8) - np.minimum(whole, 0.8)).max() < 0.01


AXIS = (np.arange(120) - 59.5) * 0.1
X, Y = np.meshgrid(AXIS, AXIS)
BALL = -(X**2 + Y**2) / 8


def sampled(indenter):
    return indenter.height(*object_grid(), np.random.default_rng(0))


def test_the_form_is_kept_columns_run_right_rows_down_and_the_highest_touches_first():
    height = sampled(height_map_indenter(-((X - 3) ** 2 + (Y + 2) ** 2) / 8, 0.1))
    x, y = object_grid()
    near = np.hypot(x - 3, y + 2) < 2.5
    form = ((x - 3) ** 2 + (y + 2) ** 2) / 8
    assert height[near] == pytest.approx(form[near], abs=5e-3)


def test_outside_of_the_map_and_in_its_holes_there_is_no_object():
    holed = np.where(np.hypot(X, Y) < 2, np.nan, 0.0)
    height = sampled(height_map_indenter(holed, 0.1))
    x, y = object_grid()
    assert height[np.hypot(x, y) < 1].min() > 5
    ring = (np.hypot(x, y) > 2.3) & (np.hypot(x, y) < 5)
    assert np.abs(height[ring]).max() < 1e-6
    assert height[np.hypot(x, y) > 10].min() > 5


def test_npy_and_png_of_the_same_form_are_the_same_body(tmp_path):
    relief = np.cos(X) * np.cos(Y) * 0.25 + 0.25
    np.save(tmp_path / "a.npy", relief)
    levels = np.round((relief - relief.min()) / np.ptp(relief) * 65535).astype(np.uint16)
    cv2.imwrite(str(tmp_path / "a.png"), levels)
    archive = read_height_map(tmp_path / "a.npy", 0.1)
    image = read_height_map(tmp_path / "a.png", 0.1, relief_mm=float(np.ptp(relief)))
    assert sampled(archive) == pytest.approx(sampled(image), abs=1e-4)


@pytest.mark.parametrize(
    ("height", "mm_per_px", "says"),
    [
        (np.zeros((4, 4)), 0.1, r"shape \(4, 4\), expected \(rows, columns\)"),
        (np.zeros((9, 9), np.int64), 0.1, "expected heights in mm as finite floats"),
        (np.full((9, 9), np.inf), 0.1, "finite floats"),
        (np.full((9, 9), np.nan), 0.1, "every height is NaN"),
        (np.zeros((400, 9)), 0.1, "40.0 mm at 0.1 mm per pixel, expected at most the pad's 25.6"),
        (np.zeros((9, 9)), 50.0, "50 mm per pixel, expected 0.001 to 2"),
        (np.linspace(0, 300, 81).reshape(9, 9), 0.1, "are they in micrometres"),
    ],
)
def test_a_map_that_makes_no_sense_is_refused(height, mm_per_px, says):
    with pytest.raises(UsageError, match=says):
        height_map_indenter(height, mm_per_px)


def npy_header(old, new):
    """Return a stored map whose header was damaged."""
    stream = io.BytesIO()
    np.save(stream, BALL)
    return stream.getvalue().replace(old, new)


COLOURS = cv2.imencode(".png", np.zeros((16, 16, 3), np.uint8))[1].tobytes()
HUGE = COLOURS[:16] + (30000).to_bytes(4) * 2 + COLOURS[24:]


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.png", b"nothing", "no 8 or 16 bit .png"),
        ("a.png", COLOURS, "has colours"),
        ("a.png", COLOURS[:50], "is cut off; copy or save it again"),
        ("a.png", HUGE, r"a\.png: is 30000x30000 samples, expected at most 8192"),
        ("a.npy", npy_header(b"}", b"("), r"cannot be read as \.npy \(.*\); save it with"),
        # More than memory holds.
        ("a.npy", npy_header(b"(120, 120)", b"(120, 99999999999)"), r"cannot be read as \.npy"),
        ("a.npy", b"\x93NUMPY", r"cannot be read as \.npy"),
        ("a.npy", None, r"a\.npy: cannot be read \(No such file.*\); check the name"),
        ("a.png", None, "cannot be opened"),
    ],
)
def test_files_that_are_no_maps_are_refused(tmp_path, name, content, says):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(UsageError, match=says):
        read_height_map(tmp_path / name, 0.1)
