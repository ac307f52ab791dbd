"""The Live tab watches with the same code as the command, and tells events as rows."""

from types import SimpleNamespace

import numpy as np
import pytest

from app import live_tab
from geotlm_lm import GeoTLMError
from tests.app.fakes import FakeAnswerer
from tests.track.recordings import there_and_back
from tests.track.test_idle_tracker import gel, touched


@pytest.fixture(scope="module")
def frames():
    plain = gel()
    return [next(plain) for _ in range(12)] + [touched(next(plain)) for _ in range(28)]


def test_a_recording_is_watched_to_its_end(tmp_path):
    clip = there_and_back()
    np.savez(tmp_path / "clip.npz", frames=clip.frames, fps=clip.fps)
    steps = list(live_tab.watch_recording(FakeAnswerer(), str(tmp_path / "clip.npz")))
    image, rows, account = steps[-1]
    (turn,) = (row for row in rows if row[2] == "turn clockwise")
    assert turn[:2] == pytest.approx([1.0, 1.8], abs=0.25)
    assert float(turn[3].removesuffix(" deg")) == pytest.approx(30, rel=0.25)
    assert [row[2] for row in rows][:1] == ["touch"]
    assert account.startswith("idle gel learnt · 105 frames · turned +")
    assert image.ndim == 3
    assert any(0 < len(told) < len(rows) for _, told, _ in steps)  # events come as they are over


def test_a_recording_without_an_untouched_gel_says_so_at_its_end(frames, tmp_path):
    np.savez(tmp_path / "clip.npz", frames=np.stack(frames[:4]), fps=25.0)
    *_, (_, rows, account) = live_tab.watch_recording(FakeAnswerer(), str(tmp_path / "clip.npz"))
    assert rows == []
    assert "No untouched gel was seen" in account


def test_a_camera_is_followed_frame_by_frame_and_each_session_by_itself(frames):
    one = other = None
    for frame in frames[:6]:
        one, *_ = live_tab.process_frame(FakeAnswerer(), frame, one)
    other, _, _, account = live_tab.process_frame(FakeAnswerer(), frames[0], other)
    assert one.count == 6
    assert other.count == 1
    assert account.startswith("learning the idle gel")


def test_the_times_of_a_camera_count_from_its_first_frame(frames, monkeypatch):
    clock = iter(1e6 + 0.04 * number for number in range(len(frames)))
    monkeypatch.setattr(live_tab, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    following = None
    for frame in frames:
        following, _, rows, _ = live_tab.process_frame(FakeAnswerer(), frame, following)
    assert rows
    assert all(0 <= row[0] <= row[1] <= 0.04 * len(frames) for row in rows)


def test_a_camera_of_another_size_is_followed_from_its_beginning(frames):
    following, *_ = live_tab.process_frame(FakeAnswerer(), frames[0], None)
    following, *_ = live_tab.process_frame(FakeAnswerer(), frames[1][:60, :80], following)
    assert following.count == 1


def test_watching_nothing_is_told():
    with pytest.raises(GeoTLMError, match="^No recording was given; upload one first.$"):
        next(live_tab.watch_recording(FakeAnswerer(), None))


def test_a_recording_that_fails_is_told_by_its_own_name_and_nothing_stays_of_the_one_before(
    tmp_path,
):
    (tmp_path / "broken.npy").write_bytes(b"no recording")
    steps = live_tab.watch_recording(FakeAnswerer(), str(tmp_path / "broken.npy"))
    assert next(steps) == (None, [], "")
    with pytest.raises(GeoTLMError, match="^broken.npy: "):
        next(steps)


def test_watching_ends_with_nothing_left_where_something_else_is_wanted(frames, tmp_path):
    np.savez(tmp_path / "clip.npz", frames=np.stack(frames), fps=25.0)
    path = str(tmp_path / "clip.npz")
    for change in (live_tab.clear_all, lambda wanted: setattr(wanted, "path", "other.npz")):
        wanted = live_tab.WatchRequest()
        steps = live_tab.watch_recording(FakeAnswerer(), path, wanted)
        next(steps)
        assert wanted.path == path
        change(wanted)
        assert list(steps) == [live_tab.NOTHING]


def test_a_camera_is_followed_anew_after_everything_was_emptied(frames):
    wanted, following = live_tab.WatchRequest(), None
    for frame in frames[:3]:
        following, *_ = live_tab.process_frame(FakeAnswerer(), frame, following, wanted)
    assert live_tab.clear_all(wanted) == live_tab.NOTHING
    # What was on its way then comes back with the next frame, and must not go on.
    following, _, rows, _ = live_tab.process_frame(FakeAnswerer(), frames[3], following, wanted)
    assert (following.count, rows) == (1, [])
