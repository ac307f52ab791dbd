import pytest

from geotlm_lm.query.lexicon import FREQUENT, LEAST, SLIPS, Lexicon

WORDS = ("the", "which", "turn", "left", "sliding", "before", "release", "radio", "check", "field")
KNOWN = Lexicon(WORDS, frequent=9)


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("teh", "the"),
        ("befroe relase", "before release"),
        ("Whcih, slidng?", "which, sliding?"),
        ("20 turn/s", "20 turn/s"),
        ("ratio heck lft", "ratio heck lft"),  # other words, or too short to tell
        ("über tunr", "über turn"),
        ("filed", "filed"),  # a slip of a rare word is as likely a word of its own
        ("a" * 2000, "a" * 2000),
    ],
)
def test_swapped_and_lost_letters_are_mended_and_other_words_stay(written, meant):
    assert KNOWN.mended(written) == meant


def test_the_more_frequent_word_is_meant():
    assert Lexicon(("form", "from"), 2).mended("fomr frmo") == "form from"


def test_it_holds_the_words_that_stand_often_in_its_texts_and_none_of_their_slips():
    texts = ["Which way?"] * SLIPS * LEAST + ["whcih rarely trail"] * LEAST + ["WAY way", "once"]
    found = Lexicon.of([*texts, *["trial"] * FREQUENT])
    assert found.words == ("way", "which", "trial", "rarely", "trail")
    assert found.words[: found.frequent] == ("way", "which", "trial")
