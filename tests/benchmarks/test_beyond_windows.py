import numpy as np

from geotlm_lm.benchmarks.cases.beyond_windows import (
    NoContactWindows,
    backwards,
    pressed_in,
    whole_recordings,
)
from geotlm_lm.core.labels import Motion
from geotlm_lm.data.touch_table import DirectedRow, TouchRow, UntouchedRow


def numbered(folder, name, count):
    """A recording whose frame k has the grey level 10 + k."""
    levels = np.arange(10, 10 + count, dtype=np.uint8)[:, None, None, None]
    np.save(folder / name, np.broadcast_to(levels, (count, 16, 16, 3)))
    return folder / name


def levels(clip):
    return (clip.frames[:, 0, 0, 0].astype(int) - 10).tolist()


def test_recordings_without_contact_are_cut_into_seconds(tmp_path):
    row = UntouchedRow(numbered(tmp_path, "a.npy", 27), 10.0, "sponge", "sponges")
    cases = list(NoContactWindows([row])())
    # The first six frames are the background; of the 21 others two seconds fit.
    assert [levels(case.clip) for case in cases] == [[6, 9, 12, 15], [16, 19, 22, 25]]
    assert {case.motion for case in cases} == {Motion.NONE}
    assert (cases[0].object_id, cases[0].family) == ("sponge", "sponges")
    assert (cases[0].clip.background == 13).all()  # the mean of frames 1 to 5


def test_a_recording_shorter_than_a_window_is_counted(tmp_path):
    windows = NoContactWindows([UntouchedRow(numbered(tmp_path, "a.npy", 3), 25.0, "a", "a")])
    assert list(windows()) == []
    assert windows.too_short == 1


def test_a_press_ends_before_the_first_turn_and_is_a_release_backwards(tmp_path):
    path = numbered(tmp_path, "a.npy", 40)
    rows = [
        TouchRow(path, 25.0, 20, 35, "cap", "caps", still_until=26),
        TouchRow(path, 25.0, 20, 35, "cap", "caps", still_until=21),
        TouchRow(path, 25.0, 20, 35, "cap", "caps"),
    ]
    (press,) = pressed_in(rows)
    assert levels(press.clip) == [17, 20, 23, 26]
    assert (press.motion, press.family) == (Motion.PRESS, "caps")
    (release,) = backwards([press])
    assert levels(release.clip) == [26, 23, 20, 17]
    assert (release.motion, release.family) == (Motion.RELEASE, "caps")


def test_a_whole_recording_is_read_with_all_its_frames(tmp_path):
    path = tmp_path / "clip.npy"
    frames = np.random.default_rng(0).integers(100, 120, (12, 32, 32, 3))
    np.save(path, frames.astype(np.uint8))
    (case,) = whole_recordings([DirectedRow(path, Motion.CLOCKWISE, "cap", "caps")])
    assert case.clip.frame_numbers == tuple(range(12))
    assert (case.motion, case.object_id, case.family) == (Motion.CLOCKWISE, "cap", "caps")
