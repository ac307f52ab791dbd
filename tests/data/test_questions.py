import re
from collections import Counter

import numpy as np
import pytest
from sklearn.feature_extraction.text import TfidfVectorizer
from sklearn.linear_model import LogisticRegression

from geotlm_lm.core.labels import Motion, MotionClass, MotionLabel
from geotlm_lm.data.distractors import draw_option_set
from geotlm_lm.data.questions import questions_for, with_typo
from geotlm_lm.data.templates import load_templates

ROUNDS = 120


@pytest.fixture(scope="module")
def asked():
    """Questions of every type about every motion, evenly, in both shares of the wordings."""
    rng = np.random.default_rng(7)
    return [
        question
        for wordings in ("seen", "held_out")
        for _ in range(ROUNDS)
        for motion in Motion
        for question in questions_for(MotionLabel(motion), rng, wordings=wordings)
    ]


def target(question):
    """What a leak would betray: the verdict, the letter, or else the whole answer."""
    verdicts = dict.fromkeys(("T2", "T4", "T18"), question.slots.verdict)
    return (verdicts | {"T3": question.slots.letter}).get(question.type_id, question.answer)


ONE_ANSWER = {"T9", "T17", "T19", "T22"}
"""Types whose questions are all answered alike: there is nothing to betray."""


NAMES_MOTIONS = {"T2", "T3", "T4", "T18"}
"""Types whose questions claim or offer motions, the true one among them as often as rules say."""


def assert_at_chance(texts, targets):
    """Fit a bag of words on half of the texts: on the other half it must not beat the commonest."""
    texts, targets = np.array(texts), np.array([str(one) for one in targets])
    order = np.random.default_rng(1).permutation(len(texts))
    train, test = order[: len(order) // 2], order[len(order) // 2 :]
    vectors = TfidfVectorizer(token_pattern=r"[^\s]+")
    features = vectors.fit_transform(texts[train])
    model = LogisticRegression(max_iter=300).fit(features, targets[train])
    accuracy = model.score(vectors.transform(texts[test]), targets[test])
    chance = max(Counter(targets[test]).values()) / len(test)
    # Four standard errors of a share p over the n test questions.
    assert accuracy < chance + 4 * np.sqrt(chance * (1 - chance) / len(test))


@pytest.mark.parametrize("type_id", sorted(set(load_templates().types) - ONE_ANSWER - {"T3"}))
def test_question_text_alone_predicts_no_answer(asked, type_id):
    of_type = [question for question in asked if question.type_id == type_id]
    assert_at_chance([q.question for q in of_type], [target(q) for q in of_type])


@pytest.mark.parametrize("count", [2, 3, 4])
def test_the_true_letter_is_uniform_and_the_text_of_a_choice_alone_predicts_none(asked, count):
    # With fewer options fewer letters are possible, and that is no leak.
    of_type = [q for q in asked if q.type_id == "T3" and len(q.options) == count]
    letters = [q.slots.letter for q in of_type]
    assert_at_chance([q.question for q in of_type], letters)
    shares = np.array(list(Counter(letters).values())) / len(letters)
    assert len(shares) == count
    assert np.abs(shares - 1 / count).max() < 4 * np.sqrt(1 / count / len(letters))


@pytest.mark.parametrize("type_id", sorted(set(load_templates().types) - NAMES_MOTIONS))
def test_question_text_alone_predicts_no_motion(type_id):
    """Also where every question has the same answer: a blind model may use any hint of a motion."""
    rng = np.random.default_rng(17)
    pairs = [
        (question.question, motion)
        for _ in range(ROUNDS // 3)
        for motion in Motion
        for wordings in ("seen", "held_out")
        for question in questions_for(MotionLabel(motion), rng, types=[type_id], wordings=wordings)
    ]
    assert_at_chance(*zip(*pairs, strict=True))


@pytest.mark.parametrize("type_id", ["T1", "T10", "T11", "T12", "T13", "T14", "T15", "T21"])
def test_every_answer_that_names_the_motion_is_right_equally_often(asked, type_id):
    counts = Counter(question.answer for question in asked if question.type_id == type_id)
    assert len(counts) == len(Motion)
    assert len(set(counts.values())) == 1


@pytest.mark.parametrize(
    ("type_id", "of_claim"), [("T2", "Yes"), ("T4", "It is: "), ("T18", "That holds")]
)
def test_a_claim_is_true_half_of_the_time_whatever_it_claims(asked, type_id, of_claim):
    by_claim = {}
    for question in (question for question in asked if question.type_id == type_id):
        claim = next(o for o in question.options if o.startswith(of_claim))
        by_claim.setdefault(claim, []).append(question.slots.verdict)
    assert len(by_claim) == len(Motion)
    for verdicts in by_claim.values():
        assert abs(np.mean(verdicts) - 0.5) < 4 * 0.5 / np.sqrt(len(verdicts))


@pytest.mark.parametrize("count", [2, 3, 4])
def test_a_set_is_as_likely_whichever_member_is_true(count):
    rng = np.random.default_rng(0)
    seen = Counter()
    for truth in Motion:
        for _ in range(2000):
            options = draw_option_set(truth, count, rng)
            assert truth in options
            assert len(set(options)) == count
            seen[frozenset(options), truth] += 1
    sets = {chosen for chosen, _ in seen}
    for chosen in sets:
        counts = np.array([seen[chosen, truth] for truth in chosen])
        # A chi-square of equal rates with count - 1 degrees of freedom; 30 has p < 1e-6.
        assert ((counts - counts.mean()) ** 2).sum() / counts.mean() < 30


def test_an_unreadable_motion_gets_no_question_about_it():
    label = MotionLabel(Motion.CLOCKWISE, is_readable=False)
    rng = np.random.default_rng(0)
    asked = {q.type_id for q in questions_for(label, rng, per_type=9)}
    assert asked == {"T6"} | ONE_ANSWER
    assert questions_for(label, rng, types=["T1", "T2", "T3"]) == []


@pytest.mark.parametrize(
    ("motion", "kind", "touches", "moves"),
    [
        (Motion.CLOCKWISE, MotionClass.ROTATION, True, True),
        (Motion.UP, MotionClass.SLIDE, True, True),
        (Motion.RELEASE, MotionClass.RELEASE, True, True),
        (Motion.STILL, MotionClass.STILL, True, False),
        (Motion.NONE, MotionClass.NONE, False, False),
    ],
)
def test_class_contact_and_movement_follow_the_label(motion, kind, touches, moves):
    rng = np.random.default_rng(0)
    found = {q.type_id: q.slots for q in questions_for(MotionLabel(motion), rng)}
    assert found["T1"].direction == motion
    assert found["T5"].motion_class == kind
    assert found["T6"].verdict == touches
    assert found["T16"].verdict == moves


def test_no_claim_is_denied_twice(asked):
    texts = [q.question.lower() for q in asked if q.type_id in ("T4", "T18")]
    assert not [text for text in texts if re.search(r"\bnot (touching|not)\b", text)]


def test_a_denial_is_true_where_the_claim_is_not():
    rng = np.random.default_rng(2)
    asked = questions_for(MotionLabel(Motion.LEFT), rng, types=["T4"], per_type=40)
    assert {q.slots.verdict for q in asked} == {True, False}
    for question in asked:
        claims_left = next(o for o in question.options if o.startswith("It is: ")) == (
            "It is: it goes left in the camera image."
        )
        assert question.slots.verdict == (not claims_left)


@pytest.mark.parametrize("type_id", ["T7", "T8"])
@pytest.mark.parametrize(
    ("motion", "unit", "amount"), [(Motion.COUNTERCLOCKWISE, "deg", 15.0), (Motion.UP, "px", 20.0)]
)
def test_the_amount_is_known_and_its_unit_said(type_id, motion, unit, amount):
    label = MotionLabel(motion, rotation_deg=-15.0, slide_y_mm=-1.4, mm_per_px=(0.1, 0.07))
    (asked,) = questions_for(label, np.random.default_rng(0), types=[type_id])
    assert asked.slots.unit == unit
    assert asked.amount == pytest.approx(amount)


@pytest.mark.parametrize("type_id", ["T7", "T8"])
def test_what_has_no_amount_is_answered_with_what_it_does(type_id):
    label = MotionLabel(Motion.PRESS, depth_change_mm=0.7, mm_per_px=(0.1, 0.1))
    (asked,) = questions_for(label, np.random.default_rng(0), types=[type_id])
    assert (asked.amount, asked.slots.unit, asked.slots.direction) == (None, None, Motion.PRESS)


@pytest.mark.parametrize(
    ("motion", "evidence"),
    [
        # x runs right, y down: clockwise as drawn carries the top to the right.
        (Motion.CLOCKWISE, "The upper half goes right, the lower half left, the left half up, "),
        (Motion.LEFT, "Both halves go left together. "),
        (Motion.PRESS, "The halves go apart. "),
    ],
)
def test_the_evidence_is_where_the_halves_go(motion, evidence):
    (asked,) = questions_for(MotionLabel(motion), np.random.default_rng(0), types=["T10"])
    assert asked.answer.startswith(evidence)


@pytest.mark.parametrize("type_id", ["T11", "T12", "T13", "T14", "T15", "T21"])
def test_questions_of_the_frame_are_answered_with_the_motion_in_the_camera_image(type_id):
    (asked,) = questions_for(MotionLabel(Motion.LEFT), np.random.default_rng(0), types=[type_id])
    assert asked.slots.direction is Motion.LEFT
    assert asked.answer.endswith(": left in the camera image.")


def test_the_answer_is_one_of_the_options_and_no_option_stands_twice(asked):
    assert all(question.answer in question.options for question in asked)
    assert all(len(set(question.options)) == len(question.options) for question in asked)


def test_held_out_wordings_never_appear_among_seen_ones(asked):
    half = len(asked) // 2
    ids = [{(q.type_id, q.wording_id) for q in part} for part in (asked[:half], asked[half:])]
    assert not ids[0] & ids[1]


def test_questions_are_typed_in_more_than_one_way(asked):
    texts = [question.question for question in asked]
    assert 0.25 < np.mean([text == text.lower() for text in texts]) < 0.6
    assert 0.15 < np.mean([text[-1] not in "?." for text in texts]) < 0.6


def test_a_typo_changes_one_longer_word_between_its_first_and_last_letter():
    question, changed = "is my battery moving left", set()
    for seed in range(40):
        words = with_typo(question, np.random.default_rng(seed)).split()
        (at,) = [i for i, (a, b) in enumerate(zip(question.split(), words, strict=True)) if a != b]
        was, now = question.split()[at], words[at]
        assert (was[0], was[-1]) == (now[0], now[-1])
        assert abs(len(was) - len(now)) <= 1
        changed.add(was)
    assert changed == {"battery", "moving"}
    too_short = "is it cw or left?"
    assert with_typo(too_short, np.random.default_rng(0)) == too_short
