"""Damage to files and sentences: what a broken disk, a hostile sender or a cat on the keys makes.

Knows no format; words of one may be handed in.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

LONGEST_BYTES = 1 << 17
"""Of a damaged input; longer ones only take longer to read."""

EXTREMES = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
"""Integers at which counters and sizes turn over."""

NUMBERS = (b"0", b"-1", b"1e309", b"nan", b"99999999999999999999", b"0.5", b"")
"""What a number in a text may be replaced by."""


def damaged(stored: bytes, others: Sequence[bytes], words: Sequence[bytes], rng: random.Random):
    """Return `stored` with one to eight random changes.

    Args:
        stored: The input to change.
        others: Inputs to take parts from; at least one.
        words: Of the input's language, put in as they are; may be empty.
        rng: Draws everything.
    """
    changed = bytearray(stored)
    for _ in range(1 << rng.randrange(4)):
        change = rng.choice(CHANGES)
        change(changed, others, words, rng)
    return bytes(changed[:LONGEST_BYTES])


def _flip(data: bytearray, others: Sequence[bytes], words: Sequence[bytes], rng: random.Random):
    if data:
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def _set(data: bytearray, others: Sequence[bytes], words: Sequence[bytes], rng: random.Random):
    if data:
        data[rng.randrange(len(data))] = rng.randrange(256)


def _extreme(data: bytearray, others: Sequence[bytes], words: Sequence[bytes], rng: random.Random):
    value, size = rng.choice(EXTREMES), rng.choice((1, 2, 4, 8))
    if len(data) >= size:
        at = rng.randrange(len(data) - size + 1)
        order = rng.choice(("little", "big"))
        data[at : at + size] = (value % (1 << 8 * size)).to_bytes(size, order)


def _cut(data: bytearray, others: Sequence[bytes], words: Sequence[bytes], rng: random.Random):
    del data[rng.randrange(len(data) + 1) :]


def _drop(data: bytearray, others: Sequence[bytes], words: Sequence[bytes], rng: random.Random):
    at = rng.randrange(len(data) + 1)
    del data[at : at + rng.choice((1, 2, 4, 8, 64, 1024))]


def _repeat(data: bytearray, others: Sequence[bytes], words: Sequence[bytes], rng: random.Random):
    at, length = rng.randrange(len(data) + 1), rng.choice((1, 4, 16, 256))
    data[at:at] = data[at : at + length] * rng.choice((1, 2, 16))


def _splice(data: bytearray, others: Sequence[bytes], words: Sequence[bytes], rng: random.Random):
    other = rng.choice(others)
    begin = rng.randrange(len(other) + 1)
    at = rng.randrange(len(data) + 1)
    data[at : at + rng.choice((0, 8, 64))] = other[begin : begin + rng.choice((1, 8, 64, 4096))]


def _word(data: bytearray, others: Sequence[bytes], words: Sequence[bytes], rng: random.Random):
    at = rng.randrange(len(data) + 1)
    data[at : at + rng.choice((0, 0, 4))] = rng.choice(words or NUMBERS)


def _number(data: bytearray, others: Sequence[bytes], words: Sequence[bytes], rng: random.Random):
    digits = [place for place, byte in enumerate(data) if 48 <= byte < 58]
    if digits:
        begin = end = rng.choice(digits)
        while end < len(data) and 48 <= data[end] < 58:
            end += 1
        data[begin:end] = rng.choice(NUMBERS)


CHANGES = (_flip, _set, _extreme, _cut, _drop, _repeat, _splice, _word, _number)
"""Every way an input is changed."""
