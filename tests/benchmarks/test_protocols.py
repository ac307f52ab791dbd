"""The protocols at a size at which nothing is learned: clips, folds, scores, resuming."""

from itertools import islice
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from geotlm_lm.benchmarks.cases import TASKS
from geotlm_lm.benchmarks.harness import EncoderFile, Row, Run
from geotlm_lm.benchmarks.protocols import (
    GROUNDED,
    PAPER,
    PROTOCOLS,
    TaskClips,
    fold_scores,
    methods_of,
    protocol_rows,
    published_rows,
    task_clips,
)
from geotlm_lm.benchmarks.rendering import tables
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import ROTATIONS, Motion
from geotlm_lm.core.numbers import seed_for
from geotlm_lm.core.process import silent
from geotlm_lm.simulation.simulate import simulate_series
from geotlm_lm.training.folds import Fold
from tests.backbone.small_files import write_small
from tests.benchmarks.fakes import PlainBackbone

NONE = np.array([], dtype=np.intp)


def run_on(backbone, **more):
    answerer = SimpleNamespace(bundle=SimpleNamespace(model=SimpleNamespace(backbone=backbone)))
    return Run(is_quick=True, answerer_given=answerer, **more)


@pytest.mark.slow
def test_every_method_is_scored_in_both_protocols():
    finished = protocol_rows(run_on(PlainBackbone()))
    ours = [row for row in finished if row.count]
    for task in ("rotation", "sliding"):
        for protocol in ("five-fold", "leave-one-object-out"):
            own = [row.variant for row in ours if row.case == f"{task}, {protocol}"]
            assert own == list(methods_of(task, True))
    assert {row.count for row in ours} == {10}
    paper = next(row for row in ours if row.variant == PAPER)
    assert paper.interval[0] <= paper.error <= paper.interval[1]
    text = "\n".join(tables(PROTOCOLS, [Row.from_dict(row.to_dict()) for row in finished]))
    assert "| rotation, published: ToucHD-Sim (simulated), five-fold" in text
    assert "0.952 ± 0.016" in text  # the paper's Table I, GeoTLM


@pytest.mark.slow
def test_a_released_encoder_takes_the_backbones_place(tmp_path):
    path = write_small("anytouch2", tmp_path / "file")
    rows = protocol_rows(run_on(None, encoder=EncoderFile(path, heads=2)))
    assert PAPER in {row.variant for row in rows if row.count}
    assert GROUNDED not in {row.variant for row in rows}  # its grid is 3 x 3: no truth on it


def test_published_figures_name_our_methods_and_are_shares():
    for task, classes in (("rotation", 2), ("sliding", 4)):
        rows = list(published_rows(task))
        assert all(0.2 < 1 - row.error < 1 and row.count == 0 for row in rows)
        assert {len(row.detail["recall"]) for row in rows} <= {0, classes}
        assert all(set(row.detail["recall"]) <= set(Motion) for row in rows)
        for row in rows:  # recalls bracket an accuracy, up to what differs between the folds
            recall = row.detail["recall"].values() or [1 - row.error]
            assert min(recall) - 0.01 < 1 - row.error < max(recall) + 0.01


CW, CCW = ROTATIONS
OBJECTS = ["cap", "key", "nut", "pen"] * 3
FOLDS = [
    Fold(NONE, NONE, np.array([0, 4, 8, 1, 5, 9]), ("cap", "key")),
    Fold(NONE, NONE, np.array([2, 6, 10, 3, 7, 11]), ("nut", "pen")),
]


def motions(letters):
    return [{"a": CW, "b": CCW, "-": Motion.STILL}[letter] for letter in letters]


def judged(truths, folds, *named):
    clips = TaskClips({}, OBJECTS[: len(truths)], motions(truths), (), np.zeros((0, 5)))
    return fold_scores(clips, folds, [motions(letters) for letters in named])


def test_scores_over_folds_are_those_counted_by_hand():
    # Of a b a, a a b one b is missed; of b a b, b b a both a and one b are.
    right, mean, detail = judged("aabbbaababba", FOLDS, "abaaaa", "bbbb-b")
    assert right.sum() == 8
    assert mean == pytest.approx((5 / 6 + 3 / 6) / 2)
    assert detail["sd"] == pytest.approx((2 / 6) / np.sqrt(2))  # n - 1
    assert detail["recall"] == pytest.approx({CW: (1 + 0) / 2, CCW: (1 / 2 + 3 / 4) / 2})


def test_tokens_truths_and_references_are_those_of_the_clips():
    found = task_clips(PlainBackbone(), "rotation", ("key", "cable"), 2, 5, silent)
    seed = seed_for(5, "protocols", "rotation", "key")
    series = simulate_series(seed, 12, objects=("key",), motions=TASKS["rotation"])
    simulated = list(islice((made for made in series if made.label.is_readable), 2))
    clips = [made.clip for made in simulated]
    tokens = PlainBackbone().encode(clips)
    assert torch.equal(found.data[4].tokens.patches[:2], tokens.patches.half())
    pairs = PlainBackbone().encode([clip.select((0, 0, 3, 3)) for clip in clips])
    assert torch.equal(found.data[2].tokens.patches[:2], pairs.patches.half())
    assert found.truths[:2] == [made.label.motion for made in simulated]
    assert found.objects == ("key",) * 2 + ("cable",) * 2
    # The plain backbone's grid is the simulator's own: nothing is cut or blended.
    moved = np.stack([made.displacement_px for made in simulated])
    always = (np.stack([made.contact for made in simulated]) > 0.5).all(axis=1)
    change = (moved[:, 2:].mean(axis=1) - moved[:, :2].mean(axis=1))[always]
    np.testing.assert_allclose(found.data[4].shear_change[:2].numpy()[always], change, atol=1e-3)


def test_tokens_beyond_half_precision_are_refused():
    with pytest.raises(UsageError, match="were found, expected below 65504; the weights are not"):
        task_clips(PlainBackbone(gain=1e9), "rotation", ("key",), 1, 5, silent)
