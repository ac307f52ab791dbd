"""The last frames of a stream stand for a motion that is over."""

import numpy as np
import pytest

from geotlm_lm.track.recent import APART_S, KEPT_FRAMES, RecentFrames
from tests.track.tracks import happened

IDLE = np.zeros((48, 64, 3), np.uint8)


@pytest.mark.parametrize("fps", [10.0, 25.0, 60.0])
def test_frames_of_an_event_are_kept_evenly_at_any_rate(fps):
    recent = RecentFrames(fps)
    for number in range(1000):
        recent.add(np.full_like(IDLE, number % 250), number, number / fps)
    clip = recent.clip_of(happened("turn", 960, 990), IDLE)
    apart = np.diff(clip.frame_numbers)
    assert set(apart) == {max(round(APART_S * fps + 0.4), 1)}
    assert [int(one.mean()) for one in clip.frames] == [k % 250 for k in clip.frame_numbers]
    assert (clip.fps, clip.background is IDLE) == (fps, True)
    assert 960 <= clip.frame_numbers[0] < clip.frame_numbers[-1] <= 990


def test_what_is_gone_makes_no_clip():
    recent = RecentFrames(25.0)
    for number in range(20 * KEPT_FRAMES):
        recent.add(IDLE, number, number / 25)
    assert recent.clip_of(happened("turn", 0, 90), IDLE) is None
    assert len(recent.clip_of(happened("turn", 0, 20 * KEPT_FRAMES), IDLE)) == KEPT_FRAMES
