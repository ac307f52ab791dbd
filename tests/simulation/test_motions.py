import numpy as np
import pytest

from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.simulation.motions import STEADY, UNSTEADY, random_path

DEPTHS = (0.3, 1.0)


def paths(motion, count=40, hand=STEADY):
    for seed in range(count):
        rng = np.random.default_rng(seed)
        yield random_path(rng, motion, depth_range_mm=DEPTHS, centre_mm=(1.0, -2.0), hand=hand)


def travel(path):
    return path.x_mm[-1] - path.x_mm[0], path.y_mm[-1] - path.y_mm[0]


@pytest.mark.parametrize("motion", ROTATIONS)
def test_a_rotation_turns_the_way_it_says_between_three_and_forty_degrees(motion):
    sign = 1 if motion == Motion.CLOCKWISE else -1
    for path in paths(motion):
        assert np.all(sign * np.diff(path.rotation_rad) > 0)
        total = sign * np.degrees(path.rotation_rad[-1] - path.rotation_rad[0])
        assert 2.999 <= total <= 40.001


@pytest.mark.parametrize(
    ("motion", "axis", "sign"),
    [(Motion.RIGHT, 0, 1), (Motion.LEFT, 0, -1), (Motion.DOWN, 1, 1), (Motion.UP, 1, -1)],
)
def test_a_slide_goes_within_25_degrees_of_its_axis_and_hardly_turns(motion, axis, sign):
    for path in paths(motion):
        along, aside = sign * travel(path)[axis], abs(travel(path)[1 - axis])
        assert 0.13 < along <= 3.0
        assert aside <= np.tan(np.radians(25.001)) * along
        turn = abs(path.rotation_rad[-1] - path.rotation_rad[0])
        assert turn * 2.0 <= 0.15 * np.hypot(along, aside) + 1e-9


@pytest.mark.parametrize(("motion", "sign"), [(Motion.PRESS, 1), (Motion.RELEASE, -1)])
def test_a_press_deepens_and_a_release_lifts_with_little_travel(motion, sign):
    for path in paths(motion):
        assert 0.149 <= sign * (path.depth_mm[-1] - path.depth_mm[0]) <= 0.901
        assert np.hypot(*travel(path)) < 0.1


def test_some_presses_begin_without_contact():
    begins = [path.depth_mm[0] for path in paths(Motion.PRESS, 100)]
    assert 0 < np.mean(np.array(begins) <= 0) < 0.5


@pytest.mark.parametrize("motion", [*ROTATIONS, *SLIDES, Motion.STILL])
def test_a_motion_that_is_claimed_keeps_the_depth_it_needs(motion):
    for path in paths(motion):
        assert min(path.depth_mm) >= DEPTHS[0]
        assert max(path.depth_mm) <= DEPTHS[1]


def test_none_never_touches_and_still_hardly_moves():
    assert all(max(path.depth_mm) < 0 for path in paths(Motion.NONE))
    for path in paths(Motion.STILL):
        assert np.hypot(*travel(path)) < 0.05


def test_an_unsteady_hand_turns_and_slides_less_and_changes_depth_more():
    def deepening(hand, motion):
        return [abs(path.depth_mm[-1] - path.depth_mm[0]) for path in paths(motion, 200, hand)]

    turns = [path.rotation_rad for path in paths(Motion.CLOCKWISE, 200, UNSTEADY)]
    slid = [np.hypot(*travel(path)) for path in paths(Motion.LEFT, 200, UNSTEADY)]
    assert np.radians(1) < min(abs(turn[-1] - turn[0]) for turn in turns) < np.radians(1.2)
    assert 0.12 - 1e-9 < min(slid) < 0.15
    for motion in (Motion.CLOCKWISE, Motion.LEFT):
        assert np.mean(deepening(UNSTEADY, motion)) > 1.4 * np.mean(deepening(STEADY, motion))


def test_a_press_deepens_by_more_of_its_path_than_any_hand_does_while_it_turns():
    def ratio(path):
        turned = abs(path.rotation_rad[-1] - path.rotation_rad[0]) * 2.0
        return abs(path.depth_mm[-1] - path.depth_mm[0]) / (turned + np.hypot(*travel(path)) + 1e-9)

    pressed = [ratio(path) for path in paths(Motion.PRESS, 100, UNSTEADY)]
    turned = [ratio(path) for path in paths(Motion.CLOCKWISE, 100, UNSTEADY)]
    assert np.quantile(pressed, 0.05) > 2 * np.quantile(turned, 0.95)


@pytest.mark.parametrize("motion", ROTATIONS)
def test_a_rotation_carries_its_middle_around_one_axis(motion):
    for path in paths(motion):
        turned = np.exp(1j * (np.array(path.rotation_rad) - path.rotation_rad[0]))
        middle = np.array(path.x_mm) + 1j * np.array(path.y_mm)  # x towards y is clockwise
        axis = (middle[-1] - turned[-1] * middle[0]) / (1 - turned[-1])
        off = np.abs(middle - axis - turned * (middle[0] - axis))
        # What else it drifts, 0.15 of the turn's path at 2 mm, bends that circle by an eighth.
        arc = abs(path.rotation_rad[-1] - path.rotation_rad[0])
        assert off.max() <= 0.15 * 2.0 * arc * arc / 8 + 1e-6
