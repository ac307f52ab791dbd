"""The idle gel: exact where it is a polynomial, found where the recording shows it, else None."""

import csv

import cv2
import numpy as np
import pytest

from geotlm_lm.alignment.dots import activity_grey, is_marked
from geotlm_lm.core.clip import Clip
from geotlm_lm.recordings.idle import REST_FRAMES, estimate_background, find_idle
from geotlm_lm.recordings.read import read_clip
from tests.recordings.dotted import COLUMNS, ROWS, dotted, dotted_recording, shading


def touched(centre, strength=40.0, seed=0):
    """Return a frame with a noisy, bar-shaped imprint, lit from the side like a real one."""
    y, x = np.mgrid[:ROWS, :COLUMNS]
    bar = np.exp(-(((x - centre[0]) / 6) ** 2) - ((y - centre[1]) / 20) ** 2)
    light = np.gradient(bar, axis=1) * 6
    frame = shading() + strength * light[..., None] * [1, 0.6, -1]
    frame = frame + np.random.default_rng(seed).normal(0, 1, frame.shape)
    return np.clip(np.rint(frame), 0, 255).astype(np.uint8)


def recording(strengths, centres=None):
    centres = centres or [(80, 60)] * len(strengths)
    return Clip(
        np.stack(
            [touched(c, s, i) for i, (s, c) in enumerate(zip(strengths, centres, strict=True))]
        )
    )


PRESS = [0] * 6 + [15, 30, 40, 40, 40, 40, 40, 40]


def test_a_smooth_gel_is_estimated_to_within_rounding():
    frames = np.rint(shading()).astype(np.uint8)[None]
    assert np.abs(estimate_background(frames).astype(int) - frames[0]).max() <= 1


def test_an_imprint_drops_out_of_the_estimate():
    frames = np.stack([touched((70 + 6 * i, 60), 40, i) for i in range(4)])
    error = estimate_background(frames) - shading()
    assert np.sqrt(np.square(error).mean()) < 1.5
    assert np.sqrt(np.square(frames - shading()).mean()) > 2.5  # the imprint was worth removing


def test_a_recording_that_starts_untouched_shows_its_idle_gel():
    for strengths in (PRESS, PRESS[::-1]):
        idle = find_idle(recording(strengths))
        assert np.abs(idle - shading()).mean() < 1
    assert find_idle(recording([0] * 12)) is None


def test_an_object_that_moves_in_contact_all_the_time_shows_no_idle_gel():
    centres = [(40, 60)] * 6 + [(40 + 10 * i, 60) for i in range(1, 9)]
    assert find_idle(recording([40] * 14, centres)) is None


REST = [0] * REST_FRAMES
HELD = [10, 25, 40, 40, 40, 40, 40, 40]


@pytest.mark.parametrize("how", [{}, {"drift": 0.03}, {"worn": 3}, {"noise": 5.0}])
@pytest.mark.parametrize("strengths", [[0] * 6 + HELD, HELD[::-1] + REST, HELD[::-1] + REST + HELD])
def test_a_gel_with_dots_that_rests_untouched_shows_its_idle_gel(strengths, how):
    clip = dotted_recording(strengths, **how)
    assert is_marked(activity_grey(clip.frames))
    idle = find_idle(clip)
    assert np.abs(idle - dotted(0, noise=0.0, worn=how.get("worn", 1)).astype(float)).mean() < 4
    assert np.abs(idle - dotted(40, noise=0.0).astype(float)).max() > 30


@pytest.mark.parametrize(
    "strengths",
    [[0] * 20, [40] * 20, HELD[::-1], HELD, [40] * 15 + list(range(40, 25, -1)), [0, 0, 40, 40]],
)
def test_a_gel_with_dots_that_does_not_rest_untouched_shows_none(strengths):
    assert find_idle(dotted_recording(strengths)) is None


def test_an_object_without_dots_is_no_marked_gel():
    assert not is_marked(activity_grey(recording([40] * 4).frames))
    noise = np.random.default_rng(0).integers(95, 120, (1, 48, 64, 3)).astype(np.uint8)
    assert not is_marked(activity_grey(noise))


@pytest.mark.real
def test_real_recordings_of_gels_with_dots_show_their_idle_gel_where_they_begin_untouched(real):
    with (real / "marked" / "gelslim4" / "labels.csv").open() as stream:
        clips = [
            read_clip(real / "marked" / "gelslim4" / row["clip"]) for row in csv.DictReader(stream)
        ]
    # All but one, whose pad moves as a whole.
    assert sum(find_idle(clip) is not None for clip in clips) >= 5
    for folder in sorted((real / "marked" / "letac_release_long").glob("*_tr*"))[::4]:
        assert find_idle(read_clip(folder)) is None  # a grip that opens, and keeps its object


@pytest.mark.real
def test_real_recordings_show_their_idle_gel(real):
    with (real / "physiclear" / "clips.csv").open() as stream:
        rows = [row for row in csv.DictReader(stream) if row["tier"] == "A"][::9]
    errors = []
    for row in rows:
        clip = read_clip(real / "physiclear" / row["clip"])
        start = int(row["contact_start"])
        seen = np.median(clip.frames[start // 2 : start - 2], axis=0)
        idle = find_idle(clip)
        errors.append(np.inf if idle is None else np.sqrt(np.square(idle - seen).mean()))
    # Measured on 111 recordings: found in 78 % (faint cloth is missed), 1.0 grey levels rms off.
    assert np.isfinite(errors).mean() > 0.66
    assert np.median(errors) < 1.5


@pytest.mark.real
def test_the_estimate_from_real_ball_presses_is_nearer_the_idle_gel_than_the_presses_are(real):
    folder = real / "calibration" / "ball_press"
    idle = cv2.imread(str(folder / "background.png")).astype(float)
    presses = [cv2.imread(str(path)) for path in sorted(folder.glob("6.310mm_*.png"))[:4]]
    error = estimate_background(np.stack(presses)) - idle
    touched_pixels = np.abs(np.stack(presses) - idle).max(axis=-1) > 20
    inside = touched_pixels.any(axis=0)
    before = np.abs(np.stack(presses) - idle)[touched_pixels].mean()
    assert np.abs(error)[inside].mean() < 0.7 * before
