"""Variants are scored on the same clips; intervals cover what they should."""

import numpy as np
import pytest
from scipy import stats

from geotlm_lm.benchmarks.judging import (
    Case,
    Reply,
    ask_all,
    clustered_interval,
    paired_difference,
    rows_of_replies,
)
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import ROTATIONS, Motion

CW, CCW, STILL = Motion.CLOCKWISE, Motion.COUNTERCLOCKWISE, Motion.STILL


def case(motion, family="cap", **tags):
    """A case whose clip carries the number of its motion in every pixel."""
    number = list(Motion).index(motion)
    clip = Clip(np.full((1, 8, 8, 3), number, np.uint8))
    return Case(clip, motion, family, tags)


def oracle(clip, among):
    return Reply(list(Motion)[clip.frames[0, 0, 0, 0]], 2.0)


def always_first(clip, among):
    return Reply(among[0], 4.0)


def silent(clip, among):
    return Reply(None, 1.0)


CASES = [case(CW, "cap"), case(CCW, "cap"), case(CW, "key"), case(CW, "key")]
VARIANTS = {"oracle": oracle, "first": always_first, "silent": silent}


def rows(variants=VARIANTS, cases=CASES, among=ROTATIONS, held="", rivals=()):
    found = rows_of_replies("here", ask_all(variants, cases, among), held, rivals)
    return {row.variant: row for row in found}


def test_every_variant_is_scored_on_the_same_clips():
    found = rows()
    assert {name: (row.count, row.error) for name, row in found.items()} == {
        "oracle": (4, 0.0),
        "first": (4, 0.25),
        "silent": (4, 1.0),
    }
    assert {row.case for row in found.values()} == {"here"}
    assert found["first"].detail["recall"] == {"clockwise": 1.0, "counterclockwise": 0.0}
    assert [found[name].detail["wrong_way"] for name in VARIANTS] == [0.0, 0.25, 0.0]
    assert rows(cases=[]) == {}


def test_a_method_is_held_against_the_better_rival():
    found = rows(cases=2 * CASES, held="first", rivals=("silent", "oracle"))
    told = found["first"].detail["rival"]
    assert (told["name"], told["difference"], told["is_below"]) == ("oracle", -0.25, True)
    assert "rival" not in found["oracle"].detail
    assert not rows(held="oracle", rivals=("first",))["oracle"].detail["rival"]["is_below"]
    assert not rows(held="first", rivals=("oracle",))["first"].detail["rival"]["is_below"]  # by one


def test_resampling_keeps_families_together():
    """Caps are always right and keys always wrong: two units to draw from, or twenty."""
    motions = [CW] * 10 + [CCW] * 10
    alone = [case(motion, f"thing {k}") for k, motion in enumerate(motions)]
    together = [case(motion, "caps" if motion == CW else "keys") for motion in motions]
    low, high = rows({"first": always_first}, alone)["first"].interval
    assert 0.2 < low < 0.5 < high < 0.8
    assert rows({"first": always_first}, together)["first"].interval == (0.0, 1.0)


def test_times_are_medians_and_tails():
    times = iter([1.0, 2.0, 3.0, 100.0])
    row = rows({"slow": lambda clip, among: Reply(CW, next(times))})["slow"]
    assert (row.ms_p50, row.ms_p95) == pytest.approx((2.5, 85.45))


def test_turns_and_slides_are_counted_apart_on_clips_without_direction():
    both = {"both": lambda clip, among: Reply(STILL, 1.0, (CW, Motion.LEFT))}
    found = rows(VARIANTS | both, cases=[*CASES, case(STILL)], among=tuple(Motion))
    assert {name: row.detail["claims"] for name, row in found.items()} == {
        "oracle": {"turn": 0.0, "slide": 0.0},
        "first": {"turn": 1.0, "slide": 0.0},
        "silent": {"turn": 0.0, "slide": 0.0},
        "both": {"turn": 1.0, "slide": 1.0},
    }
    assert "claims" not in rows()["first"].detail


def test_cases_are_read_one_at_a_time():
    held = []

    def cases():
        for number in range(3):
            held.append(number)
            yield case(CW)

    asked = []
    ask_all({"spy": lambda clip, among: Reply(asked.append(len(held)), 0.0)}, cases(), ROTATIONS)
    assert asked == [1, 2, 3]


def correlated_clips(rng, objects=30, clips=20):
    """Clips of one object share its difficulty: a beta-distributed accuracy of mean 0.8."""
    skill = np.repeat(rng.beta(4, 1, objects), clips)
    return rng.random(objects * clips) < skill, np.repeat(np.arange(objects), clips)


def test_the_interval_covers_the_truth_about_nineteen_times_in_twenty():
    rng = np.random.default_rng(2)
    hits = 0
    for repeat in range(150):
        correct, objects = correlated_clips(rng)
        low, high = clustered_interval(correct, objects, seed=repeat)
        hits += low <= 0.8 <= high
    # 150 repeats: standard error 0.018; a naive interval covers about 0.7 here.
    assert 0.89 < hits / 150 < 0.985


@pytest.mark.parametrize(
    ("right", "count", "objects"), [(7, 20, 1), (1, 3, 1), (50, 50, 50), (0, 50, 50)]
)
def test_one_object_and_objects_that_agree_leave_the_doubt_of_independent_clips(
    right, count, objects
):
    expected = stats.binomtest(right, count).proportion_ci(method="wilson")
    found = clustered_interval(np.arange(count) < right, np.arange(count) % objects)
    assert found == pytest.approx((expected.low, expected.high))


def test_one_object_can_never_be_significant():
    found = paired_difference(np.ones(500), np.zeros(500), ["cap"] * 500)
    assert (found["low"], found["high"]) == (-1.0, 1.0)
