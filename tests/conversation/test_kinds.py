"""The rules' sort of question, against the type every template was written for."""

import numpy as np
import pytest

from geotlm_lm.conversation.claims import offered_options
from geotlm_lm.conversation.kinds import (
    asked_kind,
    asks_direction,
    asks_whether_moving,
    is_ruled_out,
)
from geotlm_lm.conversation.motion_names import claimed_motion, motions_named
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
        ("Give the rotation angle in radians.", "magnitude"),
        ("rotation angle", "magnitude"),
        ("What's the angle?", "magnitude"),
        ("slip distance", "magnitude"),
        ("by what angle in radians", "magnitude"),
        ("how many arcminutes did it turn", "magnitude"),
        ("What is the angle of view?", None),
        ("Is the cap at an angle?", None),
        ("deg per second?", "rate"),
        ("which way would undo that", "undo"),
        ("does righty tighten it", "thread"),
        ("and rewound?", "reversed"),
        ("what if it ran from the end to the start?", "reversed"),
        ("does lefty loosey hold here?", "thread"),
        ("what makes you think so?", "evidence"),
        ("how much would you stake on it?", "confidence"),
        ("more than 90% sure?", "confidence"),
        ("100%?", "confidence"),
        ("are you 80 percent certain", "confidence"),
        ("Prove it.", "evidence"),
        ("Explain.", "evidence"),
        ("angle", "magnitude"),
        ("what is the rotation angle?", "magnitude"),
        ("in radians please", "magnitude"),
        ("omega?", "rate"),
        ("from which angle is it seen?", None),
        ("explain the motion", None),
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


@pytest.mark.parametrize(
    ("question", "kind"),
    [
        # The sensor's own motion, and a place on the sensor.
        ("Which way does it move across the surface of the gel?", None),
        ("Does it slide towards the middle of the sensor?", None),
        ("Is the contact at the edge of the gel?", None),
        ("Which way does it slide in front of the gripper?", None),
        ("Does it turn about the centre of the pad?", None),
        ("Is it near the border of the sensor?", None),
        ("What touches the tip of the finger?", None),
        ("Direction of the gel?", "actor"),
        ("What is the rotation of the gripper?", "actor"),
        # A clip played backwards, and a motion the other way.
        ("Is the part slipping backwards?", None),
        ("Does it reverse direction?", None),
        ("Did the motion reverse?", None),
        ("Is it a reverse thread?", None),
        ("Does the nut slide backwards a bit?", None),
        ("Was the rotation reversed?", None),
        ("Has the cap moved backwards?", None),
        ("And if it were reversed?", "reversed"),
        ("Suppose it ran backwards: which way?", "reversed"),
        ("Which way would it be when played in reverse?", "reversed"),
        ("so backwards?", "reversed"),
        # What undoes a motion, and one that comes back.
        ("Is it going back and forth?", None),
        ("Does it go back to the left?", None),
        ("Did the cap go back?", None),
        ("Is it going to go back?", None),
        ("Has the nut been going back?", None),
        ("Which way did it go back?", None),
        ("Which way must I go to go back?", "undo"),
        ("How can it go back to the start?", "undo"),
        ("Which way do I go back?", "undo"),
        # A thread, and things that are screws or loose.
        ("Which way do the screws turn?", None),
        ("Which way does the loose cap turn?", None),
        ("Is the grip tight?", None),
        ("Is the connector loose?", None),
        ("How are the screws moving?", None),
        ("Which way does the tight lid slide?", None),
        ("Which way screws it in?", "thread"),
        ("Is the nut working loose?", "thread"),
        ("Did he unscrew it?", "thread"),
        # A mirrored clip, and a thing that is flipped.
        ("Did the part flip?", None),
        ("Was the box flipped?", None),
        ("Has the coin flipped over?", None),
        ("Does the pancake flip?", None),
        ("Did you flip it?", None),
        ("What if the video were flipped?", "mirrored"),
        ("and if it were flipped?", "mirrored"),
        ("After the flip, which way?", "mirrored"),
        # An amount of motion, and the size of a thing.
        ("How big is the screw?", None),
        ("What is the size of the object?", None),
        ("How large is the imprint?", None),
        ("How small are the parts?", None),
        ("How big is the turn?", "magnitude"),
        ("How large was its displacement?", "magnitude"),
        ("How large is it?", "magnitude"),
        ("How big was that?", "magnitude"),
        ("How big is that nut?", None),
        ("What is the size of the slide?", "magnitude"),
        # Two clips, and one beside its first frame.
        ("How far did it move compared to the first frame?", "magnitude"),
        ("How far does it slide in this sequence?", "magnitude"),
        ("How much did it turn compared with the start?", "magnitude"),
        ("How fast does it go in the sequence?", "rate"),
        ("How is it compared to the other clip?", "comparison"),
        ("What is the sequence of events?", "order"),
    ],
)
def test_a_kind_is_told_by_phrases_and_not_by_a_word_of_them(question, kind):
    assert asked_kind(question) == kind


@pytest.mark.parametrize(
    ("question", "kind", "is_out"),
    [
        ("How much do they differ?", "magnitude", False),
        ("How much do they differ?", "rate", True),
        ("How fast is the second one?", "rate", False),
        ("How fast is the second one?", "comparison", False),
        ("Do they go the same way?", "comparison", False),
        ("Do they go the same way?", "mirrored", True),
        ("Do they go the same way?", "direction", False),
    ],
)
def test_words_of_several_clips_leave_an_answer_of_which_the_other_words_tell(
    question, kind, is_out
):
    assert is_ruled_out(question, kind) is is_out


@pytest.mark.parametrize(
    ("question", "is_open"),
    [
        ("Which way does it move across the surface of the gel?", True),
        ("Which way is it going on the sensor?", True),
        ("What direction does it take over the gel?", True),
        ("Which way is the gel moving?", False),
        ("Which way does the sensor see it?", False),
    ],
)
def test_a_motion_over_the_gel_is_the_objects(question, is_open):
    assert asks_direction(question) is is_open


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
