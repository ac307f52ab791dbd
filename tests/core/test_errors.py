"""An error a user can repair stays one printable line, whatever a file's name or content holds."""

from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.core.errors import LONGEST_MESSAGE, GeoTLMError


def test_a_sentence_stays_as_it_is():
    sentence = "a clip.npy: 1 frame was found, expected 2 \u2013 record it again, 3 × 4 ä."
    assert str(GeoTLMError(sentence)) == sentence


def test_line_breaks_and_control_characters_become_blanks():
    assert str(GeoTLMError("a\nb\x00c\x1b[31md\u202ee")) == "a b c [31md e"


def test_what_to_do_is_still_said_at_the_end_of_a_long_one():
    said = str(GeoTLMError(f"columns {'x' * 5000}; give another."))
    assert len(said) < LONGEST_MESSAGE
    assert said.startswith("columns x")
    assert said.endswith("x; give another.")


@given(st.text(st.characters(), max_size=6000))
@settings(derandomize=True, max_examples=200, deadline=None)
def test_any_text_becomes_one_line_that_can_be_written(text):
    said = str(GeoTLMError(text))
    assert said.isprintable()
    assert len(said) <= LONGEST_MESSAGE
    assert said.encode().decode() == said
