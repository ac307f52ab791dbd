"""What is asked of two clips: their relation, one of them, or neither."""

import numpy as np
import pytest

from geotlm_lm.answering.several import asks_amount
from geotlm_lm.conversation.two_clips import (
    asks_each_amount,
    asks_of_one,
    of_two_in_known_words,
    relates,
)
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_every_template_of_a_comparison_is_one(wordings):
    rng, label = np.random.default_rng(3), MotionLabel(Motion.LEFT)
    for _ in range(200):
        (asked,) = questions_for(label, rng, types=["T9"], wordings=wordings)
        assert asks_of_one(asked.question) is None, asked.question
        assert asks_amount(asked.question) or relates(asked.question), asked.question


@pytest.mark.parametrize(
    ("text", "does"),
    [
        ("Do they go the same way?", True),
        ("Are they the same?", True),
        ("Same object, the same way?", True),
        ("What is the difference between the two clips?", True),
        ("Are both still?", True),
        ("Are they the same object?", False),
        ("Do they have a similar shape?", False),
        ("Do they look alike?", False),
        ("Are both round?", False),
        ("Hello", False),
    ],
)
def test_what_is_no_relation_of_motions_is_told_apart(text, does):
    assert relates(text) is does


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        ("Which way does the second one go?", (1, "which way does it go?")),
        ("Is the first clip turning clockwise?", (0, "is it turning clockwise?")),
        ("Which way does the first go?", (0, "which way does it go?")),
        ("What is the second one's direction?", (1, "what is its direction?")),
        ("How far does clip 2 go?", (1, "how far does it go?")),
        ("And the first one?", (0, "")),
        ("the second of the two", (1, "")),
        ("Which way does it turn in the second clip?", (1, "which way does it turn?")),
        ("In the first clip, which way does it go?", (0, "which way does it go?")),
        ("How far does it slide in clip 2?", (1, "how far does it slide?")),
        ("Is it turning clockwise in the first one?", (0, "is it turning clockwise?")),
        ("Does it turn further in the second clip?", None),
        ("Does it turn the same way in the second clip?", None),
        ("Does it move like this in the second clip?", None),
        ("Is it the second clip?", None),
        ("Does the first one go further than the second?", None),
        ("Is this the same as the first one?", None),
        ("Is the second one faster?", None),
        ("Is it the first time?", None),
    ],
)
def test_a_question_about_one_of_them_is_told_as_of_a_single_clip(text, asked):
    assert asks_of_one(text) == asked


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("How far do they go?", "magnitude"),
        ("How fast are they?", "rate"),
        ("Do they go the same way?", None),
    ],
)
def test_amounts_of_each_are_asked_for(text, kind):
    assert asks_each_amount(text) == kind


@pytest.mark.parametrize(
    ("text", "known"),
    [
        ("Did the direction change?", "Are they different?"),
        ("and has it changed direction?", "Are they different?"),
        ("Has the direction changed from the first to the second?", "Are they different?"),
        ("Did it reverse?", "Are they opposite?"),
        ("By how much do they differ?", "How far did each one go?"),
        ("Is it back where it was?", "Does the second undo the first?"),
        ("Did it go back to where it started?", "Does the second undo the first?"),
        ("Is it back?", "Does the second undo the first?"),
        ("More than before?", "Does the second go further than the first?"),
        ("Did it slip less than last time?", "Does the second slide less than the first?"),
        (
            "Is it turning faster than the one before?",
            "Does the second turn faster than the first?",
        ),
        ("Is this one slower?", "Does the second go slower than the first?"),
        ("What about the previous one?", "And the first one?"),
        ("Before?", None),
        ("Is it more than 5 degrees?", None),
        ("Is it faster?", None),
        ("Did the first change direction?", None),
        ("Does it change from left to right?", None),
        ("How do they differ?", None),
        ("Which way back?", None),
    ],
)
def test_what_changed_between_clips_is_asked_in_words_for_two(text, known):
    assert of_two_in_known_words(text) == known
