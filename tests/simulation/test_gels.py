"""Kinds of gel: which are drawn, and that a print goes where what it is printed on goes."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.simulation.gels import GELS, HELD_OUT_GELS, TRAINING_GELS, Print, random_print
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.optics import print_shade
from geotlm_lm.simulation.randomise import random_scene, random_scenes
from geotlm_lm.simulation.scene import GELSIGHT_MINI, Optics
from geotlm_lm.simulation.scene import Path as Poses
from geotlm_lm.simulation.simulate import simulate
from geotlm_lm.simulation.truth import patch_means

RIGHT_MM, DOWN_MM = 3 * Optics().mm_per_px_x, -2 * Optics().mm_per_px_y


@pytest.mark.parametrize("printed", [kind for kind in Print if kind is not Print.NONE])
def test_a_print_goes_where_the_gel_goes_unless_it_stands_still(printed):
    drawn = random_print(generator_for(0, printed.value), printed)
    drift = np.ones((2, 224, 224), np.float32) * np.array([RIGHT_MM, DOWN_MM])[:, None, None]
    rest, moved = print_shade(drawn, Optics()), print_shade(drawn, Optics(), drift.astype("f4"))
    assert rest.min() < 0.8
    if printed is Print.STATIC_DOTS:
        assert np.array_equal(moved, rest)
    else:
        shifted = np.roll(rest, (-2, 3), axis=(0, 1))
        assert np.abs(moved - shifted)[20:-20, 20:-20].max() < 0.02


def test_a_pattern_on_gel_that_is_strained_stands_where_its_points_have_gone():
    drawn = random_print(generator_for(1, "strained"), Print.BLOTCHES)
    pixel, middle = Optics().mm_per_px_x, np.arange(224, dtype=np.float32) - 111.5
    drift = np.zeros((2, 224, 224), np.float32)
    drift[0] = 1.5 * pixel * np.sin(middle / 20)
    rest, moved = print_shade(drawn, Optics()), print_shade(drawn, Optics(), drift)
    to = np.arange(224) + drift[0, 0] / pixel
    for row in (40, 150):
        followed = np.interp(to, np.arange(224), moved[row])
        assert np.abs(followed - rest[row])[5:-5].max() < 0.06
        assert np.abs(moved[row] - rest[row]).max() > 0.1


@pytest.mark.parametrize("name", GELS)
def test_on_every_kind_of_gel_the_imprint_shows(name):
    poses = Poses((0.8,) * 2, (-0.5, 0.5), (0.0,) * 2, (0.3,) * 2)
    rng = generator_for(2, name)
    scene = random_scene(rng, object_name="key", motion=Motion.RIGHT, gels={name: 1.0})
    optics = replace(scene.optics, markers=None, video=None, jpeg_quality=None)
    made, bare = simulate(
        [replace(scene, path=poses, optics=o) for o in (scene.optics, optics)], seed=0
    )
    assert (made.gel_name, made.clip.frames.dtype) == (name, np.uint8)
    assert (made.scene.optics.markers is None) == (GELS[name].printed is Print.NONE)
    change = np.abs(bare.clip.frames[0].astype(float) - bare.clip.background).mean(axis=-1)
    change, contact = patch_means(change[None])[0], made.contact[0]
    assert change[contact > 0.3].mean() > 1.5 * change[contact == 0].mean()
    assert made.label.visible_grey[1] > 0


def test_kinds_are_drawn_by_their_shares_and_those_left_out_never_train():
    assert not set(TRAINING_GELS) & set(HELD_OUT_GELS)
    assert sum(TRAINING_GELS.values()) == pytest.approx(1.0)
    scenes = random_scenes(3, 400, objects=("block",), motions=DIRECTED, gels=TRAINING_GELS)
    drawn = Counter(scene.gel_name for scene in scenes)
    assert set(drawn) == set(TRAINING_GELS)
    for name, share in TRAINING_GELS.items():
        assert drawn[name] / 400 == pytest.approx(share, abs=0.05)
    assert np.mean([s.optics.lamps is GELSIGHT_MINI for s in scenes]) == pytest.approx(
        0.54, abs=0.06
    )
    assert np.mean([s.optics.markers is not None for s in scenes]) == pytest.approx(0.41, abs=0.06)
    assert {s.gel.dome == 0 for s in scenes if s.optics.lamps is not GELSIGHT_MINI} == {True, False}


def test_gels_with_dots_that_stand_still_see_small_motions():
    options = {"objects": TRAINING_OBJECTS, "motions": DIRECTED, "gels": {"static dots": 1.0}}
    scenes = random_scenes(4, 12, **options)
    for made in simulate(scenes, seed=4, with_frames=False):
        assert max(made.twist.path(part, made.label.radius_px) for part in ("turn", "slide")) < 2.2


def test_lamps_turn_clockwise_with_what_they_light():
    lamps = GELS["three lamps"].lamps
    once = lamps.turned(1)
    np.testing.assert_allclose(once.rows[0], (-0.7, 0), atol=1e-9)  # from below to the left
    assert once.levels[0, 2, 0] == once.levels[0].max()
    assert lamps.turned(4).rows == lamps.rows
