"""One thing that is fuzzed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Target:
    """How a thing is given inputs, and where they start from.

    Args:
        seeds: Lawful inputs.
        run: Takes an input; raises `GeoTLMError` where it refuses it, and nothing else.
        words: Of the inputs' language.
    """

    seeds: tuple[bytes, ...]
    run: Callable[[bytes], object]
    words: tuple[bytes, ...] = ()


Prepare = Callable[[Path], Target]
"""Makes a target in the process that runs it, given an empty folder; itself sent by its name."""
