"""Facts that stand in sentences of their own are read there; the question is read without them."""

import pytest

from geotlm_lm.query.quantities import Quantity, quantities
from geotlm_lm.query.reading import Reading
from geotlm_lm.query.sentences import (
    MOST_SENTENCES,
    chance_lost,
    read_alone,
    read_apart,
    sentences,
)
from geotlm_lm.query.text import MOST_SLOTS

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


def apart(text):
    return read_apart(text, read_alone(text, read), read)


def lines(text):
    return [one.line for one in apart(text)]


def test_sentences_end_at_their_marks_and_at_the_end_of_a_line():
    text = " Mirrored. 0.05 mm/px; is it 2.5 mm, or not?\n30 fps\n"
    assert sentences(text) == ["Mirrored.", "0.05 mm/px;", "is it 2.5 mm, or not?", "30 fps"]


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
    assert lines("It is not mirrored. It is mirrored.") == ["fact not mirrored ; fact mirrored"]


def test_what_is_not_surely_a_fact_alone_is_left_to_the_whole():
    assert lines("Hm, mirrored. More than 2 mm?") == []
    assert lines("It is mirrored.") == []
    assert lines(" ".join(["It is mirrored."] * (MOST_SENTENCES + 1))) == []
    assert lines(" ".join(["0.05 mm per pixel."] * (MOST_SLOTS + 1))) == []


def test_where_what_is_left_speaks_of_the_same_fact_the_order_counts():
    assert lines(f"{UNSURE} It is not mirrored.") == []
    assert lines(f"It is mirrored. {UNSURE}") == ["fact mirrored ; way"]


@pytest.mark.parametrize(
    ("line", "lost"),
    [
        ("way", 0.95),
        ("fact mirrored ; way", 0.0),
        ("mirror > way", 0.0),
        ("fact turned half ; way", 0.95),
    ],
)
def test_a_fact_that_a_sentence_states_and_a_reading_lacks_makes_it_unsure(line, lost):
    alone = read_alone("It is mirrored. More than 2 mm?", read)
    assert chance_lost(Reading(line, (), 0.9, 0.9), alone) == pytest.approx(lost)


def test_a_fact_that_holds_anyhow_is_not_missed():
    alone = [Reading(line, (), 0.95, 0.9) for line in ("fact moves object", "fact unclear other")]
    assert chance_lost(Reading("way", (), 0.9, 0.9), alone) == 0
