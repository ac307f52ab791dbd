"""A follow-up stands for what was asked before it."""

import pytest

from geotlm_lm.query.follow_up import resumed
from geotlm_lm.query.text import read, write
from geotlm_lm.query.types import Query


@pytest.mark.parametrize(
    ("before", "now", "meant"),
    [
        ("way", "mirror > again", "mirror > way"),
        ("mirror > way", "mirror > again", "way"),
        ("mirror > way", "again plain", "way"),
        ("amount turn", "again rad", "amount turn rad"),
        ("way", "again mm", "amount slide mm"),
        ("sensor > way", "again object", "way"),
        ("of-first > amount turn", "of-second > again", "of-second > amount turn"),
        ("way ; amount", "backwards > again", "backwards > way ; backwards > amount"),
        ("way", "fact mirrored ; again", "fact mirrored ; way"),
        ("way ; as word", "again", "way ; as word"),
        ("way", "claim turn", "claim turn"),
        ("fact mirrored", "again", "way"),
        ("fact mirrored", "mirror > again", "mirror > way"),
        ("fact mirrored", "fact turned half ; again plain", "fact turned half"),
        ("", "fact scale #1 ; again mm", "fact scale #1 ; amount slide mm"),
    ],
)
def test_it_is_resumed(before, now, meant):
    asked = read(before) if before else Query()
    assert write(resumed(read(now, 1), asked)) == meant
