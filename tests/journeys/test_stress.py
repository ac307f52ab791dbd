"""The shipped model under stress: it refuses what is no picture, and crashes at nothing."""

from pathlib import Path

import pytest
import torch

import geotlm_lm
from geotlm_lm.answering import Answerer
from geotlm_lm.core.labels import Motion
from geotlm_lm.experiments import extreme_clips as extremes
from geotlm_lm.experiments.judging import judge
from geotlm_lm.experiments.model_stability import stiff_rows
from geotlm_lm.experiments.simulator_stability import CASES as STIFF
from geotlm_lm.simulation.touch import Touch, simulate_touch

pytestmark = pytest.mark.skipif(
    not (Path(geotlm_lm.__file__).parent / "bundle").is_dir(), reason="needs the trained bundle"
)

CONFIDENT = 0.9


@pytest.fixture(scope="module")
def answerer():
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield Answerer.load()
    torch.set_num_threads(before)


@pytest.fixture(scope="module")
def verdicts(answerer):
    """Every extreme recording, made of a turning nut, and what became of it."""
    touched = simulate_touch(Touch("hex_nut", twist_deg=12.0)).clip
    patch = pytest.MonkeyPatch()
    patch.setattr(extremes, "LONG_FRAMES", 1_000)
    try:
        return {
            name: (extreme, judge(answerer, extreme.make, extreme.right))
            for name, extreme in extremes.extreme_clips(touched, Motion.CLOCKWISE).items()
        }
    finally:
        patch.undo()


def test_nothing_crashes(verdicts):
    assert {name: v.says for name, (_, v) in verdicts.items() if v.outcome == "crashed"} == {}


def test_where_nothing_can_be_told_nothing_is_told_with_confidence(verdicts):
    sure = {
        name: verdict.says
        for name, (extreme, verdict) in verdicts.items()
        if not extreme.right and verdict.confidence >= CONFIDENT
    }
    assert sure == {}


@pytest.mark.parametrize(
    "name", ["black", "white", "black and white in turn", "noise alone, all greys"]
)
def test_what_is_no_picture_is_refused(verdicts, name):
    assert verdicts[name][1].outcome == "refused"


@pytest.mark.parametrize("name", ["friction 1e6", "depth -0.5 mm", "nu 0.5, incompressible"])
def test_stiff_scenes_are_answered(answerer, name):
    (row,) = stiff_rows(answerer, {name: STIFF[name]}, 0)
    assert row["crashed"] == row["refused"] == 0
    assert row["solver"].endswith(", converged")
