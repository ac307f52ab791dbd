import pytest

from geotlm_lm.query.copied import copied
from geotlm_lm.query.quantities import Quantity, quantities
from geotlm_lm.query.reader import Lexicon
from geotlm_lm.training.language import FREQUENT, LEAST, SLIPS, lexicon_of

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
    found = lexicon_of([*texts, *["trial"] * FREQUENT])
    assert found.words == ("way", "which", "trial", "rarely", "trail")
    assert found.words[: found.frequent] == ("way", "which", "trial")


@pytest.mark.parametrize(("text", "numbers"), [
    ("more than thirty", [(30.0, "")]),
    ("one point five seconds", [(1.5, "s")]),
    ("it needs one point five", [(1.5, "")]),
    ("eight tenths of a second", [(0.8, "s")]),
    ("in half of the turn", []),
    ("half a turn", [(0.5, "turn")]),
    ("a second time", []),
    ("the third turn, for one of us", []),
    ("a third of a turn", [(1 / 3, "turn")]),
    ("within a second", [(1.0, "s")]),
    ("from f30 to the 60th frame", [(30.0, "frame"), (60.0, "frame")]),
    ("1/0", [(1.0, ""), (0.0, "")]),
    ("0/1", [(0.0, ""), (1.0, "")]),
    ("2 gradians, 3 mrad, 40 \u03bcs", [(2.0, "gon"), (3.0, "mrad"), (40.0, "us")]),
])  # fmt: skip
def test_numbers_of_a_text(text, numbers):
    assert quantities(text) == tuple(Quantity(*each) for each in numbers)


@pytest.mark.parametrize(("text", "words"), [
    ("print STOP or GO", ["STOP", "GO"]),
    ("Say stop or go", ["stop", "go"]),
    ("Redo if it slips, else next", ["Redo", "next"]),
    ("keys angle, t_end and way", ["angle", "t_end", "way"]),
    ("long if over 2 s, short otherwise", ["long", "short"]),
    ("pass / fail", ["pass", "fail"]),
    ("deg/s", []),
    ("L, R or U?", ["L", "R", "U"]),
    ("A) left B) right", []),
    ("say which way it goes", []),
    ("answer in degrees, otherwise say GO", ["GO"]),
    ('{"cw_deg": 1}', ["cw_deg"]),
    ('{"way": "<cw|ccw|none>", "deg": <float>, "on": true|false}',
     ["way", "cw", "ccw", "none", "deg", "on"]),
    ("YAML with keys way and angle", ["way", "angle"]),
    ("CSV with header please: touch;angle;far", ["touch", "angle", "far"]),
    ("one CSV line: turn_way,turn_deg,held", ["turn_way", "turn_deg", "held"]),
    ("touch\tangle", ["touch", "angle"]),
    ("columns a, b and c", ["a", "b", "c"]),
    ("label with one of: twist, off_axis, rest.", ["twist", "off_axis", "rest"]),
    ("one of: turning left, turning right or no motion?",
     ["turning left", "turning right", "no motion"]),
    ("a digit: 0 = rest, 1 = turn, 2 = slide", []),
    ("a dict with 'cw' (bool) and 'deg' (float)", ["cw", "deg"]),
    ("<way>cw</way> or <way>ccw</way>", ["way", "cw", "ccw"]),
    ("fill linear.x and angular.z", ["linear.x", "angular.z"]),
    ("turnAngle: <float>\ndir: <left|right>", ["turnAngle", "dir", "left", "right"]),
    ('"deg": "float", "way": "string"', ["deg", "way"]),
    ('fill "It turned ___ degrees in all, and slid ___ px." and say "done"', ["done"]),
    ("STOP if it slips, STOP if it turns, else GO", ["STOP", "GO"]),
    ("WHICH WAY DOES IT TURN, AND HOW FAR?", []),
    ("degrees/second, and/or", []),
    ("fill in: keys way and deg", ["way", "deg"]),
    ("IN or OUT?", ["IN", "OUT"]),
    ("PASS if |x-3| <= 1, else FAIL", ["PASS", "FAIL"]),
    ("which one of the two?", []),
    ('The gel is 2" wide. Print "ok" if it slips, else "bad".', ["ok", "bad"]),
    ("Does the screw key turn?", []),
    ("When does the key, seen from behind, turn?", []),
    ("json, key theta", ["theta"]),
    ("one field, with key angle", ["angle"]),
])  # fmt: skip
def test_words_that_may_be_copied(text, words):
    assert [each.text for each in copied(text)] == words
