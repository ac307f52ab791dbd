"""Signs are read from the pictures themselves, not from the path that was asked for."""

from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.randomise import random_scenes
from geotlm_lm.simulation.scene import Body, Optics, Path, Scene
from geotlm_lm.simulation.simulate import simulate

QUIET = Optics(noise_grey=(0.3, 0.3, 0.3), drift_grey=0.0)


def scene(motion=Motion.STILL, *, body="letter_l", depth=0.6, x=(0, 0), y=(0, 0), turn=(0, 0)):
    depths = depth if isinstance(depth, tuple) else (depth, depth)
    return Scene(Body(body, variant=2), Path(depths, x, y, turn), motion, optics=QUIET)


def imprint(clip, frame):
    difference = clip.clip.frames[frame].astype(float) - clip.clip.background
    strength = np.abs(difference).sum(axis=2)
    return np.where(strength > 25, strength, 0)


def centroid(image):
    rows, columns = np.indices(image.shape)
    return np.array([(image * columns).sum(), (image * rows).sum()]) / image.sum()


@pytest.mark.parametrize(
    ("motion", "x", "y"),
    [
        (Motion.RIGHT, 1.0, 0.0),
        (Motion.LEFT, -1.0, 0.0),
        (Motion.DOWN, 0.0, 1.0),
        (Motion.UP, 0.0, -1.0),
    ],
)
def test_a_slide_carries_the_imprint_the_way_its_label_says(motion, x, y):
    clip = simulate([scene(motion, x=(0, x), y=(0, y))], seed=1)[0]
    moved = centroid(imprint(clip, 1)) - centroid(imprint(clip, 0))
    expected = np.array([x / QUIET.mm_per_px_x, y / QUIET.mm_per_px_y])
    # Uneven light weighs the imprint's parts differently in two places: 2.5 of 11 or 15 pixels.
    assert moved == pytest.approx(expected, abs=2.5)
    seen = clip.displacement_px[1][clip.contact[1] > 0.3].mean(axis=0)
    assert seen == pytest.approx(expected, abs=0.1)


@pytest.mark.parametrize(("motion", "sign"), [(Motion.CLOCKWISE, 1), (Motion.COUNTERCLOCKWISE, -1)])
def test_a_rotation_turns_the_imprint_the_way_its_label_says(motion, sign):
    square = replace(QUIET, mm_per_px_x=0.08, mm_per_px_y=0.08)
    turned = replace(scene(motion, body="bar_narrow", turn=(0.2, 0.2 + sign * 0.35)), optics=square)
    clip = simulate([turned], seed=1)[0]
    angles = []
    for frame in range(2):
        image = imprint(clip, frame)
        rows, columns = np.indices(image.shape) - centroid(image)[::-1, None, None]
        second = [(image * a).sum() for a in (columns**2 - rows**2, 2 * columns * rows)]
        # Principal axis of the bar, measured from x (right) towards y (down): clockwise positive.
        angles.append(0.5 * np.arctan2(second[1], second[0]))
    assert angles[1] - angles[0] == pytest.approx(sign * 0.35, abs=0.06)
    assert clip.label.rotation_deg == pytest.approx(sign * np.degrees(0.35))


def test_a_press_grows_the_contact_and_a_release_shrinks_it():
    pressed = simulate([scene(Motion.PRESS, depth=(-0.1, 0.8))], seed=1)[0]
    released = simulate([scene(Motion.RELEASE, depth=(0.8, 0.2))], seed=1)[0]
    assert pressed.label.contact_fraction[0] == 0
    assert pressed.label.contact_fraction[1] > 0.01
    assert pressed.label.depth_change_mm == pytest.approx(0.9)
    assert imprint(pressed, 1).sum() > imprint(pressed, 0).sum()
    assert imprint(released, 1).sum() < imprint(released, 0).sum()


@pytest.mark.parametrize("depth", [0.0, -0.5])
def test_an_untouched_gel_shows_only_noise_and_runs_no_contact(depth):
    clip = simulate([scene(Motion.NONE, depth=depth)], seed=1)[0]
    assert not clip.contact.any()
    assert not clip.depth_mm.any()
    assert not clip.displacement_px.any()
    assert "normal_contact" not in clip.stages
    assert np.abs(clip.clip.frames[0].astype(float) - clip.clip.background).max() <= 4


def test_a_missed_touch_is_no_contact():
    clip = simulate([scene(Motion.STILL, depth=0.01, x=(12, 12))], seed=1)[0]
    assert clip.label.contact_fraction == (0, 0)
    assert clip.status.is_converged


def test_mirrored_paths_of_a_symmetric_body_press_mirrored_imprints():
    right = scene(Motion.RIGHT, body="prism_6", x=(1.0, 1.6), turn=(0.2, 0.3))
    left = scene(Motion.LEFT, body="prism_6", x=(-1.0, -1.6), turn=(-0.2, -0.3))
    one, other = simulate([right], seed=1)[0], simulate([left], seed=1)[0]
    assert np.allclose(one.depth_mm, other.depth_mm[:, :, ::-1], atol=0.004)
    mirrored = other.displacement_px[:, :, ::-1] * (-1, 1)
    both = (one.contact > 0) & (other.contact[:, :, ::-1] > 0)
    assert both.any()
    assert np.allclose(one.displacement_px[both], mirrored[both], atol=1e-3)
    assert one.label.rotation_deg == pytest.approx(-other.label.rotation_deg)


def test_a_smooth_ball_spinning_about_itself_cannot_be_read_but_a_letter_can():
    ball = scene(Motion.CLOCKWISE, body="ball_medium", turn=(0.0, 0.5))
    letter = scene(Motion.CLOCKWISE, body="letter_l", turn=(0.0, 0.5))
    seen = [clip.label.is_readable for clip in simulate([ball, letter], seed=1)]
    assert seen == [False, True]


def test_a_clip_is_the_same_alone_in_a_batch_and_from_the_middle_of_one():
    scenes = random_scenes(5, 12, objects=TRAINING_OBJECTS)
    batch = simulate(scenes, seed=5)
    for index in (0, 7, 11):
        alone = simulate([scenes[index]], seed=5, first_index=index)[0]
        for name in ("displacement_px", "contact", "depth_mm"):
            assert getattr(alone, name).tobytes() == getattr(batch[index], name).tobytes()
        assert alone.clip.frames.tobytes() == batch[index].clip.frames.tobytes()
        assert alone.clip.background.tobytes() == batch[index].clip.background.tobytes()
        assert alone.label == batch[index].label


def test_the_gel_drifts_with_the_object_where_it_touches():
    made = simulate([scene(Motion.RIGHT, x=(0.0, 0.3))], seed=1, with_drift=True)[0]
    inside = made.contact[1] > 0.3
    moved = made.drift_px[1] - made.drift_px[0]
    object_px = made.displacement_px[1, ..., 0][inside].mean()
    assert 0.5 * object_px < moved[..., 0][inside].mean() <= 1.02 * object_px
    assert abs(moved[..., 1][inside].mean()) < 0.1 * object_px


def test_a_preset_that_does_not_exist_is_named():
    with pytest.raises(UsageError, match="no preset 'best'; choose one of draft, fast"):
        simulate([scene(Motion.STILL)], seed=1, preset="best")
