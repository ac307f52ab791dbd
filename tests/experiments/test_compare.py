import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import ROTATIONS, Motion
from geotlm_lm.experiments.compare import (
    Case,
    Reply,
    ask_all,
    claims,
    compare,
    per_object,
    summarise,
    timed,
)

CW, CCW, STILL = Motion.CLOCKWISE, Motion.COUNTERCLOCKWISE, Motion.STILL


def case(motion, object_id="cap", family=None, **tags):
    """A case whose clip carries the number of its motion in every pixel."""
    number = list(Motion).index(motion)
    clip = Clip(np.full((1, 8, 8, 3), number, np.uint8))
    return Case(clip, motion, object_id, family or object_id, tags)


def oracle(clip, among):
    return Reply(list(Motion)[clip.frames[0, 0, 0, 0]], 2.0)


def always_first(clip, among):
    return Reply(among[0], 4.0)


def silent(clip, among):
    return Reply(None, 1.0)


CASES = [case(CW, "cap"), case(CCW, "cap"), case(CW, "key"), case(CW, "key")]
METHODS = {"oracle": oracle, "first": always_first, "silent": silent}


def test_every_method_is_scored_on_the_same_clips():
    found = compare(METHODS, CASES, ROTATIONS)
    assert found["clips"] == 4
    assert {name: one["accuracy"] for name, one in found["methods"].items()} == {
        "oracle": 1.0,
        "first": 0.75,
        "silent": 0.0,
    }


def test_class_collapse_shows_in_the_recalls():
    scores = compare(METHODS, CASES, ROTATIONS)["methods"]["first"]
    assert scores["recall"] == {"clockwise": 1.0, "counterclockwise": 0.0}
    assert scores["balanced_accuracy"] == 0.5
    assert scores["macro_by_object"] == 0.75
    assert scores["confusion"] == {
        "labels": ["clockwise", "counterclockwise"],
        "counts": [[3, 0, 0], [1, 0, 0]],
    }


def test_silence_is_wrong_and_counted():
    scores = compare(METHODS, CASES, ROTATIONS)["methods"]["silent"]
    assert scores["verdicts"] == {"right": 0, "wrong": 0, "unparsable": 4}


def test_contrasts_compare_clip_by_clip():
    (difference,) = compare(METHODS, CASES, ROTATIONS, [("oracle", "first")])["differences"]
    assert (difference["first"], difference["second"]) == ("oracle", "first")
    assert difference["difference"] == 0.25


def test_resampling_keeps_families_together():
    """Caps are always right and keys always wrong: two units to draw from, or twenty."""
    motions = [CW] * 10 + [CCW] * 10
    alone = [case(motion, f"thing {k}") for k, motion in enumerate(motions)]
    together = [case(m, f"thing {k}", "caps" if m == CW else "keys") for k, m in enumerate(motions)]
    low, high = compare({"first": always_first}, alone, ROTATIONS)["methods"]["first"]["interval"]
    assert 0.2 < low < 0.5 < high < 0.8
    found = compare({"first": always_first}, together, ROTATIONS)["methods"]["first"]["interval"]
    assert found == [0.0, 1.0]


def test_times_are_medians_and_tails():
    times = iter([1.0, 2.0, 3.0, 100.0])
    method = {"slow": lambda clip, among: Reply(CW, next(times))}
    scores = compare(method, CASES, ROTATIONS)["methods"]["slow"]
    assert (scores["ms_median"], scores["ms_p95"]) == pytest.approx((2.5, 85.45))


def test_a_timed_function_reports_its_own_duration():
    reply = timed(lambda clip, among: sum(range(200_000)) and CW)(CASES[0].clip, ROTATIONS)
    assert reply.motion == CW
    assert 0.1 < reply.milliseconds < 1000


def test_replies_are_selected_by_tags():
    cases = [case(CW, fps="25", played="forwards"), case(CCW, fps="25", played="backwards")]
    replies = ask_all(METHODS, cases, ROTATIONS)
    assert replies.where(fps="25").truths == [CW, CCW]
    part = replies.where(fps="25", played="backwards")
    assert (part.truths, part.motions["first"]) == ([CCW], [CW])


def test_false_claims_are_counted_on_clips_without_direction():
    scores = compare(METHODS, [*CASES, case(STILL)], tuple(Motion))["methods"]
    assert scores["first"]["false_claim_rate"] == 1.0
    assert scores["oracle"]["false_claim_rate"] == 0.0
    assert scores["silent"]["false_claim_rate"] == 0.0


def test_a_claim_counts_as_seen_where_it_turns_round_with_the_clip():
    answers = iter([CW, CW, STILL, CCW, CW, CW])
    forwards, backwards = (
        ask_all(
            {"m": lambda clip, among: Reply(next(answers), 1.0)}, [case(STILL)] * 3, tuple(Motion)
        )
        for _ in range(2)
    )
    counted = claims(forwards, backwards)
    assert counted == {"m": {"directions": 2, "turned_round": 1}}


def test_cases_are_read_one_at_a_time():
    held = []

    def cases():
        for number in range(3):
            held.append(number)
            yield case(CW)

    asked = []
    ask_all({"spy": lambda clip, among: Reply(asked.append(len(held)), 0.0)}, cases(), ROTATIONS)
    assert asked == [1, 2, 3]


def test_progress_counts_the_cases():
    seen = []
    ask_all(METHODS, CASES, ROTATIONS, seen.append)
    assert seen == [1, 2, 3, 4]


def test_no_case_is_refused():
    with pytest.raises(ValueError, match="no case to score"):
        summarise(ask_all(METHODS, [], ROTATIONS))


def test_objects_are_told_apart():
    replies = ask_all(METHODS, CASES, ROTATIONS)
    assert per_object(replies, ["oracle", "first"]) == {
        "cap": {"clips": 2, "oracle": 1.0, "first": 0.5},
        "key": {"clips": 2, "oracle": 1.0, "first": 1.0},
    }
