"""What a video's container declares about its own end, read without a decoder.

Matroska and WebM: RFC 8794 and 9559. AVI: RIFF chunks, OpenDML's among them. MP4 and MOV: boxes of
ISO/IEC 14496-12. A decoder stops at the end of what is there and says nothing.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

_EBML, _SEGMENT, _INFO, _CLUSTER = 0x1A45DFA3, 0x18538067, 0x1549A966, 0x1F43B675
_TICK_NS, _DURATION = 0x2AD7B1, 0x4489

WHOLE_SHARE = 0.95
"""Share of the declared length that a whole recording has at least."""


@dataclass(frozen=True)
class DeclaredEnd:
    """Where a container says that it ends."""

    present_bytes: int
    declared_bytes: int | None  # None as of one that is still being written
    duration_s: float | None = None

    def note(self) -> str | None:
        """Return a sentence where the end is missing or cannot be known; None of a whole file."""
        if self.declared_bytes is None:
            return (
                "The file does not declare where it ends, as one that is still being written: what "
                "comes after its last frame is not seen."
            )
        if self.present_bytes >= self.declared_bytes:
            return None
        share = self.present_bytes / self.declared_bytes
        return (
            f"Only {share:.0%} of the file is there: it is cut off or still being written, and "
            f"what comes later is not seen; copy or record it again."
        )


def declared_end(path: Path) -> DeclaredEnd | None:
    """Return what a video file declares; None where it is of no known container, or unreadable."""
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        head = file.read(12)
        reader = _reader_of(head)
        if reader is None:
            return None
        file.seek(0)
        try:
            return reader(file, size)
        except (struct.error, IndexError, OverflowError):  # it ends within a header
            return DeclaredEnd(size, size + 1)


def cut_off_note(
    path: Path, frame_count: int, length_s: float | None, declared_s: float | None
) -> str | None:
    """Return a sentence where the end of a video is missing; None where all of it is there.

    `length_s` is how long the decoded frames last, None where they have no times; `declared_s` how
    long the decoder says that the file does.
    """
    end = declared_end(path)
    if end is not None and end.duration_s is not None:
        declared_s = end.duration_s
    if frame_count > 1 and length_s and declared_s and length_s < WHOLE_SHARE * declared_s:
        return (
            f"Only the first {length_s:.1f} s of {declared_s:.1f} s can be decoded: the file is "
            f"cut off or damaged; copy or record it again."
        )
    return None if end is None else end.note()


def _reader_of(head: bytes) -> Callable[[BinaryIO, int], DeclaredEnd] | None:
    if head.startswith(_EBML.to_bytes(4, "big")):
        return _matroska
    if head.startswith(b"RIFF") and head[8:12] == b"AVI ":
        return _avi
    return _boxes if head[4:8] in (b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip") else None


def _matroska(file: BinaryIO, size: int) -> DeclaredEnd:
    for element, begin, length in _elements(file, 0, size):
        if element == _SEGMENT:
            declared = None if length is None else begin + length
            return DeclaredEnd(size, declared, _duration_s(file, begin, size))
    return DeclaredEnd(size, size + 1)


def _duration_s(file: BinaryIO, begin: int, size: int) -> float | None:
    """Return a segment's duration, which its Info holds in ticks; that comes before the frames."""
    for element, at, length in _elements(file, begin, size):
        if element == _INFO and length is not None:
            tick_ns, ticks = 10**6, None
            for field, start, count in _elements(file, at, at + length):
                file.seek(start)
                value = file.read(min(count or 0, 8))
                if field == _TICK_NS:
                    tick_ns = int.from_bytes(value, "big")
                elif field == _DURATION and len(value) in (4, 8):
                    [ticks] = struct.unpack(">f" if len(value) == 4 else ">d", value)
            return 1e-9 * tick_ns * ticks if ticks else None
        if element == _CLUSTER:
            return None
    return None


def _elements(file: BinaryIO, begin: int, end: int) -> Iterator[tuple[int, int, int | None]]:
    """Yield each element's identifier, where its content begins, and its size, None if unknown."""
    while begin < end:
        file.seek(begin)
        element, identifier_bytes = _variable(file, keeps_marker=True)
        length, length_bytes = _variable(file, keeps_marker=False)
        begin += identifier_bytes + length_bytes
        is_unknown = length == 2 ** (7 * length_bytes) - 1
        yield element, begin, None if is_unknown else length
        if is_unknown:
            return
        begin += length


def _variable(file: BinaryIO, *, keeps_marker: bool) -> tuple[int, int]:
    """Return a number of variable length and how many bytes it takes, RFC 8794 section 4."""
    first = file.read(1)[0]
    count = 9 - first.bit_length()
    if count > 8:
        raise IndexError("no length of a variable number")
    rest = file.read(count - 1)
    if len(rest) < count - 1:
        raise IndexError("the file ends within a variable number")
    top = first if keeps_marker else first & (0xFF >> count)
    return int.from_bytes(bytes([top]) + rest, "big"), count


def _avi(file: BinaryIO, size: int) -> DeclaredEnd:
    """Read the RIFF chunks, of which a file of more than 1 GiB has several."""
    begin = 0
    while begin < size:
        file.seek(begin)
        name, length = struct.unpack("<4sI", file.read(8))
        if name != b"RIFF":  # what some recorders leave behind the last one
            break
        if length in (0, 2**32 - 1):  # filled in when the file is closed
            return DeclaredEnd(size, None)
        begin += 8 + length + length % 2
    return DeclaredEnd(size, begin - (begin == size + 1))  # the last one's padding may be missing


def _boxes(file: BinaryIO, size: int) -> DeclaredEnd:
    begin = 0
    while begin < size:
        file.seek(begin)
        length, name = struct.unpack(">I4s", file.read(8))
        if length == 1:
            [length] = struct.unpack(">Q", file.read(8))
        if length == 0:  # to the end of the file
            return DeclaredEnd(size, size)
        if length < 8:  # no box: what stands behind the last one
            break
        begin += length
    return DeclaredEnd(size, begin)
