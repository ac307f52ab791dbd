import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.simulation.motions import STEADY, UNSTEADY, path_of, random_path
from geotlm_lm.simulation.scene import Body, Scene
from geotlm_lm.simulation.truth import motion_at_contact

DEPTHS = (0.3, 1.0)


def paths(motion, count=40, hand=STEADY):
    for seed in range(count):
        rng = np.random.default_rng(seed)
        yield random_path(rng, DEPTHS, (1.0, -2.0), motion, hand)


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


def test_a_rotation_carries_its_middle_around_one_axis():
    for path in paths(Motion.CLOCKWISE):
        turned = np.exp(1j * (np.array(path.rotation_rad) - path.rotation_rad[0]))
        middle = np.array(path.x_mm) + 1j * np.array(path.y_mm)  # x towards y is clockwise
        axis = (middle[-1] - turned[-1] * middle[0]) / (1 - turned[-1])
        off = np.abs(middle - axis - turned * (middle[0] - axis))
        # What else it drifts, 0.15 of the turn's path at 2 mm, bends that circle by an eighth.
        arc = abs(path.rotation_rad[-1] - path.rotation_rad[0])
        assert off.max() <= 0.15 * 2.0 * arc * arc / 8 + 1e-6


degrees, lengths = st.floats(-60, 60), st.floats(-5, 5)
places = st.tuples(lengths, lengths)


def carried(path, x_mm, y_mm):
    """Return how far the point now at a place has come: degrees, right, down, inward."""
    scene = Scene(Body("block"), path, Motion.STILL)
    right, down, turn = motion_at_contact(scene, (x_mm, y_mm), len(path) - 1)
    return np.degrees(turn), right, down, path.depth_mm[-1] - path.depth_mm[0]


@given(turn=degrees, right=lengths, down=lengths, inward=lengths, contact=places)
def test_the_middle_of_the_contact_does_what_was_asked(turn, right, down, inward, contact):
    asked = {"turn_deg": turn, "right_mm": right, "down_mm": down, "inward_mm": inward}
    path = path_of(**asked, contact_mm=contact)
    middle = path.x_mm[-1] + contact[0], path.y_mm[-1] + contact[1]
    assert carried(path, *middle) == pytest.approx((turn, right, down, inward), abs=1e-9)


@given(turn=degrees, right=lengths, down=lengths, pivot=places, contact=places)
def test_the_axis_beside_the_contact_is_carried_by_the_slide_alone(
    turn, right, down, pivot, contact
):
    asked = {"turn_deg": turn, "right_mm": right, "down_mm": down, "contact_mm": contact}
    path = path_of(**asked, pivot_mm=pivot)
    x, y = (path.x_mm[-1] + contact[0], path.y_mm[-1] + contact[1])
    axis = carried(path, x + pivot[0], y + pivot[1])
    assert axis == pytest.approx((turn, right, down, 0), abs=1e-9)
    # The contact's middle goes and comes by as much, about the middle of the view.
    came = carried(path, x, y)
    assert (path.x_mm[-1], path.y_mm[-1]) == pytest.approx((came[1] / 2, came[2] / 2), abs=1e-9)
