"""How many processes a command has started."""

from contextlib import suppress
from pathlib import Path

import pytest

in_proc = pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="looks for a command's workers in /proc"
)


def members(group: int) -> int:
    """Return how many processes a group has: a command, its resource tracker, its workers."""
    count = 0
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # it has ended meanwhile
            count += int(path.read_text().rpartition(")")[2].split()[2]) == group
    return count
