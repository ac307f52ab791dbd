"""One root seed, named generators drawn from it, and what they draw; none of them is global."""

from __future__ import annotations

import zlib

import numpy as np


def seed_for(root_seed: int, *names: str | int) -> int:
    """Return a 63-bit seed that depends on `root_seed` and on every name, in order."""
    keys = [zlib.crc32(str(name).encode()) for name in names]
    sequence = np.random.SeedSequence(root_seed, spawn_key=keys)
    return int(sequence.generate_state(1, np.uint64)[0] >> 1)


def generator_for(root_seed: int, *names: str | int) -> np.random.Generator:
    """Return the random generator that belongs to `names` under `root_seed`."""
    return np.random.default_rng(seed_for(root_seed, *names))


def log_uniform(rng: np.random.Generator, span: tuple[float, float]) -> float:
    """Return a number between two positive ones, drawn evenly on a log scale."""
    return float(np.exp(rng.uniform(*np.log(span))))
