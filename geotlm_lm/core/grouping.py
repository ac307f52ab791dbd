"""Rows that belong together, such as all clips of one object, numbered in order of appearance."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np
from numpy.typing import NDArray

Labels = Sequence[Hashable]


def group_codes(groups: Labels) -> tuple[NDArray[np.intp], list[Hashable]]:
    """Number the groups in order of first appearance; return each row's number and the names."""
    numbers: dict[Hashable, int] = {}
    codes = [numbers.setdefault(group, len(numbers)) for group in groups]
    return np.array(codes, dtype=np.intp), list(numbers)


def mean_by_group(values: NDArray, groups: Labels) -> dict[Hashable, float]:
    """Return the mean of `values` in each group, groups in order of first appearance."""
    codes, names = group_codes(groups)
    sums = np.bincount(codes, weights=values, minlength=len(names))
    return dict(zip(names, (sums / np.bincount(codes)).tolist(), strict=True))
