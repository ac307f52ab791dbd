import numpy as np
import pytest

from geotlm_lm.benchmarks.cases.semi_real import (
    SemiRealSlides,
    carried,
    semi_real_held,
    slide_path,
    untouched_cases,
)
from geotlm_lm.core.labels import SLIDES, Motion, reverse
from geotlm_lm.data.touch_table import TouchRow

ROWS, COLUMNS = 120, 160
TOWARDS = {Motion.LEFT: (-1, 0), Motion.RIGHT: (1, 0), Motion.UP: (0, -1), Motion.DOWN: (0, 1)}


def idle_gel():
    y, x = np.mgrid[:ROWS, :COLUMNS]
    return np.stack([90 + 0.2 * x, 110 + 0.1 * y, 120 - 0.1 * x], -1).astype(np.float32)


def blob(x, y, strength=40.0, radius=14.0):
    rows, columns = np.mgrid[:ROWS, :COLUMNS]
    height = np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / (2 * radius**2))
    return strength * np.stack([np.gradient(height, axis=1) * radius] * 3, -1).astype(np.float32)


def recording(folder, name, imprint, family="caps"):
    """Twelve frames: eight idle, four touched."""
    frames = np.stack([idle_gel()] * 8 + [idle_gel() + imprint] * 4)
    np.save(folder / name, np.clip(np.rint(frames), 0, 255).astype(np.uint8))
    return TouchRow(folder / name, 25.0, 8, 11, name, family)


def middles(clip):
    """Middle of the imprint in every frame, (x, y) in pixels."""
    change = clip.frames[..., 1].astype(float) - clip.background[..., 1]
    weight = np.square(change) * (np.abs(change) > 3)
    rows, columns = np.mgrid[:ROWS, :COLUMNS]
    return np.stack([[(w * columns).sum(), (w * rows).sum()] / w.sum() for w in weight])


def slid(motion):
    rng = np.random.default_rng(3)
    path_px, turn_deg = slide_path(motion, COLUMNS, rng)
    return carried(blob(80, 60), idle_gel(), rng, path_px=path_px, turn_deg=turn_deg)


@pytest.mark.parametrize("motion", SLIDES)
def test_an_imprint_is_carried_the_way_it_is_named(motion):
    clip = slid(motion)
    places = middles(clip)
    across, along = np.array(TOWARDS[motion][::-1]), np.array(TOWARDS[motion])
    travel = places[-1] - places[0]
    assert 0.015 * COLUMNS < travel @ along < 0.13 * COLUMNS
    assert abs(travel @ across) < 0.5 * (travel @ along)


def test_the_four_ways_come_in_turn_and_each_is_played_backwards_too(tmp_path):
    rows = [recording(tmp_path, f"{k}.npy", blob(80, 60)) for k in range(4)]
    made = list(SemiRealSlides(rows, seed=0).made())
    truths = [case.motion for case, _ in made]
    assert truths[::2] == list(SLIDES)
    assert truths[1::2] == [reverse(motion) for motion in SLIDES]
    for case, travel_px in made:
        places = middles(case.clip)
        assert np.hypot(*(places[-1] - places[0])) == pytest.approx(travel_px, rel=0.1)


def test_imprints_cut_off_or_faint_are_left_out_and_counted(tmp_path):
    rows = [
        recording(tmp_path, "whole.npy", blob(80, 60)),
        recording(tmp_path, "cut.npy", blob(4, 60)),
        recording(tmp_path, "faint.npy", blob(80, 60, strength=0.5)),
    ]
    slides = SemiRealSlides(rows, seed=0)
    assert {case.object_id for case in slides} == {"whole.npy"}
    assert slides.cut_off == 2
    assert len(list(semi_real_held(rows, seed=0))) == 3


def test_untouched_cases_show_no_touched_frame(tmp_path):
    (case,) = untouched_cases([recording(tmp_path, "a.npy", blob(80, 60))])
    assert case.motion == Motion.NONE
    change = case.clip.frames.astype(int) - case.clip.background.astype(int)
    assert len(case.clip) == 4
    assert np.abs(change).max() <= 1


def test_a_held_imprint_changes_by_noise_only(tmp_path):
    (still, *_) = semi_real_held([recording(tmp_path, "a.npy", blob(80, 60))], seed=0)
    assert still.motion == Motion.STILL
    change = np.diff(still.clip.frames.astype(int), axis=0)
    assert 0.1 < change.std() < 1.0
    assert np.linalg.norm(middles(still.clip)[-1] - middles(still.clip)[0]) < 0.2


def test_a_pressed_imprint_grows_where_it_is_and_a_release_is_it_backwards(tmp_path):
    _, press, release = semi_real_held([recording(tmp_path, "a.npy", blob(80, 60))], seed=0)
    assert (press.motion, release.motion) == (Motion.PRESS, Motion.RELEASE)
    change = press.clip.frames[..., 1].astype(float) - press.clip.background[..., 1]
    strength = np.abs(change).max(axis=(1, 2))
    # The recorded imprint's steepest point is 24 grey levels; a quarter of it at first.
    assert strength / strength[-1] == pytest.approx([0.25, 0.5, 0.75, 1.0], abs=0.08)
    assert np.linalg.norm(middles(press.clip)[-1] - middles(press.clip)[0]) < 1.0
    assert np.array_equal(release.clip.frames, press.clip.frames[::-1])
