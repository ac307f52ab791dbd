from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.core.labels import DIRECTED, ROTATIONS, Motion
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.randomise import random_scenes
from geotlm_lm.simulation.scene import GELSIGHT_MINI
from geotlm_lm.simulation.simulate import simulate, simulate_series


def test_every_motion_is_drawn_equally_often():
    scenes = random_scenes(1, 40, objects=("block",))
    assert Counter(scene.motion for scene in scenes) == dict.fromkeys(Motion, 4)


def test_a_scene_depends_only_on_its_place_in_the_series():
    whole = random_scenes(1, 20, objects=TRAINING_OBJECTS)
    assert random_scenes(1, 6, objects=TRAINING_OBJECTS, first_index=9) == whole[9:15]
    assert random_scenes(2, 20, objects=TRAINING_OBJECTS) != whole


def test_few_rotations_are_unreadable_and_claimed_motions_touch():
    scenes = random_scenes(7, 60, objects=TRAINING_OBJECTS, motions=DIRECTED)
    clips = simulate(scenes, seed=7)
    turning = [clip.label for clip in clips if clip.label.motion in ROTATIONS]
    assert np.mean([label.is_readable for label in turning]) >= 0.85
    touched = [min(clip.label.contact_fraction) >= 0.01 for clip in clips]
    assert np.mean(touched) >= 0.9
    assert all(clip.status.is_converged for clip in clips)


@pytest.fixture(scope="module")
def many():
    return random_scenes(3, 300, objects=("block", "ball_medium"))


def test_markers_are_off_unless_asked_for_and_change_nothing_else(many):
    assert all(scene.optics.markers is None for scene in many)
    marked = random_scenes(3, 40, objects=("block", "ball_medium"), marker_share=1.0)
    assert all(scene.optics.markers is not None for scene in marked)
    bare = [replace(s, optics=replace(s.optics, markers=None), gel_name="mini") for s in marked]
    assert bare == many[:40]


def test_the_plain_series_is_what_it_was():
    scene = random_scenes(7, 1, objects=("key", "block"), first_index=5)[0]
    optics, shared = scene.optics, {"rel": 1e-12}
    assert (scene.gel_name, optics.lamps) == ("mini", GELSIGHT_MINI)
    assert optics.mm_per_px_x == pytest.approx(0.06730942355334874, **shared)
    assert optics.light_gain[0] == pytest.approx(1.182275839004647, **shared)
    assert optics.depth_gain[2] == pytest.approx(0.1077306125852668, **shared)
    assert optics.steep_darkening == pytest.approx(0.2806147638738479, **shared)
    assert scene.path.x_mm[-1] == pytest.approx(-2.7067174465496784, **shared)


def test_hands_are_steady_unless_asked_for_and_what_is_touched_is_drawn_before():
    objects = ("block", "ball_medium")
    steady = random_scenes(3, 40, objects=objects, motions=DIRECTED)
    unsteady = random_scenes(3, 40, objects=objects, motions=DIRECTED, unsteady_share=1.0)
    assert [s.body for s in unsteady] == [s.body for s in steady]

    def least_turn(scenes):
        paths = [s.path.rotation_rad for s in scenes if s.motion in ROTATIONS]
        return min(abs(path[-1] - path[0]) for path in paths)

    assert least_turn(unsteady) < np.radians(3) < least_turn(steady)


def test_a_series_is_its_scenes_simulated():
    scenes = random_scenes(9, 3, objects=TRAINING_OBJECTS, first_index=4, motions=DIRECTED)
    expected = simulate(scenes, seed=9, first_index=4)
    clips = simulate_series(9, 3, objects=TRAINING_OBJECTS, first_index=4, motions=DIRECTED)
    for clip, same in zip(clips, expected, strict=True):
        assert clip.label == same.label
        assert np.array_equal(clip.clip.frames, same.clip.frames)


def test_half_the_clips_come_out_of_a_video_and_some_out_of_jpegs(many):
    videos = [s.optics.video is not None for s in many]
    images = [s.optics.jpeg_quality is not None for s in many]
    assert np.mean(videos) == pytest.approx(0.5, abs=0.09)
    assert any(images)
    assert not np.any(np.logical_and(videos, images))
