"""Laws: the same examples whatever the number of workers, and after a kill."""

import numpy as np
import pytest

from geotlm_lm.core.edit import MIRRORED
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.randomise import random_scenes
from geotlm_lm.simulation.simulate import simulate
from geotlm_lm.training import examples, recording_forms
from geotlm_lm.training.examples import ExampleSet, read_examples, simulate_examples
from geotlm_lm.training.recording_forms import _frame_order, mirrored


@pytest.fixture
def _small_chunks(monkeypatch):
    monkeypatch.setattr(examples, "CHUNK_CLIPS", 4)


def made_in(folder):
    wanted = ExampleSet("check", 8, TRAINING_OBJECTS[:3])
    simulate_examples(folder, [wanted], seed=5, workers=1)
    return read_examples(folder, wanted)


@pytest.mark.usefixtures("_small_chunks")
def test_a_missing_chunk_is_made_again_byte_for_byte(tmp_path):
    first = made_in(tmp_path)
    (tmp_path / "check_0001.npz").unlink()
    again = made_in(tmp_path)
    assert np.array_equal(first.inputs, again.inputs)
    assert np.array_equal(first.displacement_px, again.displacement_px)
    assert first.labels == again.labels
    assert len(first) == 8
    assert set(first.objects) <= set(TRAINING_OBJECTS[:3])


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
    monkeypatch.setattr(recording_forms, "MIRRORED_SHARE", 1.0)
    flipped = made_in(tmp_path / "flipped")
    monkeypatch.setattr(recording_forms, "MIRRORED_SHARE", 0.0)
    plain = made_in(tmp_path / "plain")
    assert [MIRRORED.of_label(label) for label in flipped.labels] == list(plain.labels)
    assert not np.array_equal(flipped.inputs, plain.inputs)


def test_four_frames_run_forwards_or_form_a_pair_one_or_two_frames_apart():
    orders = {tuple(_frame_order(generator_for(0, index))) for index in range(200)}
    assert orders == {(0, 1, 2, 3), (0, 0, 1, 1), (0, 0, 2, 2)}
