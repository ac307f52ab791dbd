"""Where a server keeps what is uploaded and drawn: a folder of its own, gone when the server is."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows: folders of servers that died stay
    fcntl = None

PREFIX = "geotlm-lm-app-"
LOCK = ".in-use"
VARIABLE = "GRADIO_TEMP_DIR"
"""Where the toolkit reads its folder from, as long as it serves."""


@contextmanager
def own_cache_folder(parent: Path | None = None) -> Iterator[Path]:
    """Give this process a folder for uploads and pictures, and remove it in the end.

    Folders of servers that died are removed first. A folder is in use while its lock is held, which
    ends with the process that holds it, however it ends.

    Args:
        parent: Of the folders; None for the system's temporary one.
    """
    parent = Path(tempfile.gettempdir()) if parent is None else parent
    remove_abandoned(parent)
    folder = Path(tempfile.mkdtemp(prefix=PREFIX, dir=parent))  # for this user alone
    lock = _held(folder)
    before = os.environ.get(VARIABLE)
    os.environ[VARIABLE] = str(folder)
    try:
        yield folder
    finally:
        if before is None:
            del os.environ[VARIABLE]
        else:
            os.environ[VARIABLE] = before
        _remove(folder)
        if lock is not None:
            os.close(lock)


def remove_abandoned(parent: Path) -> None:
    """Remove the folders of servers that are no longer there; a live one's is never touched."""
    if fcntl is None:
        return
    for folder in parent.glob(f"{PREFIX}*"):
        try:
            if folder.is_symlink() or folder.stat().st_uid != os.getuid():
                continue
            # A folder that has no lock yet is just being made.
            lock = os.open(folder / LOCK, os.O_RDWR | os.O_NOFOLLOW)
        except OSError:
            continue
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            _remove(folder)
        except OSError:  # in use
            pass
        finally:
            os.close(lock)


def _held(folder: Path) -> int | None:
    """Return the lock of a folder, held before it is there for others to see."""
    if fcntl is None:
        return None
    part = folder / f"{LOCK}.part"
    lock = os.open(part, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
    fcntl.flock(lock, fcntl.LOCK_EX)
    part.rename(folder / LOCK)
    return lock


def _remove(folder: Path) -> None:
    """Remove a folder, its lock last: cut off half way, the rest is still known as abandoned."""
    for one in folder.iterdir():
        if one.name != LOCK:
            shutil.rmtree(one, ignore_errors=True) if one.is_dir() else one.unlink()
    (folder / LOCK).unlink(missing_ok=True)
    shutil.rmtree(folder, ignore_errors=True)
