"""Other words for the same: numbers stay, and no word of a query's contrast stands for another."""

import random
from itertools import combinations, islice

from geotlm_lm.query.quantities import find
from geotlm_lm.training.grammar import Pair, grammar
from geotlm_lm.training.thesaurus import Thesaurus, thesaurus

PAIR = Pair("Show a cap: an angle of 12 degrees?", "~ amount turn #1", ("test/turn",))
CONTRASTS = (
    ("clockwise", "counterclockwise"),
    ("left", "right", "up", "down"),
    ("rotate", "slide", "press", "touch"),
    ("before", "after"),
    ("start", "stop"),
    ("first", "second"),
    ("more", "less"),
    ("further", "faster"),
    ("mirrored", "upside down"),
)


def test_words_are_exchanged_with_their_article_and_capital():
    known = Thesaurus([[["show"], ["tell"]], [["cap"], ["oval lid"]], [["angle"], ["big angle"]]])
    told = known.varied(random.Random(0), PAIR, share=1.0)
    assert told.text == "Tell an oval lid: a big angle of 12 degrees?"
    assert (told.query, told.families) == (PAIR.query, PAIR.families)
    assert known.varied(random.Random(0), PAIR, share=0.0) == PAIR


def test_no_number_changes():
    known = Thesaurus([[["cap"], ["turn"]]])
    assert known.varied(random.Random(0), PAIR, share=1.0) == PAIR
    rng = random.Random(3)
    for pair in islice(grammar().pairs(3, "train"), 300):
        told = thesaurus().varied(rng, pair, share=1.0)
        numbers = [[one.quantity for one in find(text)] for text in (pair.text, told.text)]
        assert numbers[0] == numbers[1]


def test_words_that_ask_different_things_never_stand_for_each_other():
    for words in CONTRASTS:
        for one, other in combinations(words, 2):
            assert other not in thesaurus().others(one), (one, other)
