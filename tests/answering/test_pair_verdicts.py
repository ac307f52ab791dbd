"""Yes, no, or which of two clips, from answers written down by hand and through the seam."""

from dataclasses import replace
from functools import partial

import pytest

from geotlm_lm.answering.multi_clip import compare_amounts
from geotlm_lm.answering.pair_verdicts import (
    judge_amounts,
    judge_count,
    judge_inverse,
    judge_kind,
    judge_mirror_or_reversal,
    judge_relation,
    judge_transformed,
)
from geotlm_lm.conversation.felt import Felt
from geotlm_lm.conversation.two_clip_claims import (
    claimed_count,
    claimed_relation,
    supposed_transform,
)
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENT_OF
from tests.answering import test_multi_clip as by_hand
from tests.answering.test_multi_clip import WITHHELD, measured


def answer(motion, share=0.8):
    """Of an answer at rest, which has no opposite, what is left is a movement up."""
    said = by_hand.answer(motion, share)
    if motion not in ("still", "none"):
        return said
    return replace(said, options={motion: share, "up": 1.0 - share})


def felt(motion, share=0.9):
    """What is felt of one motion alone."""
    motion = Motion(motion)
    contact = 1.0 - share if motion is Motion.NONE else 1.0
    return Felt({motion: share} if motion in COMPONENT_OF else {}, contact)


def judged(question, one, other):
    """Return the verdict on a count, of motions and their probabilities."""
    answers = (answer(*one), answer(*other))
    return judge_count(claimed_count(question), (felt(*one), felt(*other)), answers)


@pytest.mark.parametrize(
    ("question", "one", "other", "decided", "begins"),
    [
        ("Which one turns clockwise?", "clockwise", "counterclockwise", "first", "The first: it"),
        ("Which one slides?", "clockwise", "left", "second", "The second: it is going left, the"),
        ("Which one slides?", "clockwise", "clockwise", "neither", "Neither: both are going clo"),
        ("Which one moves?", "left", "press", "both", "Both: the first is going left, the sec"),
        ("Do both turn clockwise?", "clockwise", "left", "no", "No: the first is going clockwise"),
        ("Does either turn clockwise?", "left", "clockwise", "yes", "Yes: the first is going le"),
        ("Does neither slide?", "clockwise", "press", "yes", "Yes: the first is going clockwise"),
        ("Does only one move?", "left", "still", "yes", "Yes: the first is going left, the sec"),
        ("Which one is touched?", "none", "still", "second", "The second: it is holding still, "),
    ],
)
def test_it_is_decided_which_clips_go_so(question, one, other, decided, begins):
    told = judged(question, (one, 0.9), (other, 0.9))
    assert (told.decided, told.abstained) == (decided, False)
    assert told.text.startswith(begins)
    assert 0.5 < told.confidence <= 1.0


def test_the_probability_of_a_verdict_is_that_of_both_clips():
    pair = (("clockwise", 0.9), ("clockwise", 0.8))
    assert judged("Do both turn clockwise?", *pair).confidence == pytest.approx(0.72)
    either = judged("Does either turn clockwise?", *pair)
    assert either.confidence == pytest.approx(0.98)


def test_a_verdict_is_withheld_where_a_direction_is():
    felts = (felt("left"), felt("left"))
    told = judge_count(claimed_count("Do both slide?"), felts, (answer("left"), WITHHELD))
    assert (told.decided, told.abstained, told.relation) == (None, True, "unknown")


@pytest.mark.parametrize(
    ("question", "one", "other", "decided", "begins"),
    [
        ("Do they go the same way?", "left", "left", "yes", "The same: of both clips"),
        ("Do they go the same way?", "left", "right", "no", "Opposite: the first is"),
        ("They turn the same way, right?", "left", "right", "no", "No, opposite: the first is"),
        ("Is it false that they match?", "left", "right", "yes", "Yes, opposite: the first is"),
        ("Are they opposite?", "press", "release", "yes", "Yes, opposite, as one is the other p"),
        ("Are they opposite?", "press", "still", "no", "No, different: the first is pressing"),
        ("Is there a difference?", "left", "left", "no", "No, the same: of both clips"),
        ("Do they differ?", "left", "right", "yes", "Yes, opposite: the first is going left"),
    ],
)
def test_a_claimed_relation_is_judged(question, one, other, decided, begins):
    told = judge_relation(claimed_relation(question), (answer(one, 0.9), answer(other, 0.9)))
    assert told.decided == decided
    assert told.text.startswith(begins)


def test_a_clip_supposed_mirrored_is_compared_so():
    pair = (answer("clockwise", 0.9), answer("counterclockwise", 0.9))
    asked = "If the second clip were mirrored, would they turn the same way?"
    rest, which, change = supposed_transform(asked)
    claim = replace(claimed_relation(rest), is_plain=False)
    told = judge_transformed(partial(judge_relation, claim), which, change, pair)
    assert (told.decided, told.second) == ("yes", pair[1])
    assert told.text == (
        "Yes, the same: of both clips, it goes clockwise in the camera image, with the second "
        "mirrored."
    )
    assert judge_mirror_or_reversal("mirrored", pair).decided == "yes"
    assert judge_mirror_or_reversal("mirrored", (pair[0], pair[0])).decided == "no"
    assert judge_mirror_or_reversal("reversed", (answer("up"), answer("up"))).decided == "no"


@pytest.mark.parametrize(
    ("sizes", "decided", "end"),
    [
        ((12, 13), "yes", "They go about 12 and 13 deg."),
        ((23, 7), "no", "They go about 23 and 7 deg."),
    ],
)
def test_what_goes_back_as_far_undoes(sizes, decided, end):
    pair = (answer("clockwise", 0.9), answer("counterclockwise", 0.9))
    amounts = compare_amounts("", [measured(one) for one in sizes], (None, None), pair)
    told = judge_inverse(amounts, pair)
    assert told.decided == decided
    assert told.text.endswith(end)
    assert judge_inverse(amounts, (pair[0], pair[0])).decided == "no"


@pytest.mark.parametrize(("second_deg", "decided"), [(20.0, "yes"), (5.0, "no")])
def test_that_one_undoes_the_other_is_as_sure_as_ways_and_amounts_are(second_deg, decided):
    pair = (answer("clockwise", 0.9), answer("counterclockwise", 0.8))
    found = [
        replace(measured(20.0), probability=0.7),
        replace(measured(second_deg), probability=0.9),
    ]
    told = judge_inverse(compare_amounts("", found, (None, None), pair), pair)
    assert told.decided == decided
    back = 0.9 * 0.8 + 0.1 * 0.2  # both right, or both wrong
    assert told.confidence == pytest.approx(back * 0.7 * 0.9)


def test_a_claimed_order_of_amounts_is_judged():
    pair = (answer("clockwise"), answer("clockwise"))
    faster = compare_amounts(
        "Is the second one faster?", [measured(12), measured(27)], (1.0, 1.0), pair
    )
    assert judge_amounts(faster, "second").text == "Yes, the second: about 12 and 27 deg/s."
    no = judge_amounts(faster, "first")
    assert (no.text, no.decided, no.relation) == (
        "No, the second: about 12 and 27 deg/s.",
        "no",
        "second",
    )


@pytest.mark.parametrize(
    ("one", "other", "is_one_kind", "decided"),
    [
        ("clockwise", "counterclockwise", True, "yes"),
        ("clockwise", "left", True, "no"),
        ("left", "up", False, "no"),
        ("press", "still", False, "yes"),
    ],
)
def test_opposite_turns_are_of_one_kind(one, other, is_one_kind, decided):
    told = judge_kind(is_one_kind, (answer(one, 0.9), answer(other, 0.9)))
    assert (told.decided, told.abstained) == (decided, False)
    assert told.text.startswith(f"{decided.capitalize()}, by kind: the first is")
    assert 0.7 < told.confidence <= 1.0
