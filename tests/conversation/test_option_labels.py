"""Letters and numbers of a choice, before or behind the words of their options."""

import pytest

from geotlm_lm.conversation.claims import offered_options
from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.option_labels import labelled, without_tail
from geotlm_lm.core.labels import Motion

CW, CCW, LEFT, RIGHT, UP, DOWN = (
    Motion.CLOCKWISE,
    Motion.COUNTERCLOCKWISE,
    Motion.LEFT,
    Motion.RIGHT,
    Motion.UP,
    Motion.DOWN,
)


@pytest.mark.parametrize(
    ("question", "offered"),
    [
        ("Choose: (a) clockwise (b) counterclockwise (c) not rotating", {"A": CW, "B": CCW}),
        ("(A) clockwise (B) counterclockwise (C) no rotation", {"A": CW, "B": CCW}),
        ("(a) left (b) right (c) jiggling", {"A": LEFT, "B": RIGHT}),
        ("clockwise (A) or left (B)?", {"A": CW, "B": LEFT}),
        ("up (1), down (2)?", {"1": UP, "2": DOWN}),
        ("Options: 1. it moves left; 2. it moves right.", {"1": LEFT, "2": RIGHT}),
        ("1=left 2=right 3=up. Which number?", {"1": LEFT, "2": RIGHT, "3": UP}),
        ("A=cw, B=ccw", {"A": CW, "B": CCW}),
        ("1: up 2: down", {"1": UP, "2": DOWN}),
    ],
)
def test_labels_are_read_on_the_side_where_more_options_say_something(question, offered):
    assert offered_options(question) == offered


@pytest.mark.parametrize(
    "question",
    [
        "It moved at 2. Did it go left?",
        "At frame 1. Which way?",
        "It took 1.5 s, left or right?",
        "From 3: left or 5: right?",
        "Which way does it move?",
    ],
)
def test_numbers_that_count_nothing_up_label_no_options(question):
    assert offered_options(question) == {}


def test_what_is_asked_behind_the_last_option_is_none_of_its_words():
    found = labelled("A) UP B) IT DOES NOT MOVE. WHICH LETTER?", lambda one: bool(one))
    assert [without_tail(option) for _, option in found] == ["UP", "IT DOES NOT MOVE"]


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("left, right or neither?", {LEFT, RIGHT}),
        ("left, right, up or down?", {LEFT, RIGHT, UP, DOWN}),
        ("it slides left, right?", {LEFT}),
        ("it goes up, right? thanks", {UP}),
    ],
)
def test_right_is_a_way_in_a_list_and_a_tag_at_the_end(text, named):
    assert motions_named(text) == named


def test_labels_behind_their_options_go_as_far_as_those_before():
    text = "LEFT (A), RIGHT (B), UP (C), DOWN (D), CLOCKWISE (E), COUNTERCLOCKWISE (F)?"
    assert [label for label, _ in labelled(text, lambda words: "WISE" in words)] == list("ABCDEF")


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("ANSWER A FOR LEFT AND B FOR RIGHT.", [("A", "LEFT"), ("B", "RIGHT")]),
        ("SAY 0 IF LEFT, 1 IF RIGHT", [("0", "LEFT"), ("1", "RIGHT")]),
        ("IF IT MOVES LEFT SAY A, IF RIGHT SAY B.", [("A", "IT MOVES LEFT"), ("B", "RIGHT")]),
        ("A MEANS LEFT, B MEANS RIGHT", [("A", "LEFT"), ("B", "RIGHT")]),
    ],
)
def test_labels_may_stand_for_their_options_in_words(text, found):
    assert labelled(text, lambda option: "LEFT" in option or "RIGHT" in option) == found
