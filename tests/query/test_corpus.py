"""The corpus and the grammar write queries that can be read, and hold whole families out."""

import json
from itertools import islice
from pathlib import Path

import pytest

from geotlm_lm.query.grammar import SPLITS, grammar, split_of
from geotlm_lm.query.quantities import quantities
from geotlm_lm.query.text import read, write
from geotlm_lm.query.types import ASKS, filled

LINES = Path(__file__).parent.parent.joinpath("queries.jsonl").read_text().splitlines()
CORPUS = [json.loads(line) for line in LINES]


def test_every_query_of_the_corpus_is_canonical_and_its_slots_are_quantities_of_its_text():
    for row in CORPUS:
        found = quantities(row["text"])
        query = read(row["query"], len(found))
        assert write(query) == row["query"]
        filled(query, found)


def test_no_text_of_the_corpus_has_two_queries():
    assert len({row["text"] for row in CORPUS}) == len(CORPUS)


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
