"""What is asked and never told is declined, and the place of the contact understood."""

import numpy as np
import pytest

from geotlm_lm.conversation.untold import asks_place, never_told, untold
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("When does it start to move?", "watch"),
        ("At what frame does the rotation begin?", "watch"),
        ("how deep is the indentation?", "depth"),
        ("In which direction is the force?", "force"),
        ("Is the rotation about the z axis positive?", "axis"),
        ("Does it turn about the x axis?", "axis"),
        ("What is its y-axis?", "axis"),
        ("help", "Ask how"),
        ("thanks!", "Ask how"),
        ("What can you do?", "Ask how"),
        ("?", "Ask how"),
        ("yes or no?", "Ask how"),
        ("And now?", "Ask how"),
        ("And the object?", "Ask how"),
    ],
)
def test_what_is_never_told_is_declined_with_what_is(text, word):
    assert word in untold(text)


@pytest.mark.parametrize(
    "text",
    ["Which way?", "When did it start to turn left?", "Does it help to turn it?", "stop it?"]
    + [
        "When touched, which way does it move?",
        "Is pressure increasing?",
        "Does it slide along the x axis?",
        "Is it moving in the y-axis?",
        "Did it go along the y axis?",
        "Under pressure, where?",
        "Did the pressure knob turn?",
    ],
)
def test_other_questions_are_left_to_the_model(text):
    assert untold(text) is None


@pytest.mark.parametrize(
    ("text", "asks"),
    [
        ("Where is the contact?", True),
        ("is the contact at the top or the bottom?", True),
        ("where does the cap touch?", True),
        ("where is it going?", False),
        ("where is the object moving?", False),
        ("which way does the contact point move?", False),
        ("is the contact at rest?", False),
        ("is the contact on the move?", False),
        ("is the contact area getting larger?", False),
        ("is there contact?", False),
        ("Is it touching on the left side?", True),
        ("Where in the picture is the object touching?", True),
        ("which part of the gel is touched?", True),
        ("How much of the gel is touched?", True),
        ("size of the contact?", True),
        ("How much is it out of contact?", False),
        ("how big is the turn after contact?", False),
        ("Is the contact only in the left half?", True),
        ("Is the touch mostly at the top?", True),
        ("Which half is touched?", True),
        ("What part was being touched?", True),
        ("Which half of the gel is touched?", True),
        ("How large is the imprint?", True),
        ("How big is the contact?", True),
        ("Which half moves?", False),
        ("Which half is it touching as it slides?", False),
        ("What fraction of the image is in contact?", True),
        ("which percentage of the gel is touched?", True),
        ("How large is the contact?", True),
        ("how big a part of the sensor has contact?", True),
        ("And where?", True),
        ("and where does it go?", False),
        ("is the contact getting smaller?", False),
        ("What part of the motion is a turn?", False),
    ],
)
def test_who_asks_for_the_place_of_the_contact_is_understood(text, asks):
    assert asks_place(text) is asks


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("Is it speeding up?", "mean speed"),
        ("Does it turn faster at the end?", "mean speed"),
        ("is the speed constant?", "mean speed"),
        ("Should I close the gripper more?", "what to do"),
        ("Is it safe to lift?", "what to do"),
        ("Do I need to grip harder?", "what to do"),
        ("Is the contact growing?", "how firm"),
        ("Is the touch gentle?", "how firm"),
        ("is it moving diagonally?", "nearest"),
        ("How much force is applied?", "force"),
        ("How much pressure is there?", "force"),
        ("How much torque does it take?", "force"),
        ("How many newtons?", "force"),
        ("How large is the shear force?", "force"),
        ("How big is the screw?", "size"),
        ("What is the size of the object?", "size"),
        ("How wide is my bottle cap?", "size"),
        ("the diameter of the nut?", "size"),
        ("Is the grip tight?", "how firm"),
        ("How tight is it?", "how firm"),
        ("How strongly is it pressed?", "force"),
        ("Is the connector loose?", "how firm"),
        ("Did the part flip?", "flips over"),
        ("Was the box flipped?", "flips over"),
        ("Has the pancake flipped over?", "flips over"),
        ("Has it turned too far?", "by a number"),
        ("Is it fast enough?", "by a number"),
        ("Is that a lot?", "by a number"),
        ("Top speed?", "one mean speed"),
        ("acceleration?", "one mean speed"),
        ("speed at the end?", "one mean speed"),
        ("Is there incipient slip?", "as a whole"),
        ("micro-slip?", "as a whole"),
        ("Is it moving proximally or distally?", "no way towards"),
        ("Is it rolling?", "rolls"),
        ("Does the ball roll?", "rolls"),
        ("Is the bottle cap tilting?", "tips"),
        ("did it shake at all", "shakes"),
        ("Was it bent?", "bends"),
        ("Is it bending?", "bends"),
        ("In the last 0.5 seconds how far did it slide?", "as a whole"),
        ("Which way does it go in the first half?", "as a whole"),
        ("How far over the final 2 frames?", "as a whole"),
        ("Which one presses harder?", "force"),
        ("Is it pushing deeper?", "force"),
        ("Does it go west?", "towards a thing"),
        ("Does it move toward the fingertip?", "towards a thing"),
        ("Is it sliding to the cable?", "towards a thing"),
        ("did it drift away from my thumb?", "towards a thing"),
        ("slower than a second hand of a clock?", "by a number"),
        ("Does it slide further than a coin is wide?", "by a number"),
        ("Is the volume knob being turned up?", "what that sets"),
        ("am I turning the heat down?", "what that sets"),
        ("Does it turn back?", "one motion per clip"),
        ("Does it turn back at the end?", "one motion per clip"),
        ("Which way does it turn at the end of the clip?", "one motion per clip"),
        ("Did the cap change direction?", "one motion per clip"),
        ("is it going back and forth?", "one motion per clip"),
        ("Give the width of the cable in mm", "not its size"),
        ("How wide is the cable in millimetres?", "not its size"),
    ],
)
def test_what_passes_for_another_question_is_declined(text, word):
    assert word in never_told(text)


@pytest.mark.parametrize(
    "text",
    [
        "Should I turn it clockwise to get it back?",
        "Do I feel contact?",
        "Which way does it go in the first clip?",
        "Is it pressing in?",
        "Which way from the first to the last frame?",
        "How fast does it turn?",
        "Is the contact at rest?",
        "Which way should I turn it to tighten it?",
        "Is it touching?",
        "Does it go faster than 10 px/s?",
        "Do I tighten it?",
        "Do I slide it left?",
        "Do we know which way it goes?",
        "Should I expect a slide to the right?",
        "Is it safe to say that it slides right?",
        "Is it ok to ask how far it went?",
        "Is the contact lightly sliding to the left?",
        "Did the contact spread to the left?",
        "Is the contact good enough to tell which way it goes?",
        "The video is slowed down. Which way does it move?",
        "Which way does it go, faster at the end?",
        "Does it slide diagonally or to the right?",
        "Under a steady force, how far did it slide?",
        "Which pressure point moves left?",
        "How big is the turn?",
        "How large is the displacement of the nut?",
        "What is the size of the slide?",
        "How large is the contact?",
        "How big is it?",
        "How large are the frames?",
        "How big is the clip?",
        "Is the loose cap turning?",
        "Was the image flipped?",
        "Is the ball rolling left?",
        "Which way does it roll?",
        "Is it flipped?",
        "Did the clip flip?",
        "And flipped?",
        "Does it move to the left side?",
        "Is it moving relative to the sensor?",
        "Does it move away from the gel?",
        "Is it moving towards the sensor?",
        "Did it come to a stop?",
        "Is the first one faster than the second?",
        "Is it faster than 10 degrees per second?",
        "Does it turn to the right?",
        "To go back to the start, which way?",
        "Is the knob being turned clockwise?",
        "Is it turning upside down?",
        "How far did it move compared to the first frame?",
        "Did it turn due to a slip?",
        "Does it rotate similar to a clock hand?",
        "How many degrees did it turn up to the end?",
        "Does it move back to the left?",
    ],
)
def test_what_can_be_told_is_not_declined(text):
    assert never_told(text) is None


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_no_question_of_the_templates_is_never_told(wordings):
    rng = np.random.default_rng(5)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=8):
            assert never_told(asked.question) is None or asked.type_id == "T17", asked


@pytest.mark.parametrize(
    "question", ["Can I lift it safely?", "should I tighten my grip?", "What should I do?"]
)
def test_what_to_do_about_it_is_not_told(question):
    assert never_told(question).endswith("not what to do about it.")


def test_what_somebody_can_tell_is_no_advice():
    assert never_told("What should I do to undo it?") is None


@pytest.mark.parametrize(
    "question",
    [
        "Can I push it down to undo the motion?",
        "Can we increase confidence?",
        "Can I close the cap by turning it clockwise?",
        "Can I reduce that to left or right?",
        "Should I push right to undo it?",
    ],
)
def test_what_undoes_a_motion_or_is_asked_of_the_answer_is_no_advice(question):
    assert never_told(question) is None


def test_what_to_do_is_still_declined():
    assert "what to do" in never_told("Can I squeeze it now?")
