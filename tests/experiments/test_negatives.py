import numpy as np

from geotlm_lm.core.labels import Motion
from geotlm_lm.data.touch_table import TouchRow, UntouchedRow
from geotlm_lm.experiments.compare import Reply
from geotlm_lm.experiments.folder_tables import judge_negatives
from geotlm_lm.experiments.negatives import NoContactWindows, PressedIn, backwards


def numbered(folder, name, count):
    """A recording whose frame k has the grey level 10 + k."""
    levels = np.arange(10, 10 + count, dtype=np.uint8)[:, None, None, None]
    np.save(folder / name, np.broadcast_to(levels, (count, 16, 16, 3)))
    return folder / name


def levels(clip):
    return (clip.frames[:, 0, 0, 0].astype(int) - 10).tolist()


def test_recordings_without_contact_are_cut_into_seconds(tmp_path):
    row = UntouchedRow(numbered(tmp_path, "a.npy", 27), 10.0, "sponge", "sponges")
    cases = list(NoContactWindows([row]))
    # The first six frames are the background; of the 21 others two seconds fit.
    assert [levels(case.clip) for case in cases] == [[6, 9, 12, 15], [16, 19, 22, 25]]
    assert {case.motion for case in cases} == {Motion.NONE}
    assert (cases[0].object_id, cases[0].family) == ("sponge", "sponges")
    assert (cases[0].clip.background == 13).all()  # the mean of frames 1 to 5


def test_a_recording_shorter_than_a_window_is_counted(tmp_path):
    windows = NoContactWindows([UntouchedRow(numbered(tmp_path, "a.npy", 3), 25.0, "a", "a")])
    assert list(windows) == []
    assert windows.too_short == 1


def test_a_press_ends_before_the_first_turn(tmp_path):
    path = numbered(tmp_path, "a.npy", 40)
    rows = [
        TouchRow(path, 25.0, 20, 35, "cap", "caps", still_until=26),
        TouchRow(path, 25.0, 20, 35, "cap", "caps", still_until=21),
        TouchRow(path, 25.0, 20, 35, "cap", "caps"),
    ]
    found = PressedIn(rows)
    (case,) = found
    assert len(found) == 1
    assert levels(case.clip) == [17, 20, 23, 26]
    assert (case.motion, case.family) == (Motion.PRESS, "caps")


def test_a_press_played_backwards_is_a_release(tmp_path):
    row = TouchRow(numbered(tmp_path, "a.npy", 40), 25.0, 20, 35, "cap", "caps", still_until=26)
    (case,) = backwards(PressedIn([row]))
    assert levels(case.clip) == [26, 23, 20, 17]
    assert (case.motion, case.family) == (Motion.RELEASE, "caps")


def test_every_claim_on_a_negative_is_held_against_the_clip_played_backwards(tmp_path):
    row = TouchRow(numbered(tmp_path, "a.npy", 40), 25.0, 20, 35, "cap", "caps", still_until=26)

    def by_time(clip, among):
        rises = levels(clip)[-1] > levels(clip)[0]
        return Reply(Motion.UP if rises else Motion.DOWN, 1.0)

    def by_habit(clip, among):
        return Reply(Motion.LEFT, 1.0)

    def sees_none(clip, among):
        return Reply(Motion.NONE, 1.0)

    methods = {"by time": by_time, "by habit": by_habit, "sees none": sees_none}
    tables = judge_negatives(
        methods, "here", [row], [], 0, lambda *_: None, contrasts=(("by time", "by habit"),)
    )
    assert tables["real here, pressed in"]["claims"] == {
        "by time": {"directions": 1, "turned_round": 1},
        "by habit": {"directions": 1, "turned_round": 0},
        "sees none": {"directions": 0, "turned_round": 0},
    }
