"""The shipped model against truth: the simulator's fields, exact mirrors, real recordings."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from geotlm_lm.answering.understanding import OF_TWO
from geotlm_lm.backbone import imprint
from geotlm_lm.backbone.relief import Lights
from geotlm_lm.backbone.stem import MAGNIFICATION_AT, measure_clip
from geotlm_lm.benchmarks.cases import turned_by_quarter
from geotlm_lm.checkpoint import embedded_bundle_dir
from geotlm_lm.core import edit
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.edit import Edit, opposite
from geotlm_lm.core.geometry import FLOW_SCALE_PX, PATCH_SIDE
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, Motion
from geotlm_lm.data.labelled_recordings import find_labelled_recordings
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS
from geotlm_lm.simulation.randomise import random_scenes
from geotlm_lm.simulation.simulate import simulate
from geotlm_lm.simulation.touch import simulate_motion
from geotlm_lm.training.examples import truth_in_view

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "app" / "examples"
SIZE_LIMIT_MB = 20
QUESTION = "Which way is it moving?"


@pytest.fixture(scope="module")
def touches():
    """Readable clips of everyday objects that move in a direction; other seeds than in training."""
    scenes = random_scenes(2_718, 72, objects=EVERYDAY_OBJECTS, motions=DIRECTED)
    return [made for made in simulate(scenes, seed=2_718) if made.label.is_readable]


def direction(answerer, clip, motion=None):
    """Which way it goes, asked about the component of `motion`; about any without one."""
    question = QUESTION
    if motion in DIRECTED:
        question = f"Which way is it {'turning' if motion in ROTATIONS else 'sliding'}?"
    return answerer.ask(answerer.encode(clip), question).direction


def test_the_bundle_is_small():
    size = sum(path.stat().st_size for path in embedded_bundle_dir().rglob("*") if path.is_file())
    assert size < SIZE_LIMIT_MB * 1e6


def test_a_mirror_that_is_stated_is_no_comparison_of_two_recordings(answerer):
    read = answerer.bundle.reader.readings
    (anywhere, *_), (inside, *_) = (
        read("Mirrored. 60 fps. Which way did it turn?", unlikely=words)
        for words in (frozenset(), OF_TWO)
    )
    assert anywhere.line == inside.line == "fact mirrored ; fact rate #1 ; way turn"
    assert inside.chance > 0.9 * anywhere.chance


def test_patch_tokens_carry_motion_smaller_than_a_patch(answerer, touches):
    perception = answerer.bundle.model.perceive([made.clip for made in touches])
    found = perception.geometry.shear_change.numpy() * FLOW_SCALE_PX
    truths = [
        truth_in_view(view, made) for view, made in zip(perception.views, touches, strict=True)
    ]
    bins = np.stack([moved.reshape(2, 2, 14, 14, 2).mean(1) for moved, _, _ in truths])
    true = bins[:, 1] - bins[:, 0]
    contact = np.stack([share.mean(0) for _, share, _ in truths])
    counts = (contact > 0.8) & (np.linalg.norm(true, axis=-1) < PATCH_SIDE)
    for axis in range(2):
        correlation = np.corrcoef(found[counts][:, axis], true[counts][:, axis])[0, 1]
        assert correlation > 0.8


def test_directions_of_objects_never_trained_on_are_told(answerer, touches):
    right = [
        direction(answerer, made.clip, made.label.motion) == made.label.motion for made in touches
    ]
    assert np.mean(right) >= 0.88


def test_a_clip_played_backwards_goes_the_other_way(answerer, touches):
    right = [
        direction(answerer, made.clip.reversed(), made.label.motion) == opposite(made.label.motion)
        for made in touches
    ]
    assert np.mean(right) >= 0.85


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.npz")), ids=lambda path: path.stem)
def test_the_example_clips_are_seen_as_they_come(path, monkeypatch):
    """Their lights stand where a GelSight Mini has them."""
    found = []
    lights_of = imprint.lights_of
    monkeypatch.setattr(imprint, "lights_of", lambda *a: found.append(lights_of(*a)) or found[-1])
    inside_out = imprint.is_inside_out
    monkeypatch.setattr(
        imprint, "is_inside_out", lambda *a: found.append(inside_out(*a)) or found[-1]
    )
    measure_clip(read_clip(path))
    assert found == [Lights(), False]


@pytest.mark.parametrize(
    ("name", "motion"),
    [
        ("bottle_cap_clockwise", Motion.CLOCKWISE),
        ("hex_nut_counterclockwise", Motion.COUNTERCLOCKWISE),
        ("cable_up", Motion.UP),
        ("coin_press", Motion.PRESS),
    ],
)
def test_the_example_clips_are_answered_right(answerer, name, motion):
    assert direction(answerer, read_clip(EXAMPLES / f"{name}.npz")) is motion


def test_a_cap_that_travels_while_it_turns_is_told_as_turning(answerer):
    """Its axis lies beside it, and it goes 0.26 mm down: both are told, each where it is asked."""
    clip = simulate_motion("bottle_cap", Motion.CLOCKWISE, seed=0).clip
    assert direction(answerer, clip, Motion.CLOCKWISE) is Motion.CLOCKWISE
    assert direction(answerer, clip, Motion.DOWN) is Motion.DOWN


@pytest.mark.parametrize("name", ["bottle_cap_clockwise", "hex_nut_counterclockwise"])
def test_a_mirrored_example_turns_the_other_way(answerer, name):
    """A mirror swaps the lights as well; the stem has to notice."""
    clip = read_clip(EXAMPLES / f"{name}.npz")
    mirrored = replace(
        clip, frames=clip.frames[:, :, ::-1].copy(), background=clip.background[:, ::-1].copy()
    )
    turning = Motion.CLOCKWISE
    there = direction(answerer, clip, turning)
    assert direction(answerer, mirrored, turning) is edit.MIRRORED.of_way(there)


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_sensor_held_across_or_upside_down_is_told_as_its_pictures_show(
    answerer, touches, quarters
):
    """The lights come from other sides than in any training clip; the stem has to notice."""
    right = []
    for made in touches:
        clip, motion = as_camera_took_it(made.clip), made.label.motion
        for _ in range(quarters):
            clip, motion = turned_by_quarter(clip), Edit.of("quarter-ccw").of_way(motion)
        right.append(direction(answerer, clip, motion) is motion)
    assert np.mean(right) >= 0.88


def test_grey_recordings_are_told_and_measured(answerer, touches):
    """Their shades tell no lights apart, and a relief that came out empty measured nothing."""
    greys = [replace(made, clip=in_grey(made.clip)) for made in touches]
    right = [
        direction(answerer, made.clip, made.label.motion) is made.label.motion for made in greys
    ]
    assert np.mean(right) >= 0.85
    inputs = [measure_clip(made.clip).inputs for made in greys]
    assert all(one[1, ..., MAGNIFICATION_AT - 1].any() for one in inputs)


def in_grey(clip):
    """Return a clip whose three colours are its luma."""

    def luma(image):
        grey = np.rint(image @ np.array([0.299, 0.587, 0.114])).astype(np.uint8)
        return np.repeat(grey[..., None], 3, axis=-1)

    return replace(clip, frames=luma(clip.frames), background=luma(clip.background))


def as_camera_took_it(clip):
    """Return a clip of our square as pictures of 320 x 240."""
    frames = np.stack([cv2.resize(frame, (320, 240)) for frame in clip.frames])
    return replace(clip, frames=frames, background=cv2.resize(clip.background, (320, 240)))


def test_an_untouched_gel_is_never_given_a_direction(answerer):
    rng = np.random.default_rng(0)
    for level in (30, 110, 220):
        frames = np.clip(level + rng.normal(0, 2, (4, 240, 320, 3)), 0, 255).astype(np.uint8)
        answer = answerer.ask(answerer.encode(Clip(frames)), QUESTION)
        assert answer.direction not in DIRECTED


@pytest.mark.real
def test_real_turns_are_told_forwards_and_backwards(answerer, real):
    recordings = find_labelled_recordings(real / "physiclear")[0]
    rows = replace(recordings, rows=recordings.rows[::9])
    right = [
        direction(answerer, window.clip, window.motion) == window.motion
        for window in rows.windows(frames=("four",), backwards=True)
    ]
    assert len(right) >= 60
    assert np.mean(right) >= 0.85
