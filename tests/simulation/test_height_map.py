"""A user's own map presses as a built-in shape of the same form; bad ones are one sentence."""

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.height_map import height_map_indenter, read_height_map
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.raster import object_grid
from geotlm_lm.simulation.scene import Body, Path, Scene
from geotlm_lm.simulation.simulate import simulate

AXIS = (np.arange(120) - 59.5) * 0.1
X, Y = np.meshgrid(AXIS, AXIS)
BALL = -(X**2 + Y**2) / 8


def sampled(indenter):
    return indenter.height(*object_grid(), np.random.default_rng(0))


def test_the_highest_point_touches_first_and_the_form_is_kept():
    height = sampled(height_map_indenter(BALL, 0.1))
    x, y = object_grid()
    near = np.hypot(x, y) < 4
    assert height[near] == pytest.approx(((x**2 + y**2) / 8)[near], abs=5e-3)
    assert height.min() == pytest.approx(0, abs=1e-2)


def test_columns_run_right_and_rows_down():
    bump = np.exp(-((X - 3) ** 2 + (Y + 2) ** 2))
    height = sampled(height_map_indenter(bump, 0.1))
    x, y = object_grid()
    lowest = np.unravel_index(height.argmin(), height.shape)
    assert (x[lowest], y[lowest]) == pytest.approx((3, -2), abs=0.1)


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
    one = read_height_map(tmp_path / "a.npy", 0.1)
    other = read_height_map(tmp_path / "a.png", 0.1, relief_mm=float(np.ptp(relief)))
    assert sampled(one) == pytest.approx(sampled(other), abs=1e-4)


def test_a_height_map_is_simulated_like_any_body():
    body = Body("mine", indenter=height_map_indenter(BALL, 0.1))
    path = Path((0.5, 0.5), (0.0, 0.4), (0.0, 0.0), (0.0, 0.0))
    (made,) = simulate([Scene(body, path, Motion.RIGHT)], seed=1)
    assert made.contact.max() > 0.5
    assert made.label.is_readable
    built_in = build_profile(Body("mine", indenter=body.indenter))
    assert built_in is build_profile(body)


@pytest.mark.parametrize(
    ("height", "mm_per_px", "says"),
    [
        (np.zeros((4, 4)), 0.1, r"shape \(4, 4\), expected \(rows, columns\)"),
        (np.zeros((9, 9, 3)), 0.1, r"shape \(9, 9, 3\)"),
        (np.zeros((9, 9), np.int64), 0.1, "expected heights in mm as finite floats"),
        (np.full((9, 9), np.inf), 0.1, "finite floats"),
        (np.full((9, 9), np.nan), 0.1, "every height is NaN"),
        (np.zeros((400, 9)), 0.1, "40.0 mm at 0.1 mm per pixel, expected at most the pad's 25.6"),
        (np.zeros((9, 9)), 50.0, "50 mm per pixel, expected 0.001 to 2"),
        (np.zeros((9, 9)), float("nan"), "nan mm per pixel"),
        (np.linspace(0, 300, 81).reshape(9, 9), 0.1, "are they in micrometres"),
    ],
)
def test_a_map_that_makes_no_sense_is_refused(height, mm_per_px, says):
    with pytest.raises(UsageError, match=says):
        height_map_indenter(height, mm_per_px)


def test_files_that_are_no_maps_are_refused(tmp_path):
    (tmp_path / "a.npy").write_bytes(b"nothing")
    (tmp_path / "a.png").write_bytes(b"nothing")
    cv2.imwrite(str(tmp_path / "colours.png"), np.zeros((9, 9, 3), np.uint8))
    (tmp_path / "cut.png").write_bytes((tmp_path / "colours.png").read_bytes()[:50])
    for name, says in (
        ("a.npy", "cannot be read as .npy"),
        ("a.png", "no 8 or 16 bit .png"),
        ("colours.png", "has colours"),
        ("cut.png", "is cut off; copy or save it again"),
        (
            "absent.npy",
            r"absent\.npy: cannot be read \(No such file or directory\); check the name",
        ),
        ("absent.png", "cannot be opened"),
    ):
        with pytest.raises(UsageError, match=says):
            read_height_map(tmp_path / name, 0.1)


@pytest.mark.parametrize(
    "damage",
    [
        lambda b: b.replace(b"}", b"("),
        lambda b: b.replace(b"(120", b"(" + b"9" * 40),
        lambda b: b.replace(b"(120, 120)", b"(120, 99999999999)"),  # more than memory holds
        lambda b: b[:9],
    ],
    ids=["open bracket", "huge number", "more than it holds", "cut off"],
)
def test_a_damaged_header_is_one_sentence(tmp_path, damage):
    np.save(tmp_path / "a.npy", BALL)
    (tmp_path / "a.npy").write_bytes(damage((tmp_path / "a.npy").read_bytes()))
    with pytest.raises(UsageError, match=r"a\.npy: cannot be read as \.npy \(.*\); save it with"):
        read_height_map(tmp_path / "a.npy", 0.1)


def test_a_picture_of_more_samples_than_make_sense_is_not_decoded(tmp_path):
    code = bytearray(cv2.imencode(".png", np.zeros((16, 16), np.uint8))[1].tobytes())
    code[16:24] = (30000).to_bytes(4) * 2
    (tmp_path / "a.png").write_bytes(code)
    with pytest.raises(UsageError) as caught:
        read_height_map(tmp_path / "a.png", 0.1)
    assert str(caught.value) == (
        f"{tmp_path}/a.png: is 30000x30000 samples, expected at most 8192 a side; save a smaller "
        f"one."
    )
