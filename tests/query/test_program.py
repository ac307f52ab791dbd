"""A program and its line of words are the same thing; every beginning knows what may follow."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.query import lines
from geotlm_lm.query import program as p
from geotlm_lm.query.lines import END, Malformed
from geotlm_lm.query.program import Slot
from geotlm_lm.query.quantities import Quantity
from tests.query.programs import expressions

LINES = (
    "cw",
    "within final #1 contact > speed turn #2",
    "choose @1 > amount turn #1 | @2 other",
    "fact mirrored ; fact scale #1 ; mirror way all ; unit mm amount slide ; as json",
    "record @1 amount turn , @2 within part 2 2 contact happens slip-events end ; as csv",
    "count such > amount turn #1 reverse-events",
    "record choose A ccw | B cw , record turn , slide end , each turn-events way turn end",
    "/ of-first amount turn of-second amount turn",
    "not and cw or left touch",
    "at later begin contact #1 turn",
)


@pytest.mark.parametrize("line", LINES)
def test_a_line_is_read_and_written_as_it_stands(line):
    assert lines.write(lines.read(line)) == line


@given(expressions())
@settings(max_examples=150, deadline=None)
def test_a_program_read_back_from_its_words_is_itself(expression):
    line = lines.written(expression)
    assert lines.read(line, slots=0).answers == (expression,)


@given(expressions())
@settings(max_examples=40, deadline=None)
def test_every_word_of_a_program_is_among_those_that_may_follow(expression):
    words = lines.written(expression).split()
    assert {word for word in words if ":" not in word} <= set(lines.PROGRAM_WORDS)
    for place, word in enumerate(words):
        if ":" not in word:
            assert word in lines.begun(words[:place], 0)[0]
    assert END in lines.begun(words, 0)[0]


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_what_may_follow_is_well_formed_to_the_end(data):
    words, length = [], 12
    while END not in (allowed := lines.begun(words, 2, 1)[0]) or len(words) < length:
        offered = sorted(allowed - {END})
        if not offered or len(words) > 60:
            return
        words.append(data.draw(st.sampled_from(offered)))
        if len(words) > length and END in lines.begun(words, 2, 1)[0]:
            break
    assert lines.write(lines.read(" ".join(words))) == " ".join(words)


def test_numbers_and_words_of_the_question_fill_their_slots():
    program = lines.read("record @1 > amount turn #2 , @2 amount slide end")
    filled = p.filled(program, (Quantity(1.0), Quantity(30.0, "deg")), ("angle", "far"))
    first, second = filled.answers[0].arguments[0]
    assert (first.key, second.key) == ("angle", "far")
    assert first.answer.arguments[1].value == Quantity(30.0, "deg")
    assert program.answers[0].arguments[0][0].answer.arguments[1].value == Slot(2)


@pytest.mark.parametrize("line", ["", "turn turn", "> amount turn", "way of", "within turn cw"])
def test_what_is_no_program_names_the_words_that_could_stand_there(line):
    with pytest.raises(Malformed, match="expected one of"):
        lines.read(line)


def test_no_word_gives_two_types_where_any_may_stand():
    words = [word for name in p._ANSWERS for word in p._PLAIN[name]]
    assert len(words) == len(set(words))
    assert not set(words) & set(p._WRAPPERS)


@pytest.mark.parametrize(("line", "normal"), [
    ("mirror mirror cw", "cw"),
    ("mirror half way all", "flip way all"),
    ("record mirror mirror turn , undo turn end", "record turn , undo turn end"),
    ("record unit deg net cw , unit rad net cw end", "record net cw , unit rad net cw end"),
    ("unit deg within contact peak turn", "within contact peak turn"),
    ("unit deg speed turn", "unit deg speed turn"),
    ("unit mm per per-s speed slide", "per per-s unit mm speed slide"),
    ("unit turn per per-min speed turn", "per per-min unit turn speed turn"),
])  # fmt: skip
def test_what_means_the_same_is_written_alike(line, normal):
    assert lines.write(lines.normal(lines.read(line))) == normal
