"""Folds in which no object stands on two sides: train, validation and test are disjoint by object.

The validation part exists so that the best epoch is never chosen on the held-out objects.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.numbers import Labels, generator_for, group_codes

Rows = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Fold:
    """Row numbers of one fold.

    Args:
        train: Rows to fit on.
        val: Rows to choose the epoch on.
        test: Rows to report; their objects are in neither of the others.
        held_out: The objects of `test`.
    """

    train: Rows
    val: Rows
    test: Rows
    held_out: tuple[str, ...]


def object_folds(
    objects: Labels, fold_count: int, *, seed: int, val_share: float = 0.15
) -> list[Fold]:
    """Deal the objects into folds of nearly equal object count; each is held out once.

    Args:
        objects: The object of each row.
        fold_count: Number of folds, from 2 to the number of objects.
        seed: Root of the shuffles.
        val_share: Share of the objects not held out that become validation objects, at least one.

    Raises:
        ValueError: If the objects do not suffice for three disjoint parts in each fold.
    """
    codes, names = group_codes(objects)
    if not 2 <= fold_count <= len(names) or len(names) < 3:
        raise ValueError(
            f"{fold_count} folds of three disjoint parts need at least {max(fold_count, 3)} "
            f"objects, and at least 2 folds; found {len(names)} objects"
        )
    order = generator_for(seed, "folds").permutation(len(names))
    return list(_folds(codes, names, np.array_split(order, fold_count), seed, val_share))


def leave_one_object_out(objects: Labels, *, seed: int, val_share: float = 0.15) -> list[Fold]:
    """Hold out each object once, in order of first appearance; arguments as in `object_folds`.

    Raises:
        ValueError: If there are fewer than three objects.
    """
    codes, names = group_codes(objects)
    if len(names) < 3:
        raise ValueError(f"three disjoint parts need at least 3 objects; found {len(names)}")
    parts = [np.array([number]) for number in range(len(names))]
    return list(_folds(codes, names, parts, seed, val_share))


def _folds(
    codes: Rows, names: list, parts: list[Rows], seed: int, val_share: float
) -> Iterator[Fold]:
    everything = np.arange(len(names))
    for number, test in enumerate(parts):
        rest = np.setdiff1d(everything, test)
        rest = generator_for(seed, "validation", number).permutation(rest)
        # One object stays for training and one for validation, whatever the share.
        val_count = min(max(1, round(val_share * len(rest))), len(rest) - 1)
        if val_count < 1:
            raise ValueError("a fold leaves fewer than two objects for training and validation")
        val, train = rest[:val_count], rest[val_count:]
        yield Fold(
            train=np.flatnonzero(np.isin(codes, train)),
            val=np.flatnonzero(np.isin(codes, val)),
            test=np.flatnonzero(np.isin(codes, test)),
            held_out=tuple(str(names[one]) for one in test),
        )
