"""Every question of the corpus is read and answered as it is recorded.

`python -m tests.conversation.questions` records them again; what a change of the rules changes is
then seen in the difference of one file.
"""

import pytest

from tests.conversation.questions import BOTH, COLUMNS, ONE_CLIP, entries, recorded
from tests.conversation.reading import reading

ENTRIES = entries()
SHOWN = 10
"""Differences that a failure lists."""


def test_questions_stand_in_order_and_once():
    keys = [(entry["text"], entry.get("after", [])) for entry in ENTRIES]
    assert keys == sorted(keys)
    assert all(one != other for one, other in zip(keys, keys[1:], strict=False))


def test_the_questions_are_of_every_kind_and_read_in_every_way():
    kinds = {answer.get("kind") for entry in ENTRIES for answer in entry["answers"].values()}
    assert kinds >= {"direction", "verify", "choice", "class", "contact", "moving", "refusal"}
    assert kinds >= {"negation", "premise", "viewpoint", "actor", "thread", "mirrored", "undo"}
    assert kinds >= {"reversed", "magnitude", "rate", "evidence", "confidence", "frame", None}


def test_every_question_is_read_as_recorded():
    wrong = [
        (entry["text"], read, entry["read"])
        for entry in ENTRIES
        if (read := reading(entry["text"], COLUMNS)) != entry["read"]
    ]
    assert wrong[:SHOWN] == []


@pytest.mark.slow
def test_every_question_is_answered_as_recorded(shipped, examples):
    """Each is asked once: of two clips where it is about two, else of one of them in turn."""
    wrong = []
    for number, entry in enumerate(ENTRIES):
        expected = entry["answers"]
        of = BOTH if BOTH in expected else ONE_CLIP[number % len(ONE_CLIP)]
        said = recorded(shipped, examples, entry["text"], entry.get("after", []), [of])
        if said != {of: approximately(expected[of])}:
            wrong.append((entry["text"], said, expected[of]))
    assert wrong[:SHOWN] == []


def approximately(answer):
    """Another processor rounds the last digits differently."""
    return answer | {"confidence": pytest.approx(answer["confidence"], abs=1e-4)}
