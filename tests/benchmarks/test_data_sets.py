import pytest

from geotlm_lm.benchmarks.cases.data_sets import (
    listed_cases,
    open_data_set,
    open_data_sets,
    tracked_pairs,
)
from geotlm_lm.benchmarks.clips import Judge, data_set_rows, left_out
from geotlm_lm.benchmarks.judging import Reply
from geotlm_lm.benchmarks.rows import Run
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import SLIDES
from geotlm_lm.data.tactile_tracking import TactileTracking
from geotlm_lm.probe.rigid_flow import RigidFlow
from tests.data.action_clips import write_actions
from tests.data.test_tactile_tracking import steady_turn
from tests.data.tracked_trials import path_of, write_trial

FLOW = {"flow": lambda clip, among: Reply(RigidFlow().predict(clip, among), 1.0)}


def judged_rows(path, variants=FLOW, **options):
    return list(data_set_rows(Judge(Run(**options), variants), open_data_set(path)))


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
    return judged_rows(tracked)


def test_trials_are_judged_as_the_papers_two_tasks(judged):
    turns, slides = judged
    assert (turns.case, turns.error) == ("TactileTracking normalflow_dataset, rotation", 0)
    assert (slides.case, slides.error) == ("TactileTracking normalflow_dataset, sliding", 0)
    assert set(turns.detail["recall"]) == {"clockwise", "counterclockwise"}
    assert set(slides.detail["recall"]) == {"right"}


def test_a_row_tells_its_thresholds_and_bad_trials(judged):
    detail = judged[0].detail
    assert detail["pairs"]["rule"]["gap_frames"] in (5, 10)
    assert detail["pairs"]["paper_share"] == pytest.approx(3 / 84)
    assert left_out(judged[0]) == "1 whose files cannot be used"
    assert "bead1: gelsight.avi is missing" in detail["first_left_out"][0]


def test_the_rule_is_the_one_whose_count_comes_nearest_to_the_papers_share():
    """One degree a frame, 60 frames: 4,088 of 84 trials are 49 of one; a gap of 10 has 50 pairs."""
    pairs, facts = tracked_pairs(TactileTracking("here", (steady_turn(1.0),)), "rotation")
    assert (facts["rule"]["gap_frames"], facts["found"], len(pairs[0][1])) == (10, 50, 50)


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
    rows = judged_rows(listed)
    assert [(row.case, row.count) for row in rows] == [
        ("manifest touchd, rotation", 3),
        ("manifest touchd, rotation, sensor digit", 1),
        ("manifest touchd, rotation, sensor gsmini", 2),
        ("manifest touchd, sliding", 5),
        ("manifest touchd, sliding, sensor digit", 1),
        ("manifest touchd, sliding, sensor gsmini", 4),
    ]
    assert max(row.error for row in rows) <= 0.25
    assert rows[3].detail["files_left_out"] == 1  # told once it is to be read


def test_a_listed_clip_is_read_whole_and_its_object_is_the_unit(listed):
    cases = list(listed_cases(open_data_set(listed), SLIDES))
    assert {len(case.clip) for case in cases} == {4, 7}
    assert {case.object_id for case in cases} == {case.family for case in cases}
    assert {case.motion for case in cases} == set(SLIDES)


def test_two_data_sets_of_one_name_are_refused(listed):
    with pytest.raises(UsageError, match="another data set is called 'manifest touchd' too"):
        open_data_sets([listed, listed])
