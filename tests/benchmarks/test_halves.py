import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest

from geotlm_lm.benchmarks import halves
from geotlm_lm.benchmarks.halves import HALVES, half_of, hashed, rows_of_half

LISTED = tomllib.loads(Path(halves.__file__).with_name("halves.toml").read_text())


@pytest.mark.parametrize("half", HALVES)
def test_every_listed_family_is_where_its_hash_puts_it(half):
    assert all(half_of(family) == hashed(family) == half for family in LISTED[half])


def test_one_thing_under_two_names_is_of_one_half():
    assert half_of("avocado_real") == half_of("avocado")


def test_rows_are_of_one_half_or_of_both():
    rows = [SimpleNamespace(object_family=name) for name in ("lemon", "tsa", "unheard of", "pen")]
    reported, tuned = (rows_of_half(rows, half) for half in HALVES)
    assert rows_of_half(rows, None) == tuple(rows)
    assert len(reported) + len(tuned) == len(rows)
    assert [one.object_family for one in tuned][:1] == ["lemon"]
    assert rows[1] in reported
