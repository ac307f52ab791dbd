"""Facts that stand in sentences of their own are read there; the question is read without them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.query.facts import with_facts
from geotlm_lm.query.quantities import Quantity, quantities
from geotlm_lm.query.reading import Reading
from geotlm_lm.query.sentences import (
    MOST_SENTENCES,
    chance_lost,
    last_of_each,
    read_alone,
    read_apart,
    sentences,
)
from geotlm_lm.query.text import MOST_SLOTS
from geotlm_lm.query.text import read as read_line

LINES = {
    "It is mirrored.": "fact mirrored",
    "It is not mirrored.": "fact not mirrored",
    "0.05 mm per pixel.": "fact scale #1",
    "30 fps;": "fact rate #1",
    "Forget all I said.": "fact everything",
    "Is it mirrored?": "setup mirrored",
    "Hm, mirrored.": "fact mirrored ; again",
    "More than 2 mm?": "claim slide > #1",
    "Hello.": "talk greeting",
    "Hello. More than 2 mm?": "claim slide > #1",
    "More than 2 mm? Or 3 mm?": "claim slide > #1 ; claim slide > #2",
    "Or 3 mm?": "claim slide > #1",
    "Touching?": "claim touch",
    "Which way?": "way",
    "Touching? Which way?": "way",
    "And backwards?": "backwards > again",
}
UNSURE = "It may be mirrored."


def read(text):
    if text.startswith(UNSURE):
        return [Reading("fact mirrored ; way", (), 0.6, 0.6)]
    return [Reading(LINES[text], quantities(text), 0.95, 0.9)]


def alone(text):
    return read_alone(text, lambda one: read(one)[0])


def apart(text):
    return read_apart(alone(text), read)


def lines(text):
    return [one.line for one in apart(text)]


def test_sentences_end_at_their_marks_and_at_the_end_of_a_line():
    text = " Mirrored. 0.05 mm/px; is it 2.5 mm, or not?\n30 fps\n"
    assert sentences(text) == ["Mirrored.", "0.05 mm/px;", "is it 2.5 mm, or not?", "30 fps"]
    assert sentences("It is 0. 5 mm. Which way?") == ["It is 0. 5 mm.", "Which way?"]


def test_facts_are_put_before_what_asks_wherever_they_stand():
    expected = ["fact mirrored ; fact scale #1 ; claim slide > #2"]
    assert lines("It is mirrored. 0.05 mm per pixel. More than 2 mm?") == expected
    (found,) = apart("More than 2 mm? It is mirrored. 0.05 mm per pixel.")
    assert found.line == "fact mirrored ; fact scale #2 ; claim slide > #1"
    assert found.quantities == (Quantity(2.0, "mm"), Quantity(0.05, "mm/px"))
    assert found.chance == pytest.approx(0.9**3)


def test_what_asks_is_read_together():
    (found,) = apart("More than 2 mm? 30 fps; Or 3 mm?")
    assert found.line == "fact rate #2 ; claim slide > #1 ; claim slide > #3"
    assert lines("Hello. It is mirrored. More than 2 mm?") == ["fact mirrored ; claim slide > #1"]


def test_questions_that_stand_for_themselves_are_read_one_by_one_where_that_is_surer():
    assert lines("Touching? Which way?") == ["claim touch ; way"]
    assert lines("Touching? Which way? Touching?") == ["claim touch ; way"]
    assert lines("Touching? It is mirrored. Which way?") == ["fact mirrored ; way"]
    assert lines("Touching? And backwards?") == []


def test_facts_alone_stay_in_their_order():
    assert lines("It is mirrored. It is not mirrored.") == ["fact mirrored ; fact not mirrored"]
    again = "It is mirrored. It is not mirrored. It is mirrored."
    assert lines(again) == ["fact not mirrored ; fact mirrored"]
    assert lines(f"{again} More than 2 mm?") == [
        "fact not mirrored ; fact mirrored ; claim slide > #1"
    ]


SETTINGS = [
    *("fact mirrored", "fact not mirrored", "fact turned half", "fact not turned"),
    *("fact seen object", "fact moves sensor", "fact thread left", "fact everything"),
]


@given(st.lists(st.sampled_from(SETTINGS), max_size=6))
def test_facts_of_which_the_last_is_kept_make_the_same_frame(stated):
    facts = read_line(" ; ".join(stated)).facts if stated else ()
    expected = with_facts(FrameSpec(), facts, columns=224)
    assert with_facts(FrameSpec(), last_of_each(facts), columns=224) == expected


def test_what_is_not_surely_a_fact_alone_is_left_to_the_whole():
    assert lines("Hm, mirrored. More than 2 mm?") == []
    assert lines("It is mirrored.") == []
    assert lines(" ".join(["It is mirrored."] * (MOST_SENTENCES + 1))) == []
    assert lines(" ".join(["0.05 mm per pixel."] * (MOST_SLOTS + 1))) == []


def test_where_what_is_left_speaks_of_the_same_fact_the_order_counts():
    assert lines(f"{UNSURE} It is not mirrored.") == []
    assert lines(f"It is mirrored. {UNSURE}") == ["fact mirrored ; way"]


@pytest.mark.parametrize(
    ("text", "line", "lost"),
    [
        ("It is mirrored. More than 2 mm?", "way", 0.95),
        ("It is mirrored. More than 2 mm?", "fact mirrored ; way", 0.0),
        ("It is mirrored. More than 2 mm?", "mirror > way", 0.0),
        ("It is mirrored. More than 2 mm?", "fact not mirrored ; way", 0.95),
        ("It is not mirrored. More than 2 mm?", "mirror > way", 0.95),
        ("It is mirrored. It is not mirrored.", "fact not mirrored ; way", 0.05 * 0.95),
        ("It is mirrored. It is not mirrored.", "fact mirrored ; way", 0.95),
        ("It is mirrored. Forget all I said.", "fact everything ; way", 0.05 * 0.95),
        ("30 fps; 0.05 mm per pixel.", "fact rate #1 ; fact scale #2", 0.0),
        ("30 fps; 0.05 mm per pixel.", "fact rate #1 ; fact scale #1", 0.95),
    ],
)
def test_a_fact_that_a_sentence_states_and_a_reading_lacks_makes_it_unsure(text, line, lost):
    reading = Reading(line, quantities(text), 0.9, 0.9)
    assert chance_lost(reading, alone(text)) == pytest.approx(lost)


def test_a_fact_that_holds_anyhow_is_missed_only_where_another_is_stated():
    said = read_alone("moves. unclear.", {"moves.": MOVES, "unclear.": UNCLEAR}.get)
    assert chance_lost(Reading("way", (), 0.9, 0.9), said) == 0
    assert chance_lost(Reading("fact moves sensor ; way", (), 0.9, 0.9), said) > 0.9


MOVES, UNCLEAR = (
    Reading(line, (), 0.95, 0.9) for line in ("fact moves object", "fact unclear other")
)
