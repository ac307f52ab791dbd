"""Laws: the same examples whatever the number of workers, and after a kill."""

import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.edit import MIRRORED
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, MotionLabel
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.recordings.legible import require_legible
from geotlm_lm.simulation.gels import HELD_OUT_GELS, TRAINING_GELS
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.randomise import random_scenes
from geotlm_lm.simulation.simulate import simulate
from geotlm_lm.simulation.truth import READABLE_GREY
from geotlm_lm.training import examples
from geotlm_lm.training.examples import (
    FAINT_CONTRAST,
    ExampleSet,
    StoredRows,
    _frame_order,
    as_recorded,
    damage_clip,
    mirrored,
    read_examples,
    simulate_examples,
)


@pytest.fixture
def _small_chunks(monkeypatch):
    monkeypatch.setattr(examples, "CHUNK_CLIPS", 4)


def made_in(folder, **options):
    wanted = ExampleSet("check", 8, TRAINING_OBJECTS[:3], **options)
    simulate_examples(folder, [wanted], seed=5, workers=1)
    return read_examples(folder, wanted)


@pytest.mark.usefixtures("_small_chunks")
def test_a_missing_chunk_is_made_again_byte_for_byte(tmp_path):
    first = made_in(tmp_path)
    (tmp_path / "check_0001.npy").unlink()
    again = made_in(tmp_path)
    assert np.array_equal(first.inputs, again.inputs)
    assert np.array_equal(first.displacement_px, again.displacement_px)
    assert first.labels == again.labels
    assert len(first) == 8
    assert set(first.objects) <= set(TRAINING_OBJECTS[:3])
    assert set(first.gels) <= set(TRAINING_GELS)


@pytest.mark.usefixtures("_small_chunks")
def test_a_set_on_kinds_of_gel_left_out_is_never_read_as_one_to_train_on(tmp_path):
    assert set(made_in(tmp_path, is_held_out=True).gels) <= set(HELD_OUT_GELS)
    with pytest.raises(UsageError, match="expected only objects and gels of that set"):
        made_in(tmp_path)


def test_of_a_printed_gel_the_idle_frame_is_rather_guessed(monkeypatch):
    monkeypatch.setattr(examples, "estimate_background", lambda frames: None)
    guessed = {}
    for name in ("mini", "mini, dots"):
        scenes = random_scenes(8, 1, objects=("key",), gels={name: 1.0})
        (made,) = simulate(scenes, seed=8)
        forms = (as_recorded(made, generator_for(1, index)) for index in range(200))
        guessed[name] = np.mean([form.clip.background is None for form in forms])
    assert guessed["mini"] == pytest.approx(0.3, abs=0.08)
    assert guessed["mini, dots"] == pytest.approx(0.4, abs=0.08)


@pytest.mark.usefixtures("_small_chunks")
def test_sets_are_read_one_behind_the_other_each_as_long_as_asked_for(tmp_path):
    sets = [ExampleSet(name, 6, TRAINING_OBJECTS[:3]) for name in ("one", "other")]
    simulate_examples(tmp_path, sets, seed=5, workers=1)
    both = read_examples(tmp_path, *sets)
    parts = [read_examples(tmp_path, one) for one in sets]
    assert [len(both), *map(len, parts)] == [12, 6, 6]
    assert both.labels == parts[0].labels + parts[1].labels
    assert both.objects == parts[0].objects + parts[1].objects
    for name in ("inputs", "motions", "displacement_px", "contact", "depth_mm"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        assert np.array_equal(getattr(both, name), joined)


@pytest.mark.usefixtures("_small_chunks")
def test_as_many_examples_turn_as_slide(tmp_path, monkeypatch):
    monkeypatch.setattr(examples, "CHUNK_CLIPS", 12)
    wanted = ExampleSet("check", 12, TRAINING_OBJECTS[:3], is_varied=False)
    simulate_examples(tmp_path, [wanted], seed=5, workers=1)
    motions = [label.motion for label in read_examples(tmp_path, wanted).labels]
    assert sum(motion in ROTATIONS for motion in motions) == 4
    assert sum(motion in SLIDES for motion in motions) == 4
    assert set(motions) == set(Motion)


def test_a_mirrored_clip_has_mirrored_truth_and_the_same_image_flipped():
    scenes = random_scenes(8, 1, objects=("key",), motions=(Motion.LEFT,))
    (made,) = simulate(scenes, seed=8)
    flipped = mirrored(made)
    assert np.array_equal(flipped.clip.frames[:, :, ::-1], made.clip.frames)
    assert np.array_equal(flipped.clip.background[:, ::-1], made.clip.background)
    assert np.array_equal(flipped.contact[..., ::-1], made.contact)
    there, here = flipped.displacement_px[:, :, ::-1], made.displacement_px
    assert np.array_equal(there[..., 0], -here[..., 0])
    assert np.array_equal(there[..., 1], here[..., 1])
    label = MIRRORED.of_label(made.label)
    assert (label.motion, label.slide_x_mm) == (Motion.RIGHT, -made.label.slide_x_mm)
    assert label.slide_y_mm == made.label.slide_y_mm


@pytest.mark.usefixtures("_small_chunks")
def test_some_clips_are_mirrored_with_their_labels(tmp_path, monkeypatch):
    """All of them here: every displacement must agree with its label's sign."""
    monkeypatch.setattr(examples, "MIRRORED_SHARE", 1.0)
    flipped = made_in(tmp_path / "flipped")
    monkeypatch.setattr(examples, "MIRRORED_SHARE", 0.0)
    plain = made_in(tmp_path / "plain")
    assert [MIRRORED.of_label(label) for label in flipped.labels] == list(plain.labels)
    assert not np.array_equal(flipped.inputs, plain.inputs)


def test_four_frames_run_forwards_or_form_a_pair_one_or_two_frames_apart():
    orders = {tuple(_frame_order(generator_for(0, index))) for index in range(200)}
    assert orders == {(0, 1, 2, 3), (0, 0, 1, 1), (0, 0, 2, 2)}


def test_stored_rows_are_those_of_the_arrays_one_behind_the_other():
    values = np.arange(7 * 2 * 3).reshape(7, 2, 3).astype(np.float16)
    stored = StoredRows([values[:4], values[4:]])
    assert len(stored) == 7
    slices = slice(None), slice(2, 6), slice(5, 99)
    for rows in (*slices, np.array([6, 0, 3, 4, 3]), np.array([], int)):
        assert stored[rows].dtype == values.dtype
        np.testing.assert_array_equal(stored[rows], values[rows])
    np.testing.assert_array_equal(np.concatenate([stored]), values)
    with pytest.raises(IndexError):
        stored[np.array([7])]


IDLE = np.full((32, 32, 3), 120, np.uint8)
TOUCHED = np.stack([IDLE + np.uint8(level) for level in (40, 42, 44, 46)])
CLIP = Clip(TOUCHED, background=IDLE)


def label(motion):
    return MotionLabel(
        motion=motion,
        rotation_deg=0.0,
        slide_x_mm=0.0,
        slide_y_mm=0.0,
        depth_change_mm=0.0,
        contact_fraction=(0.2,) * 4,
        is_readable=True,
    )


def drawn(motion, change_grey, count=120):
    return [
        damage_clip(CLIP, label(motion), change_grey, np.random.default_rng(seed))
        for seed in range(count)
    ]


def test_damage_changes_pixels_and_keeps_form_and_motion():
    for clip, told in drawn(Motion.LEFT, 100.0):
        assert (clip.frames.shape, clip.frames.dtype) == (TOUCHED.shape, np.uint8)
        assert clip.background.shape == IDLE.shape
        assert told.motion == Motion.LEFT
    assert any((clip.frames != TOUCHED).any() for clip, _ in drawn(Motion.LEFT, 100.0))


def test_a_touch_faded_below_the_noise_is_told_to_be_unreadable():
    plain = READABLE_GREY / FAINT_CONTRAST[0]  # shows even at the faintest
    assert all(told.is_readable for _, told in drawn(Motion.LEFT, 1.01 * plain))
    lost = [clip for clip, told in drawn(Motion.LEFT, READABLE_GREY) if not told.is_readable]
    assert 0 < len(lost) < 120 / 2
    # Only fading loses a motion: there the idle frame stays and the touch comes nearer to it.
    for clip in lost:
        assert (clip.background == IDLE).all()
        assert (clip.frames < TOUCHED).all()
        assert (clip.frames > IDLE).any()


def test_hardly_any_damage_is_worse_than_what_is_still_answered():
    """A clip that would be refused teaches nothing; drifts and dim frames nearly are."""
    refused = 0
    for made in ExampleSet("check", 4, TRAINING_OBJECTS).simulated(0, 0, 4):
        for seed in range(50):
            clip, _ = damage_clip(made.clip, made.label, 50.0, np.random.default_rng(seed))
            try:
                require_legible(clip)
            except UnreadableClip:
                refused += 1
    assert refused <= 0.03 * 4 * 50
