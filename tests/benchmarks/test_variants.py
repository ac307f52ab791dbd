from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from geotlm_lm.benchmarks import variants
from geotlm_lm.benchmarks.variants import (
    all_variants,
    most_probable,
    motion_told,
)
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.recordings.idle import estimate_background
from tests.benchmarks.fakes import ALL, FakeAnswerer


def clip_of(motion):
    rng = np.random.default_rng(0)
    frames = rng.integers(100, 120, (4, 32, 32, 3)).astype(np.uint8)
    frames[-1, -1, -1] = ALL.index(motion) + 10 * len(ALL)
    return Clip(frames, background=np.full((32, 32, 3), 110, np.uint8))


def said(answerer, motion, among):
    clip = clip_of(motion)
    rows = all_variants(answerer, seed=0)
    return {name: method(clip, among).motion for name, method in rows.items()}


def test_rows_restricted_to_the_task_never_leave_it():
    found = said(FakeAnswerer(), Motion.UP, ROTATIONS)
    restricted = (variants.SCORED, variants.PROBE, variants.GLOBAL_PROBE, variants.FLOW)
    assert {found[name] for name in restricted} <= set(ROTATIONS)


def test_free_rows_may_name_any_motion():
    found = said(FakeAnswerer(), Motion.UP, ROTATIONS)
    free = (
        variants.GENERATED,
        variants.GENERATED_UNSEEN,
        variants.SCORED_FREE,
        variants.PROBE_FREE,
    )
    assert {found[name] for name in free} == {Motion.UP}


def test_the_global_probe_reads_the_global_token():
    """The fake's global token is the negative of z, so this probe must avoid the truth."""
    found = said(FakeAnswerer(), Motion.CLOCKWISE, ROTATIONS)
    assert found[variants.GLOBAL_PROBE] == Motion.COUNTERCLOCKWISE


def test_a_clip_is_encoded_once_for_all_rows_and_again_for_the_next():
    answerer = FakeAnswerer()
    rows = all_variants(answerer, seed=0)
    for clip in (clip_of(Motion.UP), clip_of(Motion.UP)):
        for method in rows.values():
            method(clip, SLIDES)
    assert answerer.encoded_count == 2


def test_every_row_that_reads_the_model_is_charged_for_perceiving():
    rows = all_variants(FakeAnswerer(), seed=0)
    del rows[variants.FLOW]
    times = [method(clip_of(Motion.UP), SLIDES).milliseconds for method in rows.values()]
    # The fake states 11 ms for choosing and encoding, and itself takes next to none.
    assert min(times) > 11.0


def test_seen_and_unseen_wordings_are_asked_apart():
    answerer = FakeAnswerer()
    rows = all_variants(answerer, seed=0)
    for _ in range(20):
        rows[variants.GENERATED](clip_of(Motion.UP), SLIDES)
        rows[variants.GENERATED_UNSEEN](clip_of(Motion.UP), SLIDES)
    seen, unseen = set(answerer.questions[::2]), set(answerer.questions[1::2])
    assert len(seen) > 5
    assert len(unseen) > 2
    assert not seen & unseen


def test_words_and_scores_of_a_clip_rest_on_the_same_question():
    answerer = FakeAnswerer()
    rows = all_variants(answerer, seed=0)
    for _ in range(5):
        for name in (variants.GENERATED, variants.SCORED, variants.SCORED_FREE):
            rows[name](clip_of(Motion.UP), SLIDES)
    assert answerer.questions == answerer.scored[::2] == answerer.scored[1::2]
    assert len(set(answerer.questions)) > 1


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"left": 0.2, "clockwise": 0.7, "up": 0.1}, Motion.LEFT),
        ({"clockwise": 1.0, "down": 0.01}, Motion.DOWN),
    ],
)
def test_the_most_probable_motion_is_sought_among_those_asked(options, expected):
    assert most_probable(options, SLIDES) == expected


def test_flow_is_given_the_gel_that_the_model_would_guess():
    """Of four clips the mean frame in the gel's place errs by 2.8 to 8.6 px, the guess by 0.3."""
    from geotlm_lm.simulation.touch import Touch, simulate_touch

    naive_errors = []
    for seed in range(1, 5):
        clip = simulate_touch(Touch("key", slide_x_mm=0.15, seed=seed)).clip
        without = replace(clip, background=None)
        guessed = replace(clip, background=estimate_background(clip.frames))
        true, found, naive = (RigidFlow().fit(one).slide_x_px for one in (clip, guessed, without))
        assert variants.flow_on_the_guessed_gel(without, SLIDES) == Motion.RIGHT
        assert found == pytest.approx(true, abs=0.5)
        naive_errors.append(abs(naive - true))
    assert np.median(naive_errors) > 3


def test_words_told_of_the_sensor_are_taken_for_what_the_object_does():
    for direction, actor, meant in (
        (Motion.LEFT, "object", Motion.LEFT),
        (Motion.LEFT, "sensor", Motion.RIGHT),
        (None, "sensor", None),
    ):
        told = SimpleNamespace(direction=direction, frame=FrameSpec(actor=actor))
        assert motion_told(told) is meant
