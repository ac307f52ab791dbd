"""Files that appear whole or not at all, by one writer; knows nothing of what is in them."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None


@contextmanager
def replacing(path: Path) -> Iterator[IO[bytes]]:
    """Yield a stream whose content takes the place of `path` once the block ends without error.

    A reader sees the old file or the new one, never half of it; an error leaves the old one.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as stream:
            yield stream
        os.chmod(temporary, 0o644)  # mkstemp lets only the owner read
        os.replace(temporary, path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


@contextmanager
def only_writer(path: Path) -> Iterator[bool]:
    """Yield whether no other process is in such a block about `path`, made if missing.

    The system forgets the claim with the process, however that ends. Where it has no such claims,
    everybody is told to be the only one.
    """
    if fcntl is None:
        yield True
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    while True:
        with path.open("ab") as stream:
            try:
                fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                yield False
                return
            except OSError:  # a file system without claims
                pass
            if _is_still(stream, path):  # else the one before has just taken it away
                yield True
                return


def _is_still(stream: IO[bytes], path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(stream.fileno()), path.stat())
    except FileNotFoundError:
        return False


def write_text_atomically(path: Path, text: str) -> None:
    """Write `text` in UTF-8 so that a reader sees the old file or the new one."""
    with replacing(path) as stream:
        stream.write(text.encode())
