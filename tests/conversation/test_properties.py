"""Any words are heard without a failure, in time, and rules agree with themselves."""

import string
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.conversation.claims import offered_options
from geotlm_lm.conversation.english import is_english
from geotlm_lm.conversation.frame_facts import read_facts
from geotlm_lm.conversation.kinds import asked_kind
from geotlm_lm.conversation.motion_names import claimed_motion, motions_named
from geotlm_lm.conversation.turned_image import unclear_turn
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.fuzzing.questions import QUESTIONS, WORDS

LONGEST = 500
"""Characters of a question that is let through."""

drawn = settings(derandomize=True, max_examples=150, deadline=None)

WORDY = st.lists(
    st.one_of(st.sampled_from(QUESTIONS + WORDS), st.text(max_size=12)), max_size=12
).map(lambda parts: " ".join(parts)[:LONGEST])


@given(WORDY)
@drawn
def test_any_words_are_heard(text):
    is_english(text)
    stated = read_facts(text, FrameSpec())
    asked_kind(stated.rest), unclear_turn(stated.rest)
    assert claimed_motion(text) is None or claimed_motion(text) in motions_named(text)
    assert all(len(letter) == 1 for letter in offered_options(text))


@given(WORDY)
@drawn
def test_facts_once_taken_out_of_a_question_are_not_found_again(text):
    once = read_facts(text, FrameSpec())
    again = read_facts(once.rest, once.frame)
    assert again.frame == once.frame


OF_FACTS = (
    "the image is ",
    "turned by 90 ",
    "with the camera rotated ",
    "i turned the image right ",
)


@pytest.mark.parametrize(
    "part", [*WORDS, *string.punctuation, "a;b;", " ;", "no, ", "; and ", *OF_FACTS]
)
def test_a_part_repeated_to_the_longest_question_is_heard_in_time(part):
    text = (part * LONGEST)[:LONGEST]
    began = time.process_time()
    is_english(text)
    stated = read_facts(text, FrameSpec())
    asked_kind(stated.rest), unclear_turn(stated.rest)
    motions_named(text), claimed_motion(text), offered_options(text)
    # Measured 45 ms at most; what runs away takes seconds to years.
    assert time.process_time() - began < 0.5
