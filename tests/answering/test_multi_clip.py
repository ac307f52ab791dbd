"""Relations of two clips, and orders of several, from answers written down by hand."""

import json
from dataclasses import replace

import pytest

from geotlm_lm.answering.amounts import Amount
from geotlm_lm.answering.answer import Answer
from geotlm_lm.answering.multi_clip import compare_amounts, compare_directions, order_of_motions
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, reverse
from tests.answering.scripted import believed, feeling, recording


def answer(motion, share=0.8):
    motion = Motion(motion)
    options = {motion.value: share, reverse(motion).value: 1 - share}
    return Answer(
        text="", direction=motion, confidence=share, abstained=False, frame=FrameSpec(),
        options=options, evidence={}, timing_ms={}, kind="direction", frames_used=(0, 1, 2, 3),
    )  # fmt: skip


WITHHELD = replace(answer("left"), text="I cannot say.", direction=None, abstained=True)


@pytest.mark.parametrize(
    ("one", "other", "relation", "confidence", "text"),
    [
        # Equal: both right or both wrong; opposite: one of them wrong.
        (
            "left",
            "left",
            "same",
            0.68,
            "The same: of both clips, it goes left in the camera image.",
        ),
        (
            "left",
            "right",
            "opposite",
            0.68,
            "Opposite: the first is going left, the second going right, in the camera image.",
        ),
        (
            "left",
            "clockwise",
            "different",
            1.0,
            "Different: the first is going left, the second going clockwise, in the camera image.",
        ),
        (
            "press",
            "release",
            "different",
            0.68,
            "Different: the first is pressing in, the second lifting off.",
        ),
    ],
)
def test_two_directions_are_the_same_opposite_or_different(one, other, relation, confidence, text):
    compared = compare_directions(answer(one), answer(other))
    assert (compared.relation, compared.text) == (relation, text)
    assert compared.confidence == pytest.approx(confidence)


def test_different_is_what_is_neither_the_same_nor_opposite():
    first = replace(answer("left"), options={"left": 0.8, "clockwise": 0.2})
    second = replace(answer("clockwise"), options={"clockwise": 0.7, "right": 0.3})
    # Both clockwise in 0.14 of all, left and right in 0.24.
    assert compare_directions(first, second).confidence == pytest.approx(0.62)


def test_a_withheld_direction_withholds_the_comparison():
    compared = compare_directions(answer("left"), WITHHELD)
    assert compared.text == "I cannot compare them; of the second: I cannot say."
    assert (compared.relation, compared.abstained, compared.confidence) == ("unknown", True, 0.0)


@pytest.mark.parametrize(
    ("one", "other", "sure", "text"),
    [
        # 0.56^2 + 0.34^2 + 0.1^2, and without the last.
        ("left", "left", "44%", "The same: of both clips, it goes left in the camera image."),
        (
            "left",
            "right",
            "43%",
            "Opposite: the first is going left, the second going right, in the camera image.",
        ),
    ],
)
def test_a_relation_more_likely_wrong_than_right_is_withheld(one, other, sure, text):
    pair = [
        replace(
            answer(way, 0.56), options={way: 0.56, reverse(Motion(way)).value: 0.34, "press": 0.1}
        )
        for way in (one, other)
    ]
    compared = compare_directions(*pair)
    assert compared.text == f"I cannot tell for sure, {sure}: {text}"
    assert (compared.relation, compared.confidence, compared.abstained) == ("unknown", 0.0, True)


def measured(value, unit="deg", share=0.5):
    return Amount(value, unit, 0.9 * value, 1.1 * value, share)


@pytest.mark.parametrize(
    ("question", "amounts", "seconds", "relation", "text"),
    [
        (
            "Which went further?",
            (12, 27),
            (None, None),
            "second",
            "The second: about 12 and 27 deg.",
        ),
        ("Which moved less?", (12, 27), (None, None), "first", "The first: about 12 and 27 deg."),
        (
            "Which turned more?",
            (12, 15),
            (None, None),
            "similar",
            "Neither: they are similar, about 12 and 15 deg.",
        ),
        # 12 deg in 0.1 s is faster than 27 deg in 1 s.
        ("Which is faster?", (12, 27), (0.1, 1.0), "first", "The first: about 120 and 27 deg/s."),
        ("Which is slower?", (12, 27), (0.1, 1.0), "second", "The second: about 120 and 27 deg/s."),
        (
            "Which is faster?",
            (12, 27),
            (0.1, None),
            "unknown",
            "I cannot tell which is faster: not both clips have a frame rate.",
        ),
    ],
)
def test_amounts_are_compared_by_size_or_by_time(question, amounts, seconds, relation, text):
    pair = [measured(amount) for amount in amounts]
    answers = (answer("clockwise"), answer("clockwise"))
    compared = compare_amounts(question, pair, seconds, answers)
    assert (compared.relation, compared.text) == (relation, text)
    assert compared.confidence == (0.0 if relation == "unknown" else 0.25)


@pytest.mark.parametrize(
    ("one", "other", "text"),
    [
        (measured(12), measured(14, "px"), "I cannot compare them: they move in different ways."),
        (measured(12), None, "I cannot compare them: not both of them turn or slide."),
        (
            measured(12, "px"),
            measured(30, "px"),
            "I cannot compare how far they slide: their frames differ in size.",
        ),
        (
            measured(1.2, "mm"),
            measured(3, "mm"),
            "I cannot compare how far they slide: their frames differ in size.",
        ),
    ],
)
def test_amounts_of_different_things_are_not_compared(one, other, text):
    answers = (answer("clockwise"), answer("left"))
    compared = compare_amounts(
        "Which went further?", [one, other], (None, None), answers, is_same_size=False
    )
    assert (compared.text, compared.abstained) == (text, True)


@pytest.mark.parametrize(
    ("question", "ways", "text"),
    [
        (
            "Which one turns more?",
            ("left", "down"),
            "Neither turns: the first is going left, the second going down, in the camera image.",
        ),
        (
            "Which slides further?",
            ("clockwise", "press"),
            "Neither slides: the first is going clockwise, the second pressing in, in the camera "
            "image.",
        ),
        (
            "Which slid less?",
            ("press", "still"),
            "Neither slides: the first is pressing in, the second holding still.",
        ),
    ],
)
def test_a_motion_that_neither_shows_is_not_compared(question, ways, text):
    pair = [measured(17, "px"), measured(6, "px")]
    compared = compare_amounts(question, pair, (None, None), [answer(way) for way in ways])
    assert (compared.text, compared.relation, compared.abstained) == (text, "unknown", True)


@pytest.mark.parametrize(
    ("motions", "text"),
    [
        (("clockwise", "left"), "First going clockwise, then going left, in the camera image."),
        (("press", "still"), "First pressing in, then holding still."),
    ],
)
def test_an_order_is_told_motion_by_motion(motions, text):
    order = order_of_motions([answer(motion) for motion in motions])
    assert (order.text, order.motions) == (text, motions)
    assert order.confidence == pytest.approx(0.64)


def test_an_order_more_likely_wrong_than_right_is_withheld():
    order = order_of_motions([answer("left", 0.7), answer("press", 0.7)])
    assert order.text == (
        "I cannot tell for sure, 49%: First going left, then pressing in, in the camera image."
    )
    assert (order.motions, order.confidence, order.abstained) == ((), 0.0, True)


def test_an_order_with_a_gap_is_withheld():
    order = order_of_motions([answer("left"), WITHHELD])
    assert order.text == "I cannot tell the order; of clip 2: I cannot say."
    assert (order.motions, order.abstained) == ((), True)


def test_results_are_plain_json_values():
    pair = [answer("left"), answer("right")]
    for result in (compare_directions(*pair), order_of_motions(pair)):
        values = json.loads(json.dumps(result.to_dict()))
        assert {"text", "confidence", "abstained"} <= set(values)


def test_the_seam_compares_two_clips(bundle):
    answerer = feeling(bundle, "up", temperature=0.1)
    clips = [answerer.encode(recording(seed=seed)) for seed in (1, 2)]
    assert answerer.compare(*clips).relation == "same"
    assert answerer.order(clips).motions == (Motion.UP, Motion.UP)
    with pytest.raises(ValueError, match="2 clips or more, found 1"):
        answerer.order(clips[:1])


def test_two_clips_are_compared_by_the_component_that_is_asked_about(bundle):
    def two(first, second, asked):
        answerer = feeling(bundle, *first)
        clips = [answerer.encode(recording(size=(224, 224)))]
        answerer.belief = believed(*second)
        return answerer.compare(*clips, answerer.encode(recording(size=(224, 224))), asked)

    mixed, other = ("clockwise", "left"), ("right", "clockwise")
    assert two(mixed, other, "Do they turn the same way?").decided == "yes"
    assert two(mixed, other, "Do they slide the same way?").relation == "opposite"
    assert two(mixed, other, "Which turned further?").text == "The first: about 12 and 5 deg."
    assert two(mixed, other, "Do both turn clockwise?").decided == "yes"
    assert two(mixed, other, "Which one slides left?").decided == "first"
    assert two(mixed, ("up",), "Which one turns?").decided == "first"


def test_turns_are_compared_whatever_the_size_of_the_frames():
    pair, answers = [measured(12), measured(27)], (answer("clockwise"), answer("clockwise"))
    compared = compare_amounts(
        "Which went further?", pair, (None, None), answers, is_same_size=False
    )
    assert compared.relation == "second"
