"""Whether it turns, slides, moves, presses or lifts, in any tense and mood, and nothing more."""

import numpy as np
import pytest

from geotlm_lm.conversation.bare_motions import asked_of_a_motion
from geotlm_lm.conversation.motion_verbs import LIFTS, MOVES, NEARS, SLIDES, TURNS
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for

ASKED = {
    "Is it turning?": TURNS,
    "Is it sliding?": [verb for verb in SLIDES if verb[0] != "slip"],
    "Is it slipping?": [verb for verb in SLIDES if verb[0] == "slip"],
    "Is it moving at all?": MOVES,
    "Is it pressing in?": NEARS,
    "Is it lifting off?": LIFTS,
}
WAYS = (
    "Is it {gerund}?",
    "Was the bottle cap {gerund}?",
    "Did it {base}?",
    "Does the object {base} at all?",
    "Has it {past}?",
    "Hasn't the lid {past} yet?",
    "Has it been {gerund}?",
    "Is it being {past}?",
    "It's {gerund}?",
    "It {past}?",
    "it {past}, didn't it?",
    "The nut {third}.",
    "It has {past}, right?",
    "Any {gerund}?",
    "{gerund}?",
    "Did it start {gerund}?",
    "Has it begun to {base}?",
    "Does it seem to {base}?",
    "Can you feel it {gerund}?",
    "Would you say it is {gerund}?",
    "Check whether it {third}",
    "{gerund} yes or no",
)


@pytest.mark.parametrize("asked", ASKED)
@pytest.mark.parametrize("way", WAYS)
def test_every_tense_and_mood_asks_for_the_same(asked, way):
    for base, third, past, gerund in ASKED[asked]:
        question = way.format(base=base, third=third, past=past, gerund=gerund)
        assert asked_of_a_motion(question) == asked


@pytest.mark.parametrize(
    "question",
    [
        "Has it turned clockwise?",
        "Has it turned 10 degrees?",
        "Has the gripper turned?",
        "Has the sensor slipped?",
        "Has the image turned?",
        "Did the motion stop turning?",
        "The object moved, not the sensor.",
        "It went left?",
        "Is it sliding right?",
        "is it turning right",
        "Is it not turning?",
        "Isn't it turning?",
        "is this turning or sliding?",
        "Was the cap not slipping?",
        "does that seem like a press?",
        "Which way is it turning?",
        "Is only the rim turning?",
        "It moved. Which way?",
        "Heading now?",
        "has it turned and slid?",
        "Tell me the direction it turned",
        "Tell me the way it is moving",
        "Can you tell me the distance it moved?",
        "the rate it turns",
        "Tell me the probability that it slipped",
        "the evidence that it slipped",
        "the cap never turned",
        "Did the object never move?",
        "check that nothing slipped",
        "Did the object cease to turn?",
        "Is the cap counterclockwise turning?",
        "Was the object left sliding?",
        "Did the bead upwards slide?",
        "Did the cap ten degrees turn?",
        "My colleague says it turned",
        "The log denies it turned",
        "Did the top half move?",
        "Has the first one turned?",
        "Did the axis of rotation move?",
        "Did the temperature drift?",
        "Did the force cause it slip?",
        "Is the cap likely turning?",
        "Has it turned too far?",
        "Did it turn that much?",
    ],
)
def test_more_than_a_motion_stays_as_it_is(question):
    assert asked_of_a_motion(question) is None


@pytest.mark.parametrize(
    ("question", "asked"),
    [
        ("Has it turned a lot?", "How far did it turn?"),
        ("Did the cap turn much?", "How far did it turn?"),
        ("did it slip very far?", "How far did it slide?"),
        ("Has it moved by much?", "How far did it go?"),
        ("Has it turned at least a bit?", "Is it turning?"),
        ("Has it turned so far?", "Is it turning?"),
        ("Has the red bottle cap turned?", "Is it turning?"),
        ("I think that the hex nut slipped", "Is it slipping?"),
        ("I'd say it slipped", "Is it slipping?"),
        ("The cable may have slipped", "Is it slipping?"),
        ("the cap must be turning", "Is it turning?"),
        ("the cable is twisted", "Is it turning?"),
        ("Does the row of buttons slide?", "Is it sliding?"),
        ("Does the tip slide a bit?", "Is it sliding?"),
        ("is the part being dragged?", "Is it sliding?"),
        ("The cap's turning?", "Is it turning?"),
    ],
)
def test_whether_it_goes_far_asks_how_far(question, asked):
    assert asked_of_a_motion(question) == asked


@pytest.mark.parametrize("question", ["Has it turned or slid?", "has the cap slipped or rotated?"])
def test_one_kind_or_the_other_is_a_choice(question):
    assert asked_of_a_motion(question) == "Is it sliding or turning?"


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
def test_of_the_templates_only_bare_motions_are_read_so(wordings):
    rng = np.random.default_rng(3)
    for motion in Motion:
        label = MotionLabel(motion, rotation_deg=12.0 if motion in ROTATIONS else 0.0)
        for asked in questions_for(label, rng, wordings=wordings, per_type=20):
            read = asked_of_a_motion(asked.question)
            if asked.type_id == "T16":
                assert read in (None, "Is it moving at all?")
            elif asked.type_id == "T2":
                assert read in (None, *ASKED)
            else:
                assert read is None, asked.question
