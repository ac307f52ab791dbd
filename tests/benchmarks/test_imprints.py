"""Real imprints that are held and moved: where they go, and what lies under them."""

from collections import Counter

import numpy as np
import pytest

from geotlm_lm.benchmarks.imprints import CUTS, carried, moved_imprints, semi_real_slides
from geotlm_lm.core.edit import opposite
from geotlm_lm.core.labels import SLIDES, Motion
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
    change -= np.median(change, axis=(1, 2), keepdims=True)
    weight = np.square(change) * (np.abs(change) > 3)
    rows, columns = np.mgrid[:ROWS, :COLUMNS]
    return np.stack([[(w * columns).sum(), (w * rows).sum()] / w.sum() for w in weight])


def test_the_four_ways_come_in_turn_and_each_is_played_backwards_too(tmp_path):
    rows = [recording(tmp_path, f"{k}.npy", blob(80, 60)) for k in range(4)]
    made = list(semi_real_slides(rows, seed=0))
    truths = [case.motion for case in made]
    assert truths[::2] == list(SLIDES)
    assert truths[1::2] == [opposite(motion) for motion in SLIDES]
    for case in made:
        places = middles(case.clip)
        travel, along = places[-1] - places[0], np.array(TOWARDS[case.motion])
        assert np.hypot(*travel) == pytest.approx(case.amount, rel=0.1)
        assert 0.015 * COLUMNS < travel @ along < 0.13 * COLUMNS
        assert abs(travel @ along[::-1]) < 0.5 * (travel @ along)


def test_imprints_cut_off_or_faint_are_left_out_and_counted(tmp_path):
    rows = [
        recording(tmp_path, "whole.npy", blob(80, 60), "whole.npy"),
        recording(tmp_path, "cut.npy", blob(4, 60)),
        recording(tmp_path, "faint.npy", blob(80, 60, strength=0.5)),
    ]
    left_out = Counter()
    slides = semi_real_slides(rows, 0, left_out)
    assert {case.family for case in slides} == {"whole.npy"}
    assert left_out == {"cut_off_left_out": 2}


@pytest.fixture(scope="module")
def moved(tmp_path_factory):
    folder = tmp_path_factory.mktemp("real") / "physiclear"
    (folder / "clips").mkdir(parents=True)
    recording(folder / "clips", "cap.npy", blob(80, 60))
    frames = np.load(folder / "clips" / "cap.npy")
    frames[1:6] += np.arange(5, dtype=np.uint8)[:, None, None, None]  # tells idle frames apart
    frames[8:] += 2
    np.save(folder / "clips" / "cap.npy", frames)
    (folder / "clips.csv").write_text(
        "clip,object,fps,contact_start,contact_end\nclips/cap.npy,cap,25,9,11\n"
    )
    return list(moved_imprints(folder.parent, sizes_px=(2.0,), held=2))


def test_an_imprint_goes_each_way_by_the_path_asked_for(moved):
    four = {own.way: own for own in moved if own.frames == "four" and own.path_px}
    assert len(four) == 4
    assert {own.path_px for own in four.values()} == {2.0}
    for way in SLIDES[2:]:
        places = middles(four[way].clip)
        assert (places[-1] - places[0]) @ TOWARDS[way] == pytest.approx(2.0 * ROWS / 224, abs=0.15)
    turned = [four[way].clip for way in (Motion.CLOCKWISE, Motion.COUNTERCLOCKWISE)]
    # The picture falls from left to right. Turned clockwise, it falls downwards too.
    bright, dark = (clip.frames[-1, 48:56, 78:83].astype(int).mean() for clip in turned)
    assert bright > dark + 1
    assert np.linalg.norm(np.diff(middles(turned[0])[[0, -1]], axis=0)) < 0.3


def test_what_is_held_or_untouched_lies_over_real_idle_frames_in_turn(moved):
    by_way = {}
    for own in moved:
        by_way.setdefault((own.way, own.frames), []).append(own.clip)
    held, untouched = by_way[Motion.STILL, "four"], by_way[Motion.NONE, "four"]
    assert (len(held), len(untouched)) == (2, 1)
    for clip in (*held, *untouched):
        steps = np.diff(clip.frames[:, 0, 0, 0].astype(int))
        assert set(np.sign(steps)) in ({1}, {-1})  # four different idle frames, in order
    assert np.linalg.norm(np.diff(middles(held[0])[[0, -1]], axis=0)) < 0.2
    pair = by_way[Motion.STILL, "pair"][0].frames
    assert np.array_equal(pair, held[0].frames[list(CUTS["pair"])])
    press, release = by_way[Motion.PRESS, "four"][0], by_way[Motion.RELEASE, "four"][0]
    assert np.array_equal(release.frames, press.frames[::-1])
    strength = np.abs(press.frames[..., 1].astype(float) - press.background[..., 1]).max((1, 2))
    assert strength[0] < 0.5 * strength[-1]


def dotted():
    """Dots of two pixels' deviation, twelve pixels apart, the same shade all over."""
    rows, columns = np.mgrid[:ROWS, :COLUMNS]
    apart = [(axis % 12 - 6) ** 2 for axis in (rows, columns)]
    dots = np.exp(-sum(apart) / (2 * 2.0**2))
    return np.repeat(200 - 120 * dots[..., None], 3, axis=2).astype(np.float32)


def shift(before, after):
    """Least squares shift right and down of a small piece of two green pictures."""
    first, last = (image[..., 1].astype(float) for image in (before, after))
    down, right = np.gradient((first + last) / 2)
    slopes = np.stack([right.ravel(), down.ravel()])
    return -np.linalg.solve(slopes @ slopes.T, slopes @ (last - first).ravel())


@pytest.mark.parametrize("path_px", [(0.1, 0.0), (0.0, -0.3), (0.3, 0.1)])
def test_dots_go_along_about_the_contact_and_stay_at_the_rim(path_px):
    idle, noise = dotted(), np.zeros((4, 1, 1, 1), np.float32)
    noise[:, 0, 0, 0] = [1, -1, 2, -2]
    clip = carried(blob(80, 60), (idle + noise, idle), path_px=path_px, has_dots=True)
    frames = clip.frames - noise
    piece = np.s_[40:80, 55:105]
    assert shift(frames[0][piece], frames[-1][piece]) == pytest.approx(path_px, abs=0.02)
    for rim in (np.s_[:1], np.s_[-1:], np.s_[:, :1], np.s_[:, -1:]):
        assert np.abs(frames[-1][rim] - frames[0][rim]).max() <= 1
    held = carried(blob(80, 60), (idle + noise, idle), has_dots=True).frames - noise
    assert np.abs(held - held[0]).max() <= 1


def test_dots_turn_about_the_contact():
    idle, about = dotted(), (84.0, 60.0)
    gel = (np.stack([idle] * 4), idle)
    frames = carried(blob(84, 60), gel, turn_deg=3.0, about=about, has_dots=True).frames
    for x, y in ((20, 0), (-20, 0), (0, 20), (0, -20)):
        piece = np.s_[60 + y - 8 : 61 + y + 8, 84 + x - 8 : 85 + x + 8]
        expected = np.radians(3.0) * np.array([-y, x])
        assert shift(frames[0][piece], frames[-1][piece]) == pytest.approx(expected, abs=0.1)


@pytest.mark.parametrize("path_px", [0.1, 0.3, 0.6])
def test_a_small_motion_is_as_large_as_asked_for(path_px):
    ground = np.full((4, ROWS, COLUMNS, 3), 100, np.float32)
    clip = carried(blob(80, 60), (ground, ground[0]), path_px=(path_px, 0.0))
    piece = np.s_[20:100, 30:130]
    found = shift(clip.frames[0][piece], clip.frames[-1][piece])
    assert found == pytest.approx((path_px, 0.0), abs=0.02)
