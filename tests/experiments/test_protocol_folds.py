"""What a fold's classical rows come to: only training rows teach, and flow is quoted as it was."""

from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import ROTATIONS, Motion
from geotlm_lm.evaluation.splits import Fold
from geotlm_lm.experiments.protocol_clips import TaskClips
from geotlm_lm.experiments.protocol_folds import run_folds
from geotlm_lm.experiments.protocol_rows import CURL, FLOW
from tests.training.moving_tokens import token_set

# Two turns one way to one the other: who learns nothing from the curl names the commoner one.
TRAIN = np.concatenate([np.arange(0, 60, 2), np.arange(1, 30, 2)])
FOLD = Fold(TRAIN, np.arange(60, 70), np.arange(70, 100), ("x",))


@pytest.fixture(scope="module")
def clips():
    data = {FRAME_COUNT: token_set(100, 0, among=ROTATIONS)}
    clips = TaskClips(data, ("x",) * 100, (), np.zeros((100, 5), np.float32), 0, 0.0)
    signs = np.array([1.0 if one is Motion.CLOCKWISE else -1.0 for one in clips.truths])
    curl = signs[:, None] + 0.3 * np.random.default_rng(0).normal(size=(100, 5))
    said = tuple(ROTATIONS[place // 2 % 2] for place in range(100))
    return replace(clips, flow=said, curl=curl.astype(np.float32))


def named(clips, row, folder):
    (outcomes,) = run_folds(
        clips, "rotation", [FOLD], (row,), epochs=1, seed=0, keep=lambda number: folder / "0.json",
        progress=lambda done: None,
    )  # fmt: skip
    return outcomes[row]["predictions"]


def test_flow_is_quoted_for_each_test_row(clips, tmp_path):
    assert named(clips, FLOW, tmp_path) == [clips.flow[row].value for row in FOLD.test]


def test_the_curl_tells_turns_and_a_strange_test_row_changes_no_other(clips, tmp_path):
    said = named(clips, CURL, tmp_path)
    truths = [clips.truths[row].value for row in FOLD.test]
    assert np.mean([one == other for one, other in zip(said, truths, strict=True)]) > 0.9
    strange = clips.curl.copy()
    strange[FOLD.test[-1]] = 1e6
    (tmp_path / "again").mkdir()
    again = named(replace(clips, curl=strange), CURL, tmp_path / "again")
    assert again[:-1] == said[:-1]
