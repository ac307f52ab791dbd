"""Directions told by a clock."""

import numpy as np
import pytest

from geotlm_lm.conversation.clock_words import without_clocks
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("Does it go against the clock?", "Does it go counterclockwise?"),
        ("counter to the hands of a clock", "counterclockwise"),
        ("anticlock?", "counterclockwise?"),
        ("cw or anti-cw", "cw or counterclockwise"),
        ("Like a clock?", "clockwise?"),
        ("Is it going the way of the clock hands?", "Is it going clockwise?"),
        ("the way a clock goes?", "clockwise?"),
        ("Does the motion follow the clock?", "Does the motion go clockwise?"),
        ("Does it slide towards 3 o'clock?", "Does it slide right?"),
        ("12 oclock?", "up?"),
        ("at nine o'clock", "left"),
        ("anticlockwise?", "anticlockwise?"),
        ("anti-clockwise", "anti-clockwise"),
        ("Is it a clock?", "Is it a clock?"),
        ("Is the clock hand turning?", "Is the clock hand turning?"),
        ("towards 2 o'clock", "towards 2 o'clock"),
        ("Is the contact at the 3 o'clock position?", "Is the contact right?"),
        ("unlike a clock?", "counterclockwise?"),
        ("At 9 o'clock, is it turning?", "At 9 o'clock, is it turning?"),
        ("Did the clip start at 9 o'clock?", "Did the clip start at 9 o'clock?"),
        ("from 12 o'clock to 3 o'clock?", "from 12 o'clock to 3 o'clock?"),
    ],
)
def test_a_clock_tells_a_direction(text, told):
    assert without_clocks(text) == told


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_template_changes(wordings):
    rng = np.random.default_rng(3)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=20):
            assert without_clocks(asked.question) == asked.question
