"""What is read of every question that the model is trained and examined on."""

from functools import cache

import numpy as np
import pytest

from geotlm_lm.conversation.kinds import asked_kind, asks_direction, asks_whether_moving
from geotlm_lm.conversation.motion_claims import offered_options
from geotlm_lm.conversation.motion_names import claimed_motion
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for, with_typo
from geotlm_lm.data.templates import load_templates
from tests.conversation.questions import COLUMNS
from tests.conversation.reading import reading

TEMPLATES = load_templates()
HELD_BY_EVERY_MODEL = ("T1", "T2", "T3", "T5", "T6", "T16", "T17")
STATE_A_FACT = ("T11", "T12")
BEYOND_TOUCH = "T17"
CLAIM_OF = {"T2": "Yes", "T4": "It is: ", "T18": "That holds"}
"""Types that claim a motion -> how the answer begins that names it."""
MEANS_MORE = {
    "amount",
    "unread_amount",
    "denied_amount",
    "alternatives",
    "future",
    "option_sets",
    "neither",
    "kinds_offered",
    "claimed_half",
    "whole_claim",
    "answered_as",
    "components",
    "frame_asked",
    "which_moves",
    "recording",
    "scale",
    "parts",
    "lasting",
    "lacks",
    "is_fact",
    "remedy",
}
"""What no template asks: a rule that reads it takes a question away from the model."""


@cache
def asked_of(type_id, wordings):
    """Questions of one type, of every motion."""
    rng = np.random.default_rng(11)
    return [
        asked
        for motion in Motion
        for asked in questions_for(
            MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0),
            rng,
            types=[type_id],
            wordings=wordings,
            per_type=12,
        )
    ]


every_type = pytest.mark.parametrize("type_id", TEMPLATES.types)
both_wordings = pytest.mark.parametrize("wordings", ["seen", "held_out"])


@both_wordings
@every_type
def test_every_wording_is_taken_for_its_own_kind(type_id, wordings):
    kind = None if type_id in HELD_BY_EVERY_MODEL else TEMPLATES.types[type_id].kind
    found = {(asked_kind(one.question), one.question) for one in asked_of(type_id, wordings)}
    assert {pair for pair in found if pair[0] != kind} == set()


@both_wordings
@every_type
def test_nothing_is_read_into_a_question_that_it_does_not_say(type_id, wordings):
    read_more = {}
    for one in asked_of(type_id, wordings)[::3]:
        read = reading(one.question, COLUMNS)
        more = MEANS_MORE & read.keys()
        more |= {"frame"} & read.keys() if type_id not in STATE_A_FACT else set()
        more |= {"untold"} & read.keys() if type_id != BEYOND_TOUCH else set()
        more |= {"is_english"} & read.keys()
        if len(read.get("changes", [])) > 1:
            more |= {"changes"}
        if more:
            read_more[one.question] = more
    assert read_more == {}


@both_wordings
@pytest.mark.parametrize("type_id", CLAIM_OF)
def test_the_claim_of_a_question_is_the_motion_it_was_filled_with(type_id, wordings):
    grammar = TEMPLATES.grammar()
    for asked in asked_of(type_id, wordings):
        (claim,) = (
            grammar.parse(option).direction
            for option in asked.options
            if option.startswith(CLAIM_OF[type_id])
        )
        assert claimed_motion(asked.question) == claim, asked.question


@both_wordings
def test_the_options_of_a_choice_are_read_with_their_letters(wordings):
    grammar = TEMPLATES.grammar()
    for asked in asked_of("T3", wordings):
        options = [grammar.parse(option) for option in asked.options]
        assert offered_options(asked.question) == {o.letter: o.direction for o in options}, asked


def test_only_open_questions_about_direction_are_surely_those():
    recognised = {
        type_id: np.mean(
            [
                asks_direction(one.question)
                for wordings in ("seen", "held_out")
                for one in asked_of(type_id, wordings)
            ]
        )
        for type_id in TEMPLATES.types
    }
    assert recognised.pop("T1") > 0.35
    assert set(recognised.values()) == {0.0}


def test_only_questions_whether_it_moves_ask_whether_anything_does():
    kinds = {
        one.slots.kind
        for type_id in TEMPLATES.types
        for wordings in ("seen", "held_out")
        for one in asked_of(type_id, wordings)
        if asks_whether_moving(one.question)
    }
    assert kinds == {"moving"}


@both_wordings
@every_type
def test_a_mistyped_question_is_still_english(type_id, wordings):
    rng = np.random.default_rng(3)
    mistyped = [with_typo(one.question, rng) for one in asked_of(type_id, wordings)]
    foreign = [text for text in mistyped if reading(text, COLUMNS) == {"is_english": False}]
    assert foreign == []
