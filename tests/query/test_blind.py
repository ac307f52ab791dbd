"""Questions of people who know nothing of the program are labelled with queries of the language."""

import json
from pathlib import Path

import pytest

from geotlm_lm.query.quantities import quantities
from geotlm_lm.query.text import read, write
from geotlm_lm.query.types import filled

FOLDER = Path(__file__).parent.parent


@pytest.mark.parametrize("name", ["blind_questions", "tune_questions"])
def test_every_label_is_canonical_and_its_slots_are_quantities_of_its_text(name):
    for line in FOLDER.joinpath(f"{name}.jsonl").read_text().splitlines():
        row = json.loads(line)
        found = quantities(row["text"])
        labels = [row["query"], *row.get("also", ())]
        assert len(set(labels)) == len(labels), row["text"]
        for label in labels:
            query = read(label, max(len(found), 1))
            assert write(query) == label
            filled(query, found)
