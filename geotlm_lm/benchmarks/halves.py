"""Which real recordings things are chosen by, and which are reported: halves by what is touched."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, Literal

from geotlm_lm.benchmarks.cases.recordings import real_recordings
from geotlm_lm.benchmarks.rows import Listing, Pivot, Row
from geotlm_lm.data.labelled_recordings import LabelledRecordings

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


def by_half(view: Listing | Pivot) -> dict[str, tuple[Listing | Pivot, Callable[[Row], bool]]]:
    """Return the views of a section whose halves are never shown in one table."""
    return {"": (view, is_reported), TUNE_TITLE: (view, lambda row: not is_reported(row))}


def recordings_by_half(folder: Path | None) -> Iterator[tuple[str, Half, LabelledRecordings]]:
    """Yield each folder of labelled recordings by name, once for each half with its rows."""
    for name, real in real_recordings(folder).items():
        for half in HALVES:
            yield name, half, replace(real, rows=rows_of_half(real.rows, half))


@cache
def _halves() -> dict[str, Any]:
    return tomllib.loads(Path(__file__).with_name("halves.toml").read_text(encoding="utf-8"))
