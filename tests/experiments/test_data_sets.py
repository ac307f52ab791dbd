import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.data.pose_pairs import PairRule
from geotlm_lm.data.tactile_tracking import TactileTracking
from geotlm_lm.experiments.compare import Reply
from geotlm_lm.experiments.data_sets import (
    PAIRS_PER_TRIAL,
    ListedClips,
    judge_data_set,
    open_data_set,
    open_data_sets,
    tracked_pairs,
)
from geotlm_lm.probe.rigid_flow import RigidFlow
from tests.data.action_clips import write_actions
from tests.data.test_pose_pairs import steady_turn
from tests.data.tracked_trials import path_of, write_trial

FLOW = {"flow": lambda clip, among: Reply(RigidFlow().predict(clip, among), 1.0)}


def quietly(what, done, total):
    """Take no notice."""


@pytest.fixture(scope="module")
def tracked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("trials") / "normalflow_dataset"
    write_trial(folder / "key0", path_of(11, turn_deg=(0, 12), y=(-2.0, -2.0)))
    write_trial(folder / "key1", path_of(11, turn_deg=(12, 0), y=(-2.0, -2.0)))
    write_trial(folder / "bead0", path_of(11, x=(-0.8, 0.8), y=(1.5, 1.5)))
    (folder / "bead1").mkdir()
    (folder / "bead1" / "true_start_T_currs.npy").write_bytes(b"")
    return folder


@pytest.fixture(scope="module")
def judged(tracked):
    return judge_data_set(FLOW, open_data_set(tracked), 0, quietly, contrasts=())


def test_trials_are_judged_as_the_papers_two_tasks(judged):
    tables, _ = judged
    assert list(tables) == [
        "TactileTracking normalflow_dataset, rotation",
        "TactileTracking normalflow_dataset, sliding",
    ]
    turns, slides = tables.values()
    assert set(turns["truths"]) == {"clockwise", "counterclockwise"}
    assert slides["truths"] == {"right": slides["clips"]}
    assert turns["methods"]["flow"]["accuracy"] == 1.0
    assert slides["methods"]["flow"]["accuracy"] == 1.0


def test_a_table_states_the_thresholds_behind_it(judged):
    pairs = judged[0]["TactileTracking normalflow_dataset, rotation"]["pairs"]
    assert pairs["rule"]["gap_frames"] in (5, 10)
    assert (pairs["paper"], pairs["paper_share"]) == (4088, pytest.approx(3 / 84))


def test_sweeps_backgrounds_and_bad_trials_are_told(judged):
    _, about = judged
    assert about["left_out"]["count"] == 1
    assert "bead1: gelsight.avi is missing" in about["left_out"]["first"][0]
    assert set(about["sweeps"]) == {"rotation", "sliding"}
    assert about["backgrounds"]["estimated where untouched, trials"] == 3


def test_the_rule_is_the_one_whose_count_comes_nearest_to_the_papers_share():
    """One degree a frame, 60 frames: 4,088 of 84 trials are 49 of one; a gap of 10 has 50 pairs."""
    cases, facts, rows = tracked_pairs(
        TactileTracking("here", (steady_turn(1.0),)), "rotation", PairRule()
    )
    assert (facts["pairs"]["rule"]["gap_frames"], facts["pairs"]["found"]) == (10, 50)
    assert len(cases) == 50
    assert min(abs(row["pairs"] - 4088 / 84) for row in rows) == pytest.approx(50 - 4088 / 84)


def test_no_trial_gives_more_pairs_than_its_share():
    """Two degrees a frame, 200 frames: every rule that finds pairs at all finds 175 or more."""
    cases, facts, _ = tracked_pairs(
        TactileTracking("here", (steady_turn(2.0, count=200),)), "rotation", PairRule()
    )
    assert facts["pairs"]["found"] >= 175
    assert len(cases) == PAIRS_PER_TRIAL


@pytest.fixture(scope="module")
def listed(tmp_path_factory):
    root = tmp_path_factory.mktemp("listed")
    write_actions(root, frames=7)
    write_actions(root, body="key", sensor="digit", actions=("rotate_cw", "slide_up"))
    rows = ["clip_id,object_id,sensor,action,frames,background"]
    for path in sorted(root.glob("*/*/*")):
        body, sensor, name = path.relative_to(root).parts
        folder = f"{body}/{sensor}/{name}"
        action = name.removesuffix("-0")
        rows.append(f"{folder},{body},{sensor},{action},{folder}/[0-9]*.png,{folder}/bg.png")
    rows.append("bad,key,digit,slide_up,gone.npy,")
    (root / "touchd.csv").write_text("\n".join(rows) + "\n")
    return root / "touchd.csv"


def test_a_manifest_is_judged_by_task_and_by_sensor(listed):
    tables, about = judge_data_set(FLOW, open_data_set(listed), 0, quietly, contrasts=())
    assert [(title, table["clips"]) for title, table in tables.items()] == [
        ("manifest touchd, rotation", 3),
        ("manifest touchd, rotation, sensor digit", 1),
        ("manifest touchd, rotation, sensor gsmini", 2),
        ("manifest touchd, sliding", 5),
        ("manifest touchd, sliding, sensor digit", 1),
        ("manifest touchd, sliding, sensor gsmini", 4),
    ]
    assert tables["manifest touchd, rotation"]["methods"]["flow"]["accuracy"] == 1.0
    assert tables["manifest touchd, sliding"]["methods"]["flow"]["accuracy"] == 1.0
    assert about["left_out"]["count"] == 1
    assert about["backgrounds"] == {"given": 8}


def test_four_frames_of_a_listed_clip_are_chosen_as_a_users_are(listed):
    cases = ListedClips(open_data_set(listed), ROTATIONS)
    assert [len(case.clip) for case in cases] == [4, 4, 4]
    assert len(ListedClips(open_data_set(listed), SLIDES)) == 6


def test_objects_are_the_unit(listed):
    cases = list(ListedClips(open_data_set(listed), SLIDES))
    assert {case.object_id for case in cases} == {case.family for case in cases}
    assert {case.object_id for case in cases} == {"key", "letter_l"}
    assert {case.motion for case in cases} == set(SLIDES)


def test_a_folder_of_something_else_is_refused(tmp_path):
    with pytest.raises(
        UnreadableClip, match="holds no trials of TactileTracking, expected folders"
    ):
        open_data_set(tmp_path)


def test_two_data_sets_of_one_name_are_refused(listed):
    with pytest.raises(UsageError, match="another data set is called 'manifest touchd' too"):
        open_data_sets([listed, listed])


def test_progress_reaches_its_end(tracked):
    seen = []
    still = {"still": lambda clip, among: Reply(Motion.STILL, 1.0)}
    data = open_data_set(tracked)
    judge_data_set(still, data, 0, lambda *told: seen.append(told), contrasts=())
    title, done, total = seen[-1]
    assert title == "TactileTracking normalflow_dataset, sliding"
    assert done == total > 0
    assert np.unique([one[0] for one in seen]).size == 2
