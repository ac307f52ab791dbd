import numpy as np
import pytest

from geotlm_lm.benchmarks.judging import (
    Case,
    Reply,
    ask_all,
    claims_turned_round,
    rows_of_replies,
)
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import ROTATIONS, Motion

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
VARIANTS = {"oracle": oracle, "first": always_first, "silent": silent}


def rows(variants=VARIANTS, cases=CASES, among=ROTATIONS, words="", rivals=()):
    found = rows_of_replies("here", ask_all(variants, cases, among), words, rivals)
    return {row.variant: row for row in found}


def test_every_variant_is_scored_on_the_same_clips():
    found = rows()
    assert {name: (row.count, row.error) for name, row in found.items()} == {
        "oracle": (4, 0.0),
        "first": (4, 0.25),
        "silent": (4, 1.0),
    }
    assert {row.case for row in found.values()} == {"here"}
    assert found["silent"].detail["unanswered"] == 4


def test_class_collapse_shows_in_the_recalls():
    detail = rows()["first"].detail
    assert detail["recall"] == {"clockwise": 1.0, "counterclockwise": 0.0}
    assert detail["macro_by_object"] == 0.75


def test_words_are_held_against_the_better_rival():
    found = rows(words="first", rivals=("silent", "oracle"))
    told = found["first"].detail["rival"]
    assert (told["name"], told["difference"], told["is_below"]) == ("oracle", -0.25, True)
    assert "rival" not in found["oracle"].detail
    assert not rows(words="oracle", rivals=("first",))["oracle"].detail["rival"]["is_below"]


def test_resampling_keeps_families_together():
    """Caps are always right and keys always wrong: two units to draw from, or twenty."""
    motions = [CW] * 10 + [CCW] * 10
    alone = [case(motion, f"thing {k}") for k, motion in enumerate(motions)]
    together = [case(m, f"thing {k}", "caps" if m == CW else "keys") for k, m in enumerate(motions)]
    low, high = rows({"first": always_first}, alone)["first"].interval
    assert 0.2 < low < 0.5 < high < 0.8
    assert rows({"first": always_first}, together)["first"].interval == (0.0, 1.0)


def test_times_are_medians_and_tails():
    times = iter([1.0, 2.0, 3.0, 100.0])
    row = rows({"slow": lambda clip, among: Reply(CW, next(times))})["slow"]
    assert (row.ms_p50, row.ms_p95) == pytest.approx((2.5, 85.45))


def test_replies_are_selected_by_tags():
    cases = [case(CW, fps="25", played="forwards"), case(CCW, fps="25", played="backwards")]
    replies = ask_all(VARIANTS, cases, ROTATIONS)
    assert [one.motion for one in replies.where(fps="25").cases] == [CW, CCW]
    (reply,) = replies.where(fps="25", played="backwards").replies["first"]
    assert reply.motion == CW


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


def test_a_claim_counts_as_seen_where_it_turns_round_with_the_clip():
    left, right = Motion.LEFT, Motion.RIGHT
    answers = iter([(CW, left), (CW,), (), (CCW, left), (CW, right), (CW,)])
    forwards, backwards = (
        ask_all(
            {"m": lambda clip, among: Reply(STILL, 1.0, next(answers))},
            [case(STILL)] * 3,
            tuple(Motion),
        )
        for _ in range(2)
    )
    assert claims_turned_round(forwards, backwards) == {"m": {"turn": (2, 1), "slide": (1, 0)}}


def test_cases_are_read_one_at_a_time():
    held = []

    def cases():
        for number in range(3):
            held.append(number)
            yield case(CW)

    asked = []
    ask_all({"spy": lambda clip, among: Reply(asked.append(len(held)), 0.0)}, cases(), ROTATIONS)
    assert asked == [1, 2, 3]


def test_without_a_case_there_is_no_row():
    assert rows(cases=[]) == {}
