"""The order of a folder's frames by the numbers in their names; knows names, no pictures.

A name is texts with numbers between them. A column is what one place for a number holds over all
names. A frame number is a column whose integers are all distinct and leave few gaps; a time is any
other column. A frame number stands before a time, whose fraction may be written in several ways.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from itertools import pairwise
from pathlib import PurePath

from geotlm_lm.core.errors import UnreadableClip

MOST_PLACES = 2
"""Places per frame from the first number to the last up to which a column is frame numbers: beyond
it most places are empty, as of times in milliseconds."""

NAMED_SERIES = 3
"""Recordings of one folder that a refusal names."""

_INTEGER = re.compile(r"(\d+)")
_DECIMAL = re.compile(r"((?<![\d.])\d+\.\d+(?!\d|\.\d)|\d+)")


@dataclass(frozen=True)
class FrameOrder:
    """The names of one recording's images in order, and what is not plain about it."""

    names: tuple[str, ...]
    numbers: tuple[int, ...]  # from 0; a frame that is missing leaves a gap
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Name:
    """A name taken apart: texts around numbers, all but the ending; `key` sorts it naturally."""

    name: str
    texts: tuple[str, ...]
    numbers: tuple[Decimal, ...]

    @property
    def key(self) -> list[tuple[int, Decimal, str]]:
        pairs = zip(self.texts, (*self.numbers, None), strict=True)
        parts = [part for pair in pairs for part in pair if part not in ("", None)]
        return [(1, Decimal(0), p) if isinstance(p, str) else (0, p, "") for p in parts]


def natural_order(stems: Sequence[str]) -> list[int]:
    """Return the places of stems in natural order: frame2, frame10; t-8, t7; 0.19, 0.2."""
    keys = [name.key for name in _parsed(stems, stems)]
    return sorted(range(len(stems)), key=keys.__getitem__)


def frame_order(folder: str, names: Sequence[str]) -> FrameOrder:
    """Return the order of the images of a folder, which is named in errors."""
    _refuse_two_formats(folder, names)
    stems = [PurePath(name).stem for name in names]
    parsed = sorted(_parsed(names, stems), key=lambda name: name.key)
    [(places, _)] = Counter(len(name.numbers) for name in parsed).most_common(1)
    if not places or len(names) == 1:
        return FrameOrder(tuple(name.name for name in parsed), tuple(range(len(parsed))))
    others = [name for name in parsed if len(name.numbers) != places]
    parsed = [name for name in parsed if len(name.numbers) == places]
    if any(count > 1 for count in Counter(name.texts for name in others).values()):
        raise _several(folder, [*parsed, *others], lambda name: name.texts)
    order, numbers, notes = _ordered(folder, parsed)
    if others:
        notes.append(f"Left out: {len(others)} named unlike the other images ({others[0].name}).")
    if (missing := numbers[-1] + 1 - len(numbers)) > 0:
        notes.append(
            f"The frames' numbers leave out {missing} of {numbers[-1] + 1}: these are missing; "
            f"times count them."
        )
    return FrameOrder(tuple(name.name for name in order), numbers, tuple(notes))


def _ordered(folder: str, natural: list[_Name]) -> tuple[list[_Name], tuple[int, ...], list[str]]:
    """Return names in order, where each stood in the recording, and notes."""
    columns = list(zip(*(name.numbers for name in natural), strict=True))
    varying = [place for place, column in enumerate(columns) if len(set(column)) > 1]
    counting = [place for place in varying if _is_counting(columns[place])]
    if len({name.texts for name in natural}) == 1:
        # Seconds start anew at a full minute: what stands before them says where they belong.
        counting = [p for p in counting if p == varying[0] or not _is_carried(columns[p])]
    by_number = next(iter(counting), None)
    plain = tuple(range(len(natural)))
    if by_number is None:
        _refuse_several(folder, natural, varying)
        if natural == sorted(natural, key=_as_integers):
            return natural, plain, []
        return natural, plain, ["Numbers with a point in the images' names are read as decimals."]
    order = sorted(natural, key=lambda name: name.numbers[by_number])
    values = [name.numbers[by_number] for name in order]
    step = _common_step(values)
    numbers = tuple(int(value - values[0]) // step for value in values)
    note = (
        f"Images were read in order of their frame numbers, {order[0].name} first; other parts of "
        f"their names would order them otherwise."
    )
    return order, numbers, [note] if order != natural else []


def _parsed(names: Sequence[str], stems: Sequence[str]) -> list[_Name]:
    """Return names taken apart; with decimals, unless two names would be the same number by it."""
    stems = [stem.lower() for stem in stems]
    for pattern in (_DECIMAL, _INTEGER):
        parsed = []
        plain = {text for stem in stems if (text := pattern.split(stem)[0])[-1:] != "-"}
        for name, stem in zip(names, stems, strict=True):
            parts = pattern.split(stem)
            # A minus is a sign where the same text lies beside it without: t-8 and t7. It is a
            # separator in frame-1 and frame-2, and between two numbers, as in 2024-01-02.
            if len(parts) > 1 and parts[0][-1:] == "-" and parts[0][:-1] in plain:
                parts[:2] = [parts[0][:-1], f"-{parts[1]}"]
            parsed.append(_Name(name, tuple(parts[::2]), tuple(map(Decimal, parts[1::2]))))
        if len({(name.texts, name.numbers) for name in parsed}) == len(parsed):
            break
    return parsed


def _as_integers(name: _Name) -> list[tuple[int, int, str]]:
    parts = [part for part in _INTEGER.split(PurePath(name.name).stem.lower()) if part]
    return [(0, int(part), "") if part.isdecimal() else (1, 0, part) for part in parts]


def _is_counting(column: Sequence[Decimal]) -> bool:
    """Tell whether numbers may be those of frames: integers, each once, with few gaps."""
    if len(set(column)) < len(column) or any(value % 1 for value in column):
        return False
    span = (max(column) - min(column)) / _common_step(column)
    return span + 1 <= MOST_PLACES * len(column)


def _is_carried(column: Sequence[Decimal]) -> bool:
    """Tell whether a column, in natural order, starts anew once, as seconds do at a full minute."""
    falls = sum(later < earlier for earlier, later in pairwise(column))
    return falls == 1 and column[-1] < column[0]


def _common_step(values: Sequence[Decimal]) -> int:
    low = min(values)
    return math.gcd(*(int(value - low) for value in values)) or 1


def _refuse_two_formats(folder: str, names: Sequence[str]) -> None:
    endings: dict[str, list[str]] = {}
    for name in sorted(names):
        path = PurePath(name)
        endings.setdefault(path.stem, []).append(path.suffix)
    twice = [suffixes for suffixes in endings.values() if len(suffixes) > 1]
    if twice:
        raise UnreadableClip(
            f"{folder}: holds {len(twice)} frames as {' and as '.join(twice[0])}, expected each "
            f"once; keep one format in the folder."
        )


def _refuse_several(folder: str, names: list[_Name], varying: list[int]) -> None:
    """Refuse names of several recordings that none of their columns tells apart.

    They differ in a text, or every group with the same numbers but the last counts anew from the
    same 0 or 1; nor may two have the same numbers.
    """
    columns = {place: [name.numbers[place] for name in names] for place in varying}
    if any(len(set(column)) == len(column) for column in columns.values()):
        return  # a time tells them apart
    if len({name.texts for name in names}) > 1:
        raise _several(folder, names, lambda name: name.texts)
    same = next((pair for pair in pairwise(names) if pair[0].numbers == pair[1].numbers), None)
    if same is not None:
        raise UnreadableClip(
            f"{folder}: {same[0].name} and {same[1].name} have the same number, expected one image "
            f"of each; keep one of them."
        )
    *before, last = varying
    groups: dict[tuple[Decimal, ...], list[Decimal]] = {}
    for name in names:
        key = tuple(name.numbers[place] for place in before)
        groups.setdefault(key, []).append(name.numbers[last])
    starts = {min(values) for values in groups.values()}
    is_counting = all(_is_counting(v) and _common_step(v) == 1 for v in groups.values())
    if len(groups) > 1 and len(starts) == 1 and starts <= {0, 1} and is_counting:
        raise _several(folder, names, lambda name: tuple(name.numbers[p] for p in before))


def _several(
    folder: str, names: Sequence[_Name], series_of: Callable[[_Name], object]
) -> UnreadableClip:
    counts = Counter(map(series_of, names))
    first = {series_of(name): name.name for name in reversed(names)}
    series = [f"{first[key]} and {count - 1} like it" for key, count in counts.items()]
    more = f" and {len(series) - NAMED_SERIES} more" if len(series) > NAMED_SERIES else ""
    return UnreadableClip(
        f"{folder}: holds the frames of {len(series)} recordings ("
        f"{'; '.join(series[:NAMED_SERIES])}{more}), expected those of one; give each a folder of "
        f"its own."
    )
