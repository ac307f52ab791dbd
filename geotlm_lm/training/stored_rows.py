"""Rows of an array that lies in several files, read when they are asked for and never all at once.

What `numpy.savez` writes is not compressed, so that each row has its place in the file.
"""

from __future__ import annotations

import struct
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.lib import format as npy
from numpy.typing import ArrayLike, DTypeLike, NDArray

_NAME_LENGTHS_AT, _LOCAL_HEADER = 26, 30
"""Bytes of a zip member's own header, which names and extra fields of two lengths follow."""


@dataclass(frozen=True)
class StoredPart:
    """One array within one file.

    Args:
        path: The file.
        offset: Where its first row begins, bytes.
        shape: Of the array, rows first; fewer rows than are stored may count.
        dtype: Of the array.
    """

    path: Path
    offset: int
    shape: tuple[int, ...]
    dtype: np.dtype

    @classmethod
    def of(cls, path: Path, name: str, most: int) -> StoredPart:
        """Find the array `name` in what `numpy.savez` wrote; the first `most` rows count.

        Raises:
            ValueError: If it is compressed or laid out column by column.
        """
        with zipfile.ZipFile(path) as archive:
            member = archive.getinfo(f"{name}.npy")
        if member.compress_type != zipfile.ZIP_STORED:
            raise ValueError(f"{path}: {name} is compressed, so that no row has a place")
        with path.open("rb") as stream:
            stream.seek(member.header_offset + _NAME_LENGTHS_AT)
            lengths = struct.unpack("<HH", stream.read(4))
            stream.seek(member.header_offset + _LOCAL_HEADER + sum(lengths))
            is_first = npy.read_magic(stream) == (1, 0)
            read = npy.read_array_header_1_0 if is_first else npy.read_array_header_2_0
            shape, by_columns, dtype = read(stream)
            if by_columns:
                raise ValueError(f"{path}: {name} is laid out column by column")
            return cls(path, stream.tell(), (min(shape[0], most), *shape[1:]), dtype)

    def read(self, rows: NDArray[np.integer]) -> NDArray:
        """Return some of its rows, (len(rows), ...)."""
        found = np.empty((len(rows), *self.shape[1:]), self.dtype)
        count = int(np.prod(self.shape[1:], dtype=int))
        with self.path.open("rb") as stream:
            for place, row in enumerate(rows.tolist()):
                stream.seek(self.offset + row * count * self.dtype.itemsize)
                values = np.fromfile(stream, self.dtype, count)
                found[place] = values.reshape(self.shape[1:])
        return found


class StoredRows:
    """The rows of several parts, one behind the other; indexed by a slice or by row numbers.

    Args:
        parts: At least one; shapes alike but for the rows.
    """

    def __init__(self, parts: Sequence[StoredPart]) -> None:
        self._parts = tuple(parts)
        self._ends = np.cumsum([part.shape[0] for part in parts])

    def __len__(self) -> int:
        return int(self._ends[-1])

    def __getitem__(self, rows: slice | ArrayLike) -> NDArray:
        wanted = np.arange(len(self))[rows]
        first = self._parts[0]
        found = np.empty((len(wanted), *first.shape[1:]), first.dtype)
        where = np.searchsorted(self._ends, wanted, side="right")
        for index in np.unique(where):
            part, is_here = self._parts[index], where == index
            found[is_here] = part.read(wanted[is_here] - (self._ends[index] - part.shape[0]))
        return found

    def __array__(self, dtype: DTypeLike = None, copy: bool | None = None) -> NDArray:
        return np.asarray(self[:], dtype)
