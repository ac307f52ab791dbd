from collections import Counter

import numpy as np

from geotlm_lm.core.labels import DIRECTED, ROTATIONS, Motion
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.randomise import random_scene, random_scenes
from geotlm_lm.simulation.simulate import simulate


def test_every_motion_is_drawn_equally_often():
    scenes = random_scenes(1, 40, objects=("block",))
    assert set(Counter(scene.motion for scene in scenes).values()) == {4}
    assert set(Counter(scene.motion for scene in scenes)) == set(Motion)


def test_a_scene_depends_only_on_its_place_in_the_series():
    whole = random_scenes(1, 20, objects=TRAINING_OBJECTS)
    assert random_scenes(1, 6, objects=TRAINING_OBJECTS, first_index=9) == whole[9:15]
    assert random_scenes(2, 20, objects=TRAINING_OBJECTS) != whole


def test_a_ball_that_rotates_gets_texture_else_its_turn_would_be_unseen():
    for seed in range(10):
        rng = np.random.default_rng(seed)
        drawn = random_scene(rng, object_name="ball_medium", motion=Motion.CLOCKWISE)
        assert drawn.body.texture_um >= 15


def test_few_rotations_are_unreadable_and_claimed_motions_touch():
    scenes = random_scenes(7, 60, objects=TRAINING_OBJECTS, motions=DIRECTED)
    clips = simulate(scenes, seed=7)
    turning = [clip.label for clip in clips if clip.label.motion in ROTATIONS]
    assert np.mean([label.is_readable for label in turning]) >= 0.85
    touched = [min(clip.label.contact_fraction) >= 0.01 for clip in clips]
    assert np.mean(touched) >= 0.9
    assert all(clip.status.is_converged for clip in clips)
