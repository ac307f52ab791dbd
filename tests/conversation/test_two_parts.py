"""Texts that ask two things, and what no model is asked; questions of templates are neither."""

import numpy as np
import pytest

from geotlm_lm.conversation.kinds import asked_kind
from geotlm_lm.conversation.statements import states_more
from geotlm_lm.conversation.two_parts import two_parts
from geotlm_lm.conversation.untold import asks_place, untold
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("which way is it turning and how far?", ("which way is it turning", "how far?")),
        (
            "is the lid rotating cw or ccw and by how many degrees?",
            ("is the lid rotating cw or ccw", "how many degrees?"),
        ),
        (
            "First: is there contact? Second: which way does it turn?",
            ("is there contact?", "which way does it turn?"),
        ),
        ("Does it move? How fast?", ("Does it move?", "How fast?")),
        (
            "Which way does it turn, how far and how fast?",
            ("Which way does it turn", "how far and how fast?"),
        ),
        ("Which way does it turn and why?", ("Which way does it turn", "why?")),
        ("Which way does it slide and are you sure?", ("Which way does it slide", "are you sure?")),
        (
            "Is there contact? Where? Which way does it move?",
            ("Is there contact?", "Where is the contact? Which way does it move?"),
        ),
        (
            "Which colour is the cap and which way does it turn?",
            ("Which colour is the cap", "which way does it turn?"),
        ),
        ("clockwise? how many degrees?", ("clockwise?", "how many degrees?")),
        ("direction & angle", ("direction", "angle")),
        ("Why does it turn clockwise?", ("Does it turn clockwise?", "Why?")),
        ("So why did the cap slide left?", ("Did the cap slide left?", "Why?")),
        ("Why is it turning?", None),
        ("Why does it turn clockwise so slowly?", None),
        ("Why do you say left?", None),
        ("If the image is mirrored, how far?", None),
        ("Seen from the object's side and which way?", None),
        ("Hello there? Which way?", None),
        ("Which way? A) left B) right", None),
        ("Which way? Which direction?", None),
        ("Which way is it turning?", None),
        ("salt and how far?", None),
    ],
)
def test_a_text_is_parted_where_both_parts_ask(text, parts):
    assert two_parts(text) == parts


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_question_of_the_templates_is_parted_or_taken_for_a_statement(wordings):
    rng = np.random.default_rng(3)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=8):
            assert two_parts(asked.question) is None, asked
            assert not states_more(asked.question), asked
            assert not asks_place(asked.question), asked
            is_declined = asked_kind(asked.question) is None and untold(asked.question)
            assert not is_declined or asked.type_id == "T17", asked
