"""The corpus and the grammar write queries that can be read, and hold whole families out."""

from itertools import islice

import pytest

from geotlm_lm.query.grammar import SPLITS, corpus, grammar, split_of
from geotlm_lm.query.labelled import BLIND, SET_UPS, TUNE, Labelled, labelled
from geotlm_lm.query.quantities import quantities
from geotlm_lm.query.text import read, write
from geotlm_lm.query.types import ASKS, filled

CORPUS = [Labelled(one.text, (one.query,)) for split in SPLITS for one in corpus(split)]
SETS = {"corpus": CORPUS, BLIND: labelled(BLIND), SET_UPS: labelled(SET_UPS), TUNE: labelled(TUNE)}


@pytest.mark.parametrize("name", SETS)
def test_every_label_is_canonical_and_its_slots_are_quantities_of_its_text(name):
    for row in SETS[name]:
        found = quantities(row.text)
        assert len(set(row.queries)) == len(row.queries), row.text
        for line in row.queries:
            query = read(line, max(len(found), 1))
            assert write(query) == line
            filled(query, found)


def test_no_text_has_two_labels():
    texts = [row.text for rows in SETS.values() for row in rows if not row.asks_on]
    assert len(set(texts)) == len(texts)


@pytest.mark.parametrize("split", SPLITS)
def test_pairs_are_canonical_and_of_their_split(split):
    for pair in islice(grammar().pairs(3, split), 300):
        found = quantities(pair.text)
        query = read(pair.query, len(found))
        assert write(query) == pair.query
        filled(query, found)
        questions = [one for one in pair.families if one in FAMILIES]
        assert {split_of(one) for one in questions} <= {split}
        assert "{" not in pair.text
        assert "\ue000" not in pair.text


def test_a_seed_writes_the_same_pairs():
    assert list(islice(grammar().pairs(5), 50)) == list(islice(grammar().pairs(5), 50))


def test_training_writes_every_kind_of_ask():
    asks = {
        word
        for family in grammar().families
        if split_of(family.id) == "train"
        for word in family.query.split()
    }
    assert set(ASKS) <= asks


def test_no_template_means_two_things():
    meant = {}
    for family in grammar().families:
        for text in family.texts:
            assert meant.setdefault(text.lower(), family.query) == family.query, text


FAMILIES = {one.id for one in grammar().families}
