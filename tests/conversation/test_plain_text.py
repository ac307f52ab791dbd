"""What every rule on words reads."""

from functools import partial

import pytest

from geotlm_lm.conversation.bare_amounts import asked_of_an_amount
from geotlm_lm.conversation.bare_motions import asked_of_a_motion
from geotlm_lm.conversation.either_or import without_opposites
from geotlm_lm.conversation.known_words import in_known_words
from geotlm_lm.conversation.motion_names import claimed_motion
from geotlm_lm.conversation.plain_text import plain_text, without_openers
from geotlm_lm.conversation.short_questions import in_full
from geotlm_lm.conversation.signed_axes import asked_of_axes
from geotlm_lm.conversation.thread_words import of_a_thread
from geotlm_lm.conversation.two_clips import of_two_in_known_words


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("Isn\u2019t it  MOVING?", "isn't it moving?"),
        (" Which\tway\n\ndoes it go? ", "which way does it go?"),
        ("", ""),
    ],
)
def test_case_apostrophes_and_spaces_are_told_apart_by_no_rule(text, plain):
    assert plain_text(text) == plain


def test_a_typeset_apostrophe_is_read_like_a_typed_one():
    typed, typeset = ("Doesn't it turn clockwise?", "Doesn\u2019t it turn clockwise?")
    assert claimed_motion(typed) == claimed_motion(typeset)


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        ("So, ok, which way?", "which way?"),
        ("- Hey, please: is it turning?", "is it turning?"),
        ("well and now what?", "what?"),
        ("so far, did it turn?", "so far, did it turn?"),
        ("and so much for the left?", "so much for the left?"),
        ("butter side down?", "butter side down?"),
        ("and now?", "now?"),
        ("", ""),
    ],
)
def test_a_whole_text_is_read_from_its_first_word_that_asks(text, asked):
    assert without_openers(text) == asked


@pytest.mark.parametrize("opener", ["and", "so", "ok", "okay", "now", "but", "hey", "please"])
@pytest.mark.parametrize(
    ("asked", "question"),
    [
        (in_known_words, "did you feel anything?"),
        (asked_of_a_motion, "has it been rotating?"),
        (asked_of_an_amount, "total rotation?"),
        (in_full, "turning or not?"),
        (asked_of_axes, "is dx positive?"),
        (of_two_in_known_words, "did the direction change?"),
        (without_opposites, "is it moving or stationary?"),
        (partial(of_a_thread, is_known=False), "is the screw going in?"),
    ],
)
def test_what_opens_a_text_changes_nothing_of_what_it_asks(opener, asked, question):
    assert asked(question) not in (None, question)
    assert asked(f"{opener.capitalize()}, {question}") == asked(question)
