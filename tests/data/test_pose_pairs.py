"""Labels from poses. Expected: closed forms of plane motions, scipy's angles, the data's facts."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.data.pose_pairs import (
    GAPS_FRAMES,
    LEAST_SLIDES_PX,
    LEAST_TURNS_DEG,
    LabelledPair,
    PairRule,
    evenly_spaced,
    image_motion,
    in_plane_turn,
    labelled_pairs,
    nearest_rule,
    sweep_pair_counts,
)
from tests.data.tracked_trials import path_of, poses_of

FIRST, LAST = np.array([0]), np.array([1])
RULE = PairRule(gap_frames=1)
MM_PER_PX = 0.0634


@dataclass
class FakeTrial:
    """A sensor moved as its poses say over a contact whose middle is known in every frame."""

    poses: np.ndarray
    contact_px: np.ndarray
    centres_px: np.ndarray
    mm_per_px: float = MM_PER_PX
    size_px: tuple = (240, 320)


def trial_of(poses, centre_px=(159.5, 119.5), contact=4000):
    count = len(poses)
    return FakeTrial(
        np.asarray(poses), np.full(count, contact), np.tile(centre_px, (count, 1)).astype(float)
    )


def sensor_moved(*, turn_deg=0.0, x_mm=0.0, y_mm=0.0, z_mm=0.0, tilt_deg=0.0):
    """Two poses: the start, and the sensor turned and carried as said, seen from its start."""
    scipy = pytest.importorskip("scipy.spatial.transform", reason="needs scipy (extra: eval)")
    pose = np.eye(4)
    pose[:3, :3] = scipy.Rotation.from_euler(
        "zxy", [turn_deg, tilt_deg, 0], degrees=True
    ).as_matrix()
    pose[:3, 3] = np.array([x_mm, y_mm, z_mm]) / 1e3
    return np.stack([np.eye(4), pose])


def only_label(poses, task, rule=RULE, **trial):
    pairs = labelled_pairs(trial_of(poses, **trial), rule, task)
    return [pair.motion for pair in pairs]


@pytest.mark.parametrize(
    ("moved", "expected"),
    [
        ({"x_mm": 1.0}, Motion.LEFT),
        ({"x_mm": -1.0}, Motion.RIGHT),
        ({"y_mm": 1.0}, Motion.UP),
        ({"y_mm": -1.0}, Motion.DOWN),
    ],
)
def test_the_object_slides_against_the_sensor(moved, expected):
    assert only_label(sensor_moved(**moved), "sliding") == [expected]


@pytest.mark.parametrize(
    ("turn_deg", "expected"), [(8.0, Motion.COUNTERCLOCKWISE), (-8.0, Motion.CLOCKWISE)]
)
def test_the_object_turns_against_the_sensor(turn_deg, expected):
    assert only_label(sensor_moved(turn_deg=turn_deg), "rotation") == [expected]


def test_a_millimetre_is_as_many_pixels_as_the_sensor_says():
    moved = image_motion(trial_of(sensor_moved(x_mm=1.0)), FIRST, LAST)
    assert moved.slide_px[0] == pytest.approx([-1 / MM_PER_PX, 0])


def test_the_path_of_an_object_comes_back_from_the_sensors_poses():
    """The simulator's object turns by 20 degrees clockwise and travels 2 mm right, 1 mm up."""
    path = path_of(5, x=(0, 2.0), y=(0, -1.0), turn_deg=(10, 30))
    moved = image_motion(trial_of(poses_of(path)), np.array([0]), np.array([4]))
    assert moved.turn_deg[0] == pytest.approx(20.0)
    assert moved.slide_px[0] == pytest.approx([2 / MM_PER_PX, -1 / MM_PER_PX])


def test_a_turn_about_the_contact_carries_the_contact_nowhere():
    """The contact lies off the middle: turning about it takes the image's middle along, not it."""
    turn, arm_m = np.radians(10), np.array([3e-3, -2e-3])
    spin = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    seen = np.eye(4)
    seen[:2, :2], seen[:2, 3] = spin, arm_m - spin @ arm_m
    centre = arm_m * 1e3 / MM_PER_PX + (159.5, 119.5)
    poses = np.stack([np.eye(4), np.linalg.inv(seen)])
    moved = image_motion(trial_of(poses, centre), FIRST, LAST)
    assert moved.turn_deg[0] == pytest.approx(10)
    assert moved.slide_px[0] == pytest.approx([0, 0], abs=1e-9)
    about_middle = image_motion(trial_of(poses), FIRST, LAST)
    assert np.hypot(*about_middle.slide_px[0]) > 5


@pytest.mark.parametrize("seed", range(5))
def test_angles_are_those_of_scipys_extrinsic_zxy(seed):
    scipy = pytest.importorskip("scipy.spatial.transform", reason="needs scipy (extra: eval)")
    angles = np.random.default_rng(seed).uniform(-80, 80, (20, 3))
    matrices = scipy.Rotation.from_euler("zxy", angles, degrees=True).as_matrix()
    turn, tilt = in_plane_turn(matrices)
    assert turn == pytest.approx(angles[:, 0])
    assert tilt == pytest.approx(np.abs(angles[:, 1:]).max(axis=1))


@pytest.mark.parametrize(
    ("strict", "moved", "task"),
    [
        ({"least_turn_deg": 9.0}, {"turn_deg": 8.0}, "rotation"),
        ({"most_aside_px": 2.0}, {"turn_deg": 8.0, "x_mm": 0.3}, "rotation"),
        ({"most_tilt_deg": 1.0}, {"turn_deg": 8.0, "tilt_deg": 2.0}, "rotation"),
        ({"most_lift_mm": 0.1}, {"turn_deg": 8.0, "z_mm": 0.2}, "rotation"),
        ({"least_contact_px": 5000}, {"turn_deg": 8.0}, "rotation"),
        ({"gap_frames": 2}, {"turn_deg": 8.0}, "rotation"),
        ({"least_slide_px": 20.0}, {"x_mm": 1.0}, "sliding"),
        ({"most_aside_deg": 1.0}, {"x_mm": 1.0, "turn_deg": 2.0}, "sliding"),
        ({"least_purity": 0.99}, {"x_mm": 1.0, "y_mm": 0.3}, "sliding"),
    ],
)
def test_every_threshold_is_held(strict, moved, task):
    poses = sensor_moved(**moved)
    assert len(only_label(poses, task)) == 1
    assert only_label(poses, task, replace(RULE, **strict)) == []


def steady_turn(step_deg, count=60):
    return trial_of(poses_of(path_of(count, turn_deg=(0, step_deg * (count - 1)))))


def test_a_sweep_counts_every_gap_and_threshold():
    """One degree a frame: a pair g frames apart turns by g degrees, 60 - g such pairs."""
    rows = sweep_pair_counts([steady_turn(1.0)], PairRule(), "rotation")
    assert len(rows) == len(GAPS_FRAMES) * len(LEAST_TURNS_DEG)
    assert len(sweep_pair_counts([], PairRule(), "sliding")) == len(GAPS_FRAMES) * len(
        LEAST_SLIDES_PX
    )
    found = {(row["gap_frames"], row["least"]): row["pairs"] for row in rows}
    # At just its threshold a turn may round either way; none of these is.
    assert (found[5, 3.0], found[10, 5.0], found[10, 12.0], found[25, 12.0]) == (55, 50, 0, 35)
    assert rows[0]["of"] == {"clockwise": 55}


def test_the_rule_nearest_to_a_number_of_pairs_is_taken():
    rows = sweep_pair_counts([steady_turn(1.0)], PairRule(), "rotation")
    rule = nearest_rule(rows, PairRule(), "rotation", 36)
    assert (rule.gap_frames, len(labelled_pairs(steady_turn(1.0), rule, "rotation"))) == (25, 35)
    assert 0 in [row["pairs"] for row in rows]  # which is the last resort
    rule = nearest_rule(rows, PairRule(), "rotation", 1)
    assert len(labelled_pairs(steady_turn(1.0), rule, "rotation")) > 0


def test_a_trial_shorter_than_the_gap_has_no_pairs():
    assert labelled_pairs(steady_turn(1.0, count=4), PairRule(), "rotation") == []


def test_pairs_are_thinned_evenly():
    pairs = [LabelledPair(k, k + 1, Motion.UP, 0.0, (0.0, -9.0)) for k in range(9)]
    assert [pair.first for pair in evenly_spaced(pairs, 3)] == [0, 4, 8]
    assert evenly_spaced(pairs, 9) == pairs
