import pytest

from geotlm_lm.query.lexicon import LEAST, Lexicon

KNOWN = Lexicon(("the", "which", "turn", "left", "sliding", "before", "release", "radio", "check"))


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("teh", "the"),
        ("befroe relase", "before release"),
        ("Whcih, slidng?", "which, sliding?"),
        ("20 turn/s", "20 turn/s"),
        ("ratio heck lft", "ratio heck lft"),  # other words, or too short to tell
        ("über tunr", "über turn"),
    ],
)
def test_swapped_and_lost_letters_are_mended_and_other_words_stay(written, meant):
    assert KNOWN.mended(written) == meant


def test_the_more_frequent_word_is_meant():
    assert Lexicon(("form", "from")).mended("fomr frmo") == "form from"


def test_it_holds_the_words_that_stand_often_in_its_texts():
    texts = ["Which way?"] * LEAST + ["rarely"] * (LEAST - 1) + ["WAY way"]
    assert Lexicon.of(texts).words == ("way", "which")
