"""Kinds of motion claimed without a direction, and words that may be mistyped ones."""

import pytest

from geotlm_lm.conversation.claims import (
    asks_both_kinds,
    claimed,
    claimed_class,
    claims_motion,
    presumed_class,
    without_adverbs,
)
from geotlm_lm.conversation.kinds import asked_kind
from geotlm_lm.conversation.motion_names import claimed_motion, motions_named, nearly_named
from geotlm_lm.core.labels import Motion, MotionClass, MotionLabel
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.data.questions import questions_for


@pytest.mark.parametrize(
    ("question", "claimed"),
    [
        ("Is it rotating?", MotionClass.ROTATION),
        ("hey, did the cap twist", MotionClass.ROTATION),
        ("Is the cable slipping through my fingers?", MotionClass.SLIDE),
        ("If I looked at it, would it be spinning?", MotionClass.ROTATION),
        ("isn't it dragged along?", MotionClass.SLIDE),
        ("rotation sense pls", None),
        ("Which way is it turning?", None),
        ("Is it turning clockwise?", None),
        ("Is it turning or sliding?", None),
        ("Can you tell how it turns?", None),
        ("Is it moving?", None),
    ],
)
def test_a_yes_or_no_question_may_claim_a_kind_of_motion(question, claimed):
    assert claimed_class(question) == claimed


@pytest.mark.parametrize("word", ["clokwise", "lefft", "presing", "cuonterclockwise"])
def test_a_mistyped_motion_is_nearly_named(word):
    assert nearly_named(f"is it going {word}?")


@pytest.mark.parametrize("text", ["what is that light?", "is it slipping?", "shifting sands", ""])
def test_other_words_are_no_mistyped_motions(text):
    assert not nearly_named(text)


@pytest.mark.parametrize("text", ["Is the right cap turning?", "is my left thumb slipping"])
def test_a_thing_by_its_place_is_no_mistyped_motion(text):
    assert not nearly_named(text)


def test_upside_down_names_no_motion_and_resting_is_still():
    assert motions_named("if the picture is upside down?") == set()
    assert motions_named("is the coin just resting there?") == {Motion.STILL}


@pytest.mark.parametrize(
    ("question", "claims"),
    [
        ("Is the cable slipping through my fingers?", True),
        ("Does it travel towards the upper edge of the picture?", True),
        ("is it going to the bottom end", True),
        ("Is it still turning?", True),
        ("Did it turn anticlockwise?", True),
        ("Is it moving away from the left border?", False),
        ("Is it just resting there?", True),
        ("Is it the right size?", False),
        ("Is that right?", False),
        ("Is the upper edge sharp?", False),
        ("Will it turn later?", False),
        ("Did it slide before?", False),
        ("Who turned it clockwise?", False),
        ("Is it turning or sliding?", False),
        ("Is it red?", False),
        ("left?", False),
        ("Is it still warm?", False),
        ("Does the button still work?", False),
        ("Is the dragon green?", False),
        ("Is the spine of the book blue?", False),
        ("Is it slippery?", False),
        ("Is the twisted cable red?", False),
        ("Is the spinning top red?", False),
        ("Does the slide rule work?", False),
        ("Is the temperature going up?", False),
        ("Is it going to be all right?", False),
        ("Can it rotate freely?", False),
        ("Is it not slipping?", False),
    ],
)
def test_a_claim_of_motion_is_told_from_other_questions(question, claims):
    assert claims_motion(question) is claims


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
@pytest.mark.parametrize("asked_type", ["T6", "T16", "T17"])
def test_no_question_of_contact_or_beyond_touch_passes_for_a_claim(asked_type, wordings):
    label = MotionLabel(Motion.CLOCKWISE, rotation_deg=12.0)
    rngs = (generator_for(seed, "claims") for seed in range(1500))
    asked = [questions_for(label, rng, types=[asked_type], wordings=wordings)[0] for rng in rngs]
    assert [one.question for one in asked if claims_motion(one.question)] == []


@pytest.mark.parametrize(
    ("question", "kind"),
    [
        ("How far did the top side turn?", "magnitude"),
        ("How fast does the top edge turn?", "rate"),
        ("How long is the top edge?", None),
        ("Is the lower edge not sharp?", None),
    ],
)
def test_an_edge_is_a_motion_only_where_one_goes_to_it(question, kind):
    assert asked_kind(question) == kind


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("Is it still moving?", set()),
        ("Did it come from the left?", set()),
        ("Does it slide left along the bottom edge?", {Motion.LEFT}),
        ("Is it still?", {Motion.STILL}),
        ("Does it go to the lower border?", {Motion.DOWN}),
        ("Is the right cap turning?", set()),
        ("Is the left finger slipping?", set()),
        ("How far did the left cap turn?", set()),
        ("Does my left thumb press?", {Motion.PRESS}),
        ("Is its right jaw moving left?", {Motion.LEFT}),
        ("Does it slide to the right quickly?", {Motion.RIGHT}),
        ("Is it going to the left now?", {Motion.LEFT}),
        ("Did it slide towards the right jaw?", {Motion.RIGHT}),
        ("Is the direction the left or the right?", {Motion.LEFT, Motion.RIGHT}),
        ("Is it the left direction?", {Motion.LEFT}),
        ("Does it go to the right edge?", {Motion.RIGHT}),
        ("Is the part still held?", set()),
        ("Is it still there?", set()),
        ("Is the cap still attached?", set()),
        ("Is the part held still?", {Motion.STILL}),
        ("Was the object picked up?", set()),
        ("Does it end up left?", {Motion.LEFT}),
        ("Is it set up?", set()),
        ("Did it go up?", {Motion.UP}),
    ],
)
def test_where_it_comes_from_is_no_motion(text, named):
    assert motions_named(text) == named


@pytest.mark.parametrize(
    ("question", "presumed"),
    [
        ("Which way is the cap turning?", MotionClass.ROTATION),
        ("cw or ccw?", MotionClass.ROTATION),
        ("how does it twist", MotionClass.ROTATION),
        ("Where is it sliding?", MotionClass.SLIDE),
        ("left or right?", MotionClass.SLIDE),
        ("Which way is it moving?", None),
        ("Does it turn or slide?", None),
        ("Is it pressed or turned?", None),
        ("What is it pressing on?", None),
        ("which way does the screw turn", MotionClass.ROTATION),
        ("Tell me which way the lid is twisting.", MotionClass.ROTATION),
        ("direction of rotation?", MotionClass.ROTATION),
        ("Which way is the cable slipping?", MotionClass.SLIDE),
        ("Which way is the turntable moving?", None),
        ("It's my turn: which way did it go?", None),
        ("I turned my head. Which way does it move?", None),
        ("turns out it moves, which way?", None),
        ("If it isn't turning, which way does it move?", None),
        ("It no longer turns; what does it do instead?", None),
        ("which way is the slide rule going", None),
        ("Where does the slippery cap go?", None),
        ("What is the dragon doing?", None),
        ("Which way is the right cap moving?", None),
        ("what's left?", None),
        ("What should I press?", None),
    ],
)
def test_the_kind_of_motion_a_question_takes_for_granted(question, presumed):
    assert presumed_class(question) == presumed


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("Is the left finger's sensor recording?", set()),
        ("the right gripper turns", set()),
        ("Did the left jaw see it go right?", {Motion.RIGHT}),
        ("is the finger going left", {Motion.LEFT}),
        ("it turns left, finger first", {Motion.COUNTERCLOCKWISE}),
        ("does it turn at least 10 degrees to the right?", {Motion.CLOCKWISE}),
        ("turned ten degrees left", {Motion.COUNTERCLOCKWISE}),
        ("turned by a quarter of a turn to the right", {Motion.CLOCKWISE}),
        ("does it turn or slide right?", {Motion.RIGHT}),
    ],
)
def test_which_finger_it_is_is_no_motion(text, named):
    assert motions_named(text) == named


@pytest.mark.parametrize(
    ("text", "motions"),
    [
        ("Does it move without slipping?", None),
        ("Is it doing anything but sliding?", None),
        ("Is it sliding toward the top?", {Motion.UP}),
        ("Is it sliding towards the bottom of the image?", {Motion.DOWN}),
    ],
)
def test_what_is_left_out_is_not_claimed_and_edges_are_ways(text, motions):
    assert claimed(text) == motions


@pytest.mark.parametrize(
    ("text", "motion"),
    [
        ("is the coin being pulled away?", Motion.RELEASE),
        ("is it leaving the sensor?", Motion.RELEASE),
        ("does it still touch?", None),
        ("does it still turn?", None),
        ("is it still?", Motion.STILL),
        ("is it detaching?", Motion.RELEASE),
        ("is it receding", Motion.RELEASE),
        ("does it sink in?", Motion.PRESS),
        ("is it approaching?", Motion.PRESS),
        ("is it approaching the gel?", Motion.PRESS),
        ("Is it approaching the left edge?", Motion.LEFT),
        ("looking down at it, is it clockwise?", Motion.CLOCKWISE),
    ],
)
def test_what_leaves_is_lifted_and_what_still_goes_is_not_still(text, motion):
    assert claimed_motion(text) == motion


@pytest.mark.parametrize("text", ["is the coin leaving the gel?", "is it slipping or not?"])
def test_claims_of_leaving_and_those_that_ask_or_not_are_claims(text):
    assert claims_motion(text)


@pytest.mark.parametrize(
    "text",
    [
        "Does it slide as well as rotate?",
        "is it rotation plus translation?",
        "does it turn more than it slides?",
        "both turning and slipping",
    ],
)
def test_a_turn_and_a_slide_at_once_are_asked_for(text):
    assert asks_both_kinds(text)


@pytest.mark.parametrize("text", ["does it turn or slide?", "do both turn?", "is it turning?"])
def test_one_of_two_kinds_is_not_both(text):
    assert not asks_both_kinds(text)


@pytest.mark.parametrize(
    ("text", "motion"),
    [
        ("is it clockwise rather than counterclockwise?", Motion.CLOCKWISE),
        ("does it go up instead of down?", Motion.UP),
    ],
)
def test_what_is_compared_with_is_not_claimed(text, motion):
    assert claimed_motion(text) == motion


@pytest.mark.parametrize(
    "text",
    [
        "Does it rotate without sliding?",
        "Is the motion pure rotation?",
        "did the imprint translate?",
        "is the part being dragged?",
        "is it pivoting?",
    ],
)
def test_these_claim_a_kind(text):
    assert claims_motion(text)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("Which way does the indent move?", set()),
        ("Does the indent move up?", {Motion.UP}),
        ("Does the indent rotate clockwise?", {Motion.CLOCKWISE}),
        ("Was the approach slow?", set()),
        ("Does it indent the gel?", {Motion.PRESS}),
        ("Is the coin approaching?", {Motion.PRESS}),
        ("Is it being pulled back to the left?", {Motion.LEFT}),
        ("Is it pulled back up?", {Motion.UP}),
        ("Is the cable pulled off to the left?", {Motion.LEFT}),
        ("Is the cable pulled off?", {Motion.RELEASE}),
        ("Is it pulled back to the start?", {Motion.RELEASE}),
    ],
)
def test_an_indent_is_a_thing_and_what_is_pulled_to_a_side_slides(text, named):
    assert motions_named(text) == named


def test_what_it_does_still_it_goes_on_doing():
    assert without_adverbs("Does it slide still?") == "Does it slide?"
    assert without_adverbs("Is it still?") == "Is it still?"
