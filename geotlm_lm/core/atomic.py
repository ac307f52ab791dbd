"""Files that appear whole or not at all, by one writer; knows nothing of what is in them."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO


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
    """Yield whether no other process is in such a block about `path`.

    A lock file beside it says so while the block runs; the system forgets the lock with the
    process, however that ends. Where files cannot be locked, everybody is told to be the only one.
    """
    from filelock import FileLock, Timeout

    path.parent.mkdir(parents=True, exist_ok=True)
    lock = FileLock(path.with_name(f".{path.name}.lock"))
    try:
        lock.acquire(blocking=False)
    except Timeout:
        yield False
        return
    except OSError:  # a file system without locks, or where nothing may be written
        yield True
        return
    try:
        yield True
    finally:
        with suppress(OSError):  # Windows removes no open file
            os.unlink(lock.lock_file)
        lock.release()


def write_text_atomically(path: Path, text: str) -> None:
    """Write `text` in UTF-8 so that a reader sees the old file or the new one."""
    with replacing(path) as stream:
        stream.write(text.encode())
