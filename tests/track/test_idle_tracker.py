"""The idle gel is learnt while nothing touches, also where a stream starts touched."""

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.recordings.idle import FAINT_IMPRINT
from geotlm_lm.track.exposure import LEARNING_FRAMES, STEADY_FRAMES, IdleTracker

ROWS, COLUMNS = 120, 160


def gel(seed=0):
    """Return frames without end of a shaded, noisy gel."""
    rng = np.random.default_rng(seed)
    shading = 110 + 30 * np.linspace(-1, 1, COLUMNS)[None, :, None]
    while True:
        noisy = shading + rng.normal(0, 1.5, (ROWS, COLUMNS, 3))
        yield np.clip(noisy, 0, 255).astype(np.uint8)


def touched(frame):
    frame = frame.copy()
    frame[40:80, 60:70] += 60
    return frame


def test_nothing_is_told_until_frames_agree():
    tracker, frames = IdleTracker(), gel()
    strengths = [tracker.strength(next(frames)) for _ in range(LEARNING_FRAMES)]
    assert strengths[:-1] == [None] * (LEARNING_FRAMES - 1)
    assert strengths[-1] < FAINT_IMPRINT


def test_a_touch_that_stays_is_never_learnt():
    tracker, frames = IdleTracker(), gel()
    for _ in range(LEARNING_FRAMES):
        tracker.strength(next(frames))
    strengths = [tracker.strength(touched(next(frames))) for _ in range(4 * STEADY_FRAMES)]
    assert min(strengths) > 2 * FAINT_IMPRINT


def test_a_stream_that_starts_touched_learns_the_gel_once_it_is_free():
    tracker, frames = IdleTracker(), gel()
    for _ in range(2 * LEARNING_FRAMES):
        tracker.strength(touched(next(frames)))
    freed = [tracker.strength(next(frames)) for _ in range(2 * STEADY_FRAMES)]
    assert freed[0] > FAINT_IMPRINT
    assert freed[-1] < FAINT_IMPRINT
    idle = tracker.background.astype(float)
    assert np.abs(idle[40:80, 60:70] - next(frames)[40:80, 60:70]).mean() < 3


def test_a_change_of_size_is_told_with_both_sizes():
    tracker, frames = IdleTracker(), gel()
    tracker.strength(next(frames))
    with pytest.raises(UnreadableClip) as caught:
        tracker.strength(next(frames)[:60, :80])
    assert str(caught.value) == (
        "A frame of the stream is 80 x 60 pixels after 160 x 120, expected one size; keep the "
        "camera's resolution and start again."
    )


def test_slow_light_is_followed():
    tracker, frames = IdleTracker(), gel()
    for step in range(300):
        frame = next(frames)
        shift = min(step / 100, 2)
        assert (tracker.strength(np.clip(frame + shift, 0, 255).astype(np.uint8)) or 0) < 0.75
    assert tracker.background.mean() == pytest.approx(next(frames).mean() + 2, abs=0.7)


def dots(noise=0.0, seed=0):
    """Return frames without end of a gel with dots that creep, and whose camera is that noisy."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:ROWS, :COLUMNS].astype(float)
    for number in range(10**6):
        away = np.hypot((x + number / 200) % 14 - 7, y % 14 - 7)
        plain = 110 + 30 * np.linspace(-1, 1, COLUMNS)[None, :] - 60 * np.exp(-((away / 2.2) ** 2))
        # What an animation's palette does: patches of noise, not single pixels of it.
        grain = cv2.GaussianBlur(rng.normal(0, 1, (ROWS, COLUMNS, 3)), (0, 0), 3)
        frame = plain[..., None] + noise * grain / grain.std()
        yield np.clip(frame, 0, 255).astype(np.uint8)


@pytest.mark.parametrize("noise", [0.0, 2.5])
@pytest.mark.parametrize("is_known", [False, True])
def test_the_touch_of_a_gel_with_dots_is_seen_however_noisy_it_is(noise, is_known):
    frames = dots(noise)
    tracker = IdleTracker(next(dots()) if is_known else None)
    strengths = [tracker.strength(next(frames)) or 0.0 for _ in range(4 * LEARNING_FRAMES)]
    assert max(strengths[1:]) < FAINT_IMPRINT  # one frame alone does not tell its noise
    strengths = [tracker.strength(touched(next(frames))) for _ in range(2 * LEARNING_FRAMES)]
    assert min(strengths) > FAINT_IMPRINT
