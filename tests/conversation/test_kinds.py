"""The rules' sort of question, against the type every template was written for."""

import numpy as np
import pytest

from geotlm_lm.conversation.claims import claimed_motion, motions_named, offered_options
from geotlm_lm.conversation.kinds import (
    asked_amount,
    asked_kind,
    asks_direction,
    asks_whether_moving,
)
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.questions import questions_for
from geotlm_lm.data.templates import load_templates

TEMPLATES = load_templates()
HELD_BY_EVERY_MODEL = ("T1", "T2", "T3", "T5", "T6", "T16", "T17")
ROUNDS = 6
CLAIM_OF = {"T2": "Yes", "T4": "It is: ", "T18": "That holds"}


def questions(type_id, wordings):
    rng = np.random.default_rng(11)
    return [
        asked
        for _ in range(ROUNDS)
        for motion in Motion
        for asked in questions_for(
            MotionLabel(motion), rng, types=[type_id], wordings=wordings, per_type=2
        )
    ]


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
@pytest.mark.parametrize("type_id", TEMPLATES.types)
def test_every_wording_is_taken_for_its_own_kind(type_id, wordings):
    kind = None if type_id in HELD_BY_EVERY_MODEL else TEMPLATES.types[type_id].kind
    found = {(asked_kind(q.question), q.question) for q in questions(type_id, wordings)}
    assert {pair for pair in found if pair[0] != kind} == set()


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
@pytest.mark.parametrize("type_id", CLAIM_OF)
def test_the_claim_of_a_question_is_the_motion_it_was_filled_with(type_id, wordings):
    grammar = TEMPLATES.grammar()
    for asked in questions(type_id, wordings):
        (claim,) = (
            grammar.parse(option).direction
            for option in asked.options
            if option.startswith(CLAIM_OF[type_id])
        )
        assert claimed_motion(asked.question) == claim, asked.question


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_the_options_of_a_choice_are_read_with_their_letters(wordings):
    grammar = TEMPLATES.grammar()
    for asked in questions("T3", wordings):
        options = [grammar.parse(option) for option in asked.options]
        assert offered_options(asked.question) == {o.letter: o.direction for o in options}, asked


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("is it turning counter-clockwise?", {Motion.COUNTERCLOCKWISE}),
        ("anticlockwise, am I right?", {Motion.COUNTERCLOCKWISE}),
        ("is it right?", {Motion.RIGHT}),
        ("it slides left, right?", {Motion.LEFT}),
        ("the upper half and the right half?", set()),
        ("left-hand thread", set()),
        ("mirrored left to right", set()),
        ("what is it up to?", set()),
        ("pressing down", {Motion.PRESS}),
        ("left or right", {Motion.LEFT, Motion.RIGHT}),
    ],
)
def test_words_of_motion_in_another_sense_name_no_motion(text, named):
    assert motions_named(text) == named
    assert claimed_motion(text) == (next(iter(named)) if len(named) == 1 else None)


@pytest.mark.parametrize(
    ("question", "kind"),
    [
        ("Is it speeding up?", "rate"),
        ("Is the lid accelerating?", "rate"),
        ("More than 5 degrees?", "magnitude"),
        ("how many degrees was that", "magnitude"),
        ("How many pixels did it slide?", "magnitude"),
        ("more than 10 px?", "magnitude"),
        ("pixels or degrees?", "magnitude"),
        ("how many millimeters was that", "magnitude"),
        ("deg per second?", "rate"),
        ("which way would undo that", "undo"),
        ("does righty tighten it", "thread"),
        ("and rewound?", "reversed"),
        ("what if it ran from the end to the start?", "reversed"),
        ("does lefty loosey hold here?", "thread"),
        ("what makes you think so?", "evidence"),
        ("how much would you stake on it?", "confidence"),
        ("and for somebody facing the sensor?", "viewpoint"),
        ("which way did the gripper move?", "actor"),
        ("I bet it goes left", None),
        ("what colour is it?", None),
        ("is it cw?", None),
        ("Which way is the belt going?", None),
        ("is it not touching anything?", None),
        ("", None),
    ],
)
def test_questions_nobody_wrote_a_template_for_find_their_kind(question, kind):
    assert asked_kind(question) == kind


def test_only_open_questions_about_direction_are_surely_those():
    recognised = {
        type_id: np.mean(
            [
                asks_direction(one.question)
                for wordings in ("seen", "held_out")
                for one in questions(type_id, wordings)
            ]
        )
        for type_id in TEMPLATES.types
    }
    assert recognised.pop("T1") > 0.35
    assert set(recognised.values()) == {0.0}


@pytest.mark.parametrize(
    ("question", "is_asked"),
    [
        ("Did it budge?", True),
        ("has anything shifted yet?", True),
        ("and does the lid stir at all", True),
        ("Is the cap moving left?", False),
        ("Which way did it move?", False),
        ("Did the price move?", False),
        ("Will it move?", False),
        ("Is the belt moved by a motor?", False),
    ],
)
def test_whether_anything_moves_is_asked_in_many_words(question, is_asked):
    assert asks_whether_moving(question) is is_asked


def test_no_question_of_another_kind_asks_whether_anything_moves():
    kinds = {
        one.slots.kind
        for type_id in TEMPLATES.types
        for wordings in ("seen", "held_out")
        for one in questions(type_id, wordings)
        if asks_whether_moving(one.question)
    }
    assert kinds == {"moving"}


@pytest.mark.parametrize(
    ("question", "kind", "amount"),
    [
        ("How many degrees clockwise did it turn?", "premise", "magnitude"),
        ("How many mm did it slide to the left?", "premise", "magnitude"),
        ("How fast does it turn clockwise?", "premise", "rate"),
        ("How many radians?", "magnitude", "magnitude"),
        ("How many turns did it make?", "magnitude", "magnitude"),
        ("and in radians?", "magnitude", "magnitude"),
        ("How many px/s?", "rate", "rate"),
        ("How many degrees per minute?", "rate", "rate"),
        ("Since when does it turn clockwise?", "premise", None),
    ],
)
def test_an_amount_is_asked_for_beside_a_motion_taken_for_granted(question, kind, amount):
    assert (asked_kind(question), asked_amount(question)) == (kind, amount)
