"""The corpus and the grammar write queries that can be read, and hold whole families out."""

from itertools import islice

import pytest

from geotlm_lm.query.copied import copied
from geotlm_lm.query.lines import PROGRAM_WORDS, normal, read, write
from geotlm_lm.query.program import _ANSWERS, MOST_COPIED, MOST_SLOTS, filled, type_of
from geotlm_lm.query.quantities import quantities
from geotlm_lm.training.grammar import _CHOICE, _FIELD, SPLITS, corpus, grammar, split_of
from geotlm_lm.training.labelled import BLIND, SET_UPS, TUNE, Labelled, labelled

CORPUS = [Labelled(one.text, (one.query,)) for split in SPLITS for one in corpus(split)]
SETS = {"corpus": CORPUS, BLIND: labelled(BLIND), SET_UPS: labelled(SET_UPS), TUNE: labelled(TUNE)}


def assert_is_meant(text, line):
    numbers, texts = quantities(text)[:MOST_SLOTS], copied(text)[:MOST_COPIED]
    program = read(line, len(numbers), len(texts))
    assert write(program) == line
    filled(program, numbers, texts)


@pytest.mark.parametrize("name", SETS)
def test_every_label_is_canonical_and_its_slots_are_quantities_of_its_text(name):
    for row in SETS[name]:
        assert len(set(row.queries)) == len(row.queries), row.text
        for line in row.queries:
            assert_is_meant(row.text, line)


def test_labels_that_are_learned_are_in_normal_form():
    """Of two lines that mean the same a reader would have to guess."""
    assert all(write(normal(read(pair.query))) == pair.query for pair in corpus("train"))


def test_no_text_has_two_labels():
    texts = [row.text for rows in SETS.values() for row in rows if not row.asks_on]
    assert len(set(texts)) == len(texts)


@pytest.mark.parametrize("split", SPLITS)
def test_pairs_are_canonical_and_of_their_split(split):
    for pair in islice(grammar().pairs(3, split), 300):
        assert_is_meant(pair.text, pair.query)
        questions = [one for one in pair.families if one in FAMILIES]
        assert {split_of(one) for one in questions} <= {split}
        assert "{" not in pair.text
        assert "\ue000" not in pair.text


def test_a_seed_writes_the_same_pairs():
    assert list(islice(grammar().pairs(5), 50)) == list(islice(grammar().pairs(5), 50))


def test_training_writes_every_type_of_answer():
    lines = [pair.query for pair in islice(grammar().pairs(3, "train"), 1000)]
    answers = [answer for line in lines for answer in read(line).answers]
    assert {*_ANSWERS} <= {type_of(answer) for answer in answers if answer.word != "again"}
    assert {word for line in lines for word in line.split() if ":" not in word} <= {*PROGRAM_WORDS}


def test_no_template_means_two_things():
    meant = {}
    for family in grammar().families:
        for text in family.texts:
            assert meant.setdefault(text.lower(), family.query) == family.query, text


def test_wordings_of_a_question_are_of_their_split_and_mean_it_alone():
    for split in SPLITS:
        pairs = list(islice(grammar().wordings(0, split, "way all"), 50))
        assert {pair.query for pair in pairs} == {"way all"}
        assert {split_of(name) for pair in pairs for name in pair.families} == {split}
        assert all(len(pair.families) == 1 for pair in pairs)


def test_lines_that_are_families_each_end_with_their_own_marks():
    families = {one.id: one for one in grammar().families}
    asked, told = families["way/own-1.train"], families["way/own-15.train"]
    assert asked.end == "?"
    assert (told.texts, told.end) == (("Describe [the|its|this] [motion|movement|direction]",), ".")
    assert families["choice/own-two-options-1.train"].end == ""


FAMILIES = {one.id for one in grammar().families}


def alternatives(text):
    """Yield a template's texts, one for each of its alternatives."""
    match = _CHOICE.search(text)
    if match is None:
        yield text
        return
    for chosen in (match[1] or match[2]).split("|"):
        yield from alternatives(text[: match.start()] + chosen + text[match.end() :])


def test_whatever_is_asked_stands_in_the_words_of_every_template():
    words = grammar().words
    for family in grammar().families:
        asked = set(_FIELD.findall(family.query))
        for text in family.texts:
            # A list of words may hold fields of its own.
            nested = any(
                name in words and "{" in str(words[name]) for name, _ in _FIELD.findall(text)
            )
            for each in () if nested else alternatives(text):
                assert asked <= set(_FIELD.findall(each)), (family.id, each)
