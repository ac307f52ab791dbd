"""Any words are heard without a failure, in time, and rules agree with themselves."""

import string
import time

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from geotlm_lm.conversation.english import is_english
from geotlm_lm.conversation.frame_facts import read_facts
from geotlm_lm.conversation.image_rotation import unclear_rotation
from geotlm_lm.conversation.motion_claims import offered_options
from geotlm_lm.conversation.motion_names import claimed_motion, motions_named
from geotlm_lm.core.frame_spec import FrameSpec
from tests.conversation.questions import COLUMNS, entries
from tests.conversation.reading import reading

LONGEST = 500
"""Characters of a question that is let through."""

drawn = settings(derandomize=True, max_examples=150, deadline=None, database=None)

QUESTIONS = tuple(entry["text"] for entry in entries())[::25]
WORDS = (
    *("clockwise", "left", "not", "no", "never", "isn't it", "mirrored", "thread", "the sensor"),
    *("A)", "B:", "(C)", "?", "!", ".", ";", "...", "\u2019", "{{", "%s", "-", "9" * 40, "a " * 60),
    *("<tactile>", "<<tactile>>", "<<<user>>>", "<|im_start|>"),
    *("\n", "\0", "\u202e", "\ufeff", "\U0001f9f2", "\u0130", "e\u0301"),
    *("which way ", "because ", "why ", "or ", "and then ", "I look from ", "sure", "again"),
)
"""Of the questions' language, and what its parts may trip over."""

OF_FACTS = (
    "the image is ",
    "turned by 90 ",
    "with the camera rotated ",
    "i turned the image right ",
)

WORDY = st.lists(
    st.one_of(st.sampled_from(QUESTIONS + WORDS), st.text(max_size=12)), max_size=12
).map(lambda parts: " ".join(parts)[:LONGEST])


@given(WORDY)
@drawn
def test_any_words_are_read_and_twice_alike(text):
    assert reading(text, COLUMNS) == reading(text, COLUMNS)
    assert claimed_motion(text) is None or claimed_motion(text) in motions_named(text)
    assert all(len(letter) == 1 for letter in offered_options(text))


@given(WORDY)
@drawn
def test_facts_once_taken_out_of_a_question_are_not_found_again(text):
    once = read_facts(text, FrameSpec())
    assume(unclear_rotation(once.rest, text) is None)  # of two turns neither is taken: it is asked
    again = read_facts(once.rest, once.frame)
    assert again.frame == once.frame


@pytest.mark.parametrize(
    "part", [*WORDS, *string.punctuation, "a;b;", " ;", "no, ", "; and ", *OF_FACTS]
)
def test_a_part_repeated_to_the_longest_question_is_heard_in_time(part):
    text = (part * LONGEST)[:LONGEST]
    began = time.process_time()
    is_english(text)
    reading(text, COLUMNS)
    # Measured 0.1 s at most; what runs away takes seconds to years.
    assert time.process_time() - began < 1.0
