"""Sets of times, each a list of (from, to) in seconds."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

Interval = tuple[float, float]


def within_any(sets: Sequence[Sequence[Interval]]) -> list[Interval]:
    """Return the times that lie in at least one of some sets, in order and apart."""
    found: list[Interval] = []
    for begin, end in sorted(one for each in sets for one in each):
        if found and begin <= found[-1][1]:
            found[-1] = (found[-1][0], max(found[-1][1], end))
        else:
            found.append((begin, end))
    return found


def within_all(sets: Sequence[Sequence[Interval]]) -> list[Interval]:
    """Return the times that lie in every one of some sets."""
    return reduce(_within_both, map(lambda one: within_any([one]), sets))


def outside(spans: Sequence[Interval], whole: Interval) -> list[Interval]:
    """Return the times of a whole that lie in none of some intervals."""
    found, until = [], whole[0]
    for begin, end in within_any([spans]):
        if begin > until:
            found.append((until, min(begin, whole[1])))
        until = max(until, end)
    return found + [(until, whole[1])] * (until < whole[1])


def _within_both(one: Sequence[Interval], other: Sequence[Interval]) -> list[Interval]:
    pairs = [(max(a, c), min(b, d)) for a, b in one for c, d in other]
    return [(begin, end) for begin, end in pairs if begin < end]
