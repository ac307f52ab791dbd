"""The shipped model under stress: it refuses what is no picture, and crashes at nothing."""

import pytest

from geotlm_lm.benchmarks.damaged import extreme_clips
from geotlm_lm.benchmarks.harness import Run
from geotlm_lm.benchmarks.stability import CONFIDENT, STIFF_CASES, judge, judge_scene
from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.touch import Touch, simulate_touch


@pytest.fixture(scope="module")
def verdicts(answerer):
    """Every extreme recording, made of a turning nut, and what became of it."""
    touched = simulate_touch(Touch("hex_nut", twist_deg=12.0)).clip
    return {
        name: (extreme, judge(answerer, extreme.make, extreme.right))
        for name, extreme in extreme_clips(touched, Motion.CLOCKWISE, long_frames=1_000).items()
    }


@pytest.mark.slow
def test_nothing_crashes(verdicts):
    assert {name: v.text for name, (_, v) in verdicts.items() if v.outcome == "crashed"} == {}


def test_where_nothing_can_be_told_nothing_is_told_with_confidence(verdicts):
    sure = {
        name: verdict.text
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
    verdict = judge_scene(Run(answerer_given=answerer), STIFF_CASES[name])
    assert verdict.outcome not in ("crashed", "refused")
