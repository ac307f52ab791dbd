"""Names of files for C libraries, some of which crash on names that are not UTF-8."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def plain_name(path: Path) -> Iterator[str]:
    """Yield an absolute name of a file or a folder that any library opens.

    A name that is not UTF-8, or that could be read as a part of a URI, is reached by a symbolic
    link in a temporary folder, which keeps the ending. What is written to it appears at `path`.
    """
    # Absolute, as decoders take what is before the colon of `12:30.mp4` for a protocol.
    absolute = os.path.abspath(path)
    if is_plain(absolute):
        yield absolute
        return
    with tempfile.TemporaryDirectory(prefix="geotlm-") as home:
        link = Path(home, f"file{path.suffix if is_plain(path.suffix) else ''}")
        link.symlink_to(absolute)
        yield str(link)


def is_plain(name: str) -> bool:
    """Tell whether any library takes a name for what it is."""
    # Python keeps bytes that are no UTF-8 as surrogates.
    return re.search("[\ud800-\udfff?#%]", name) is None
