"""What a question about two clips claims: a relation, or motions of one, both or neither."""

import pytest

from geotlm_lm.conversation.two_claims import (
    MOVING,
    TOUCHED,
    asks_of_two,
    asks_same_amount,
    asks_undoing,
    claimed_each,
    claimed_image,
    claimed_relation,
    claimed_share,
    claimed_subject,
    claims_same_kind,
    supposed_change,
)
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion


@pytest.mark.parametrize(
    ("text", "of", "motions"),
    [
        ("Which one turns clockwise?", "which", {Motion.CLOCKWISE}),
        ("Do both turn clockwise?", "both", {Motion.CLOCKWISE}),
        ("Does either turn clockwise?", "either", {Motion.CLOCKWISE}),
        ("Does neither slide?", "neither", set(SLIDES)),
        ("Which one slides?", "which", set(SLIDES)),
        ("Which one moves?", "which", MOVING),
        ("In which one is the object slipping?", "which", set(SLIDES)),
        ("Which one is touched?", "which", TOUCHED),
        ("Which of the two is rotating?", "which", set(ROTATIONS)),
        ("Which one, if any, presses?", "which", {Motion.PRESS}),
        ("Which one doesn't move?", "which", set(Motion) - MOVING),
        ("Is one of them still?", "either", {Motion.STILL}),
        ("Does only one of them turn?", "one", set(ROTATIONS)),
        ("Only the second moves left, right?", "second", {Motion.LEFT}),
        ("Do they both go up?", "both", {Motion.UP}),
        ("Do both move sideways?", "both", {Motion.LEFT, Motion.RIGHT}),
        ("Are both rotations?", "both", set(ROTATIONS)),
        ("Which one is lifting off, first or second?", "which", {Motion.RELEASE}),
    ],
)
def test_motions_are_asked_of_one_both_or_neither(text, of, motions):
    claim = claimed_share(text)
    assert (claim.of, claim.motions) == (of, motions)
    assert asks_of_two(text)


@pytest.mark.parametrize(
    "text",
    [
        "Which way does it turn?",
        "Which half moves which way?",
        "Do both halves move?",
        "Does it turn clockwise?",
        "Is it moving at all?",
        "Is it neither turning nor sliding?",
        "Which one is it?",
        "Which hand should turn it?",
        "How far does it go?",
        "Is either side of the cap moving?",
    ],
)
def test_questions_about_one_clip_are_not_of_two(text):
    assert not asks_of_two(text)


@pytest.mark.parametrize(
    ("text", "relation", "is_denied", "is_plain"),
    [
        ("Do they go the same way?", "same", False, True),
        ("The same?", "same", False, True),
        ("They turn the same way, right?", "same", False, False),
        ("Do they turn in the same direction, yes or no?", "same", False, False),
        ("They don't turn the same way, do they?", "same", False, False),
        ("Is it false that they move the same way?", "same", True, False),
        ("Are they opposite?", "opposite", False, False),
        ("Is there a difference?", "different", False, False),
        ("Do the two clips differ?", "different", False, False),
    ],
)
def test_a_claimed_relation_is_read(text, relation, is_denied, is_plain):
    claim = claimed_relation(text)
    assert (claim.relation, claim.is_denied, claim.is_plain) == (relation, is_denied, is_plain)


@pytest.mark.parametrize(
    "text", ["The same or opposite?", "What is the difference?", "How do they differ?", "Compare."]
)
def test_an_open_question_claims_no_relation(text):
    assert claimed_relation(text) is None


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (
            "If the second clip were mirrored, would they turn the same way?",
            ("do they turn the same way?", 1, "mirrored"),
        ),
        (
            "Would they be the same if the first was played backwards?",
            ("do they be the same ?", 0, "reversed"),
        ),
        (
            "Do they match, if clip 2 is flipped?",
            ("do they match ?", 1, "mirrored"),
        ),
        ("Do they turn the same way?", None),
        ("If the image were mirrored, which way?", None),
    ],
)
def test_a_clip_supposed_to_be_changed_is_found(text, found):
    assert supposed_change(text) == found


def test_a_clip_may_be_claimed_to_be_the_image_of_the_other():
    assert claimed_image("Is the second the mirror image of the first?") == "mirrored"
    assert claimed_image("Is clip 1 the reverse of clip 2?") == "reversed"
    assert claimed_image("Is the first one played backwards?") is None
    assert claimed_image("Is the image mirrored?") is None


def test_undoing_each_other_is_asked():
    assert asks_undoing("Do they undo each other?")
    assert asks_undoing("Do the two cancel out?")
    assert not asks_undoing("What undoes it?")


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("Do they turn the same amount?", "magnitude"),
        ("Do they turn by the same angle?", "magnitude"),
        ("Did they slide equally far?", "magnitude"),
        ("Do they go at the same speed?", "rate"),
        ("Is the first as fast as the second?", "rate"),
        ("Do they turn the same way?", None),
        ("How much do they turn?", None),
    ],
)
def test_equal_amounts_are_asked_for(text, kind):
    assert asks_same_amount(text) == kind


@pytest.mark.parametrize(
    ("text", "subject"),
    [
        ("Is the second one faster than the first?", 1),
        ("Did the first turn more?", 0),
        ("So is clip 2 slower?", 1),
        ("Which one is faster?", None),
    ],
)
def test_the_clip_that_is_claimed_to_go_further_is_found(text, subject):
    assert claimed_subject(text) == subject


def test_a_claim_on_each_clip_is_read():
    asked = "Is the first clockwise and the second counterclockwise?"
    assert claimed_each(asked) == ({Motion.CLOCKWISE}, {Motion.COUNTERCLOCKWISE})
    asked = "Does the second one slide while the first one is still?"
    assert claimed_each(asked) == ({Motion.STILL}, set(SLIDES))
    assert claimed_each("Is the first one turning?") is None


@pytest.mark.parametrize(
    ("text", "is_one"),
    [
        ("Do they have the same kind of motion?", True),
        ("Same type of movement?", True),
        ("Are they different kinds of motion?", False),
        ("Do they differ in kind?", False),
        ("Aren't they the same kind?", True),
        ("They're not the same kind, right?", False),
        ("not the same kind?", False),
        ("Which kind of motion is the same?", None),
        ("Same kind and direction?", None),
        ("Do they differ in kind or in direction?", None),
        ("Same class of object?", None),
        ("Is the first a different kind of turn?", None),
        ("Do they go the same way?", None),
    ],
)
def test_one_kind_or_two_may_be_claimed(text, is_one):
    assert claims_same_kind(text) is is_one
