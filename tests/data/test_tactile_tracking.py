import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import ROTATIONS, SLIDES
from geotlm_lm.data.pose_pairs import PairRule, labelled_pairs
from geotlm_lm.data.tactile_tracking import is_tactile_tracking, pair_clip, read_tactile_tracking
from geotlm_lm.probe.rigid_flow import RigidFlow
from tests.data.tracked_trials import COLUMNS, ROWS, path_of, write_trial, write_video

RULE = PairRule(gap_frames=2, least_turn_deg=4.0, least_slide_px=8.0)
MOTIONS = {
    "key0": path_of(turn_deg=(0, 12)),
    "key1": path_of(turn_deg=(12, 0), x=(2.0, 2.0)),
    "bead0": path_of(x=(-1.2, 1.2)),
    "bead1": path_of(x=(1.2, -1.2), y=(0.5, 0.5)),
    "seed0": path_of(y=(-1.2, 1.2)),
    "seed1": path_of(y=(1.2, -1.2)),
}


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Six trials, one per motion, as the archive unpacks; and their simulated clips."""
    folder = tmp_path_factory.mktemp("data")
    made = {
        name: write_trial(folder / "normalflow_dataset" / name, path)
        for name, path in MOTIONS.items()
    }
    return folder, made


@pytest.fixture(scope="module")
def read(written):
    return read_tactile_tracking(written[0])


@pytest.fixture
def one(tmp_path):
    write_trial(tmp_path / "key0", path_of(turn_deg=(0, 12)))
    return tmp_path


def reason(folder):
    with pytest.raises(UnreadableClip) as caught:
        read_tactile_tracking(folder)
    return str(caught.value)


def test_trials_are_found_inside_the_folder_the_archive_unpacks_to(read):
    assert [trial.folder.name for trial in read.trials] == sorted(MOTIONS)
    assert {trial.object_id for trial in read.trials} == {"key", "bead", "seed"}
    assert read.trials[0].mm_per_px == pytest.approx(0.0634)
    assert read.left_out == {}


def test_the_layout_is_told_from_others(written, tmp_path):
    assert is_tactile_tracking(written[0])
    assert is_tactile_tracking(written[0] / "normalflow_dataset")
    assert not is_tactile_tracking(tmp_path)
    assert not is_tactile_tracking(tmp_path / "gone")


@pytest.mark.parametrize("task", ["rotation", "sliding"])
def test_labels_from_poses_are_what_the_simulator_did(read, task):
    expected = dict(zip(MOTIONS, (*ROTATIONS, "right", "left", "down", "up"), strict=True))
    for trial in read.trials:
        labels = {pair.motion for pair in labelled_pairs(trial, RULE, task)}
        truth = expected[trial.folder.name]
        assert labels == ({truth} if (truth in ROTATIONS) == (task == "rotation") else set())


def test_flow_reads_the_labelled_motion_off_the_pairs(read):
    """Frames, poses, masks and the estimated background fit together, or flow would not agree."""
    flow, right = RigidFlow(), []
    for trial in read.trials:
        recording = trial.recording()
        for task, among in (("rotation", ROTATIONS), ("sliding", SLIDES)):
            for pair in labelled_pairs(trial, RULE, task):
                said = flow.predict(pair_clip(recording, trial, pair), among)
                right.append(said == pair.motion)
    assert len(right) == 24
    assert np.mean(right) == 1.0


def test_a_pair_is_shown_as_each_frame_twice(read):
    trial = read.trials[0]
    pair = labelled_pairs(trial, RULE, "sliding")[1]
    clip = pair_clip(trial.recording(), trial, pair)
    assert clip.frame_numbers == (1, 1, 3, 3)
    assert clip.name == "bead0[1:3]"


def test_the_idle_gel_comes_out_of_frames_that_are_all_touched(read, written):
    idle = cv2.resize(written[1]["key0"].clip.background, (COLUMNS, ROWS)).astype(float)
    error = np.abs(read.trials[0].background - idle).mean()
    naive = np.abs(read.trials[0].recording().frames[0] - idle).mean()
    # Measured 0.9 grey levels; frame 0, which is touched, is 2.0 off.
    assert error < 1.1
    assert naive > 1.5 * error


def test_each_trial_gets_the_light_it_was_taken_in(tmp_path):
    write_trial(tmp_path / "key0", path_of(x=(-3.0, -3.0)))
    write_trial(tmp_path / "key1", path_of(x=(3.0, 3.0)), light=0.05)
    first, second = read_tactile_tracking(tmp_path).trials
    brighter = second.background.astype(float).mean() / first.background.mean()
    assert brighter == pytest.approx(1.05, abs=0.005)


def test_where_every_frame_is_touched_the_shading_is_fitted(one):
    masks = np.load(one / "key0" / "contact_masks.npy")
    masks[:, 100:140, 100:140] = True
    np.save(one / "key0" / "contact_masks.npy", masks)
    read = read_tactile_tracking(one)
    assert 0.02 < read.gel.covered_share < 0.5
    assert read.trials[0].background[100:140, 100:140].min() > 20


def test_an_older_releases_video_is_read(one):
    frames = np.zeros((6, ROWS, COLUMNS, 3), np.uint8) + 90
    (one / "key0" / "gelsight.avi").unlink()
    writer = cv2.VideoWriter(
        str(one / "key0" / "gelsight.mp4"), cv2.VideoWriter.fourcc(*"mp4v"), 25.0, (COLUMNS, ROWS)
    )
    for frame in frames:
        writer.write(frame)
    writer.release()
    assert len(read_tactile_tracking(one).trials) == 1


def test_a_trial_whose_files_disagree_is_left_out_and_named(written, tmp_path):
    root = tmp_path / "set"
    root.mkdir()
    (root / "key0").symlink_to(written[0] / "normalflow_dataset" / "key0")
    write_trial(root / "key1", path_of(turn_deg=(0, 12)))
    np.save(root / "key1" / "true_start_T_currs.npy", np.tile(np.eye(4), (5, 1, 1)))
    read = read_tactile_tracking(root)
    assert [trial.folder.name for trial in read.trials] == ["key0"]
    assert read.left_out == {
        "key1": f"{root / 'key1'}: found 6 of the video, 5 of poses, 6 of masks, 6 of gradient "
        f"maps, expected equally many; copy it again."
    }


@pytest.mark.parametrize(
    ("name", "array", "said"),
    [
        ("true_start_T_currs.npy", np.zeros((6, 3, 3)), "expected floating-point poses"),
        ("true_start_T_currs.npy", np.full((6, 4, 4), np.nan), "holds NaN or infinite poses"),
        ("true_start_T_currs.npy", np.zeros((6, 4, 4)), "a pose is off a rigid motion by 1,"),
        (
            "true_start_T_currs.npy",
            np.tile(np.eye(4), (6, 1, 1)) + np.eye(4, k=3) * 5,
            "the sensor travels 5 m, expected at most 0.2; give translations in metres.",
        ),
        ("contact_masks.npy", np.zeros((6, 4, 5), bool), "masks have the shape (4, 5), the video"),
        ("contact_masks.npy", np.float64(1), "found float64 of shape (), expected numbers, one"),
        ("contact_masks.npy", np.array(["a"] * 6), "expected numbers, one entry per frame"),
        ("true_start_T_currs.npy", np.float64(1), "found float64 of shape (), expected floating"),
        ("gradient_maps.npy", np.float64(1), "gradient_maps.npy: found float64 of shape ()"),
        ("gradient_maps.npy", np.zeros((3, 4, 5, 2)), "3 of gradient maps, expected equally many"),
    ],
)
def test_damaged_files_are_named_with_what_was_expected(one, name, array, said):
    np.save(one / "key0" / name, array)
    assert said in reason(one)


@pytest.mark.parametrize("name", ["gelsight.avi", "contact_masks.npy"])
def test_a_missing_file_is_named(one, name):
    (one / "key0" / name).unlink()
    assert f"{one / 'key0'}: {name} is missing; unpack the trial again." in reason(one)


def test_masks_that_would_run_code_are_never_unpickled(one):
    np.save(one / "key0" / "contact_masks.npy", np.array([{}], object), allow_pickle=True)
    assert "Python objects, which are never unpickled" in reason(one)


def test_poses_of_an_unknown_convention_are_refused(one):
    (one / "key0" / "true_start_T_currs.npy").rename(one / "key0" / "true_transforms.npy")
    assert "found true_transforms.npy, whose convention is not published" in reason(one)


def test_frames_of_another_size_leave_a_trial_out(one):
    write_trial(one / "key1", path_of())
    write_video(one / "key1" / "gelsight.avi", [np.zeros((48, 64, 3), np.uint8)] * 6)
    np.save(one / "key1" / "contact_masks.npy", np.zeros((6, 48, 64), bool))
    left_out = read_tactile_tracking(one).left_out
    assert "frames are 64 x 48 pixels, those of key0 320 x 240" in left_out["key1"]


def test_a_folder_without_trials_is_refused(tmp_path):
    assert reason(tmp_path) == (
        f"{tmp_path}: found no trial that can be used, expected folders with gelsight.avi, "
        f"true_start_T_currs.npy and contact_masks.npy; the first reason: no folder in it holds "
        f"poses"
    )


def test_the_middle_of_a_contact_is_that_of_its_largest_part_right_and_down(one):
    masks = np.zeros((6, ROWS, COLUMNS), bool)
    masks[:, 20:31, 200:241] = True
    masks[1:, 24:27, 210:230] = False  # a hole is filled
    masks[2:, 100:104, 50:54] = True
    np.save(one / "key0" / "contact_masks.npy", masks)
    (trial, *_) = read_tactile_tracking(one).trials
    assert trial.centres_px == pytest.approx(np.tile([220.0, 25.0], (6, 1)))
    assert trial.contact_px.tolist() == [451, 391, *[407] * 4]
