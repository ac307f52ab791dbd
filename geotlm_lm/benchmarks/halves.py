"""Which real recordings things are chosen by, and which are reported: halves by what is touched."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any, Literal

from geotlm_lm.benchmarks.rows import Row

Half = Literal["tune", "report"]
HALVES: tuple[Half, ...] = ("report", "tune")

TUNE_TITLE = "Of the half that things are chosen by"
"""Over the tables of `tune`, which are never mixed with those of `report`."""


def half_of(family: str) -> Half:
    """Return the half of a family of objects: as halves.toml says, else by its hash."""
    known = _halves()
    family = known["same"].get(family, family)
    for half in HALVES:
        if family in known[half]:
            return half
    return hashed(family)


def hashed(family: str) -> Half:
    """Return the half that a family's name falls to."""
    digest = hashlib.sha256(f"{_halves()['salt']}:{family}".encode()).digest()
    return "report" if digest[0] % 2 else "tune"


def rows_of_half(rows: Iterable[Any], half: Half | None) -> tuple[Any, ...]:
    """Return the rows of a half, by their `object_family`; all for None."""
    return tuple(row for row in rows if half in (None, half_of(row.object_family)))


def titled(title: str, half: Half | None) -> str:
    """Return what a set of a half's clips is called."""
    return title if half is None else f"{title}, {half}"


def is_reported(row: Row) -> bool:
    """Tell whether a row is not of the half that things are chosen by."""
    return f", {HALVES[1]}" not in row.case


@cache
def _halves() -> dict[str, Any]:
    return tomllib.loads(Path(__file__).with_name("halves.toml").read_text(encoding="utf-8"))
