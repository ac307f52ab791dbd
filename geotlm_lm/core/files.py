"""Files of this package, names that every library opens, and the one writer of files."""

from __future__ import annotations

import io
import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from geotlm_lm.core.errors import MissingDependency, Unwritten

_PACKAGE = Path(__file__).resolve().parent.parent


def resource_dir(name: str) -> Path:
    """Return the folder `name` (prompts, data_templates, app, bundle).

    A wheel carries the folders inside the package; a checkout keeps the user's layout beside it.
    """
    for parent in (_PACKAGE, _PACKAGE.parent):
        if (parent / name).is_dir():
            return parent / name
    raise FileNotFoundError(f"geotlm_lm was installed without its folder '{name}'")


def training_templates() -> Path:
    """Return the folder of wordings that language models are trained and judged on.

    An installed package holds only what answering reads.
    """
    folder = resource_dir("data_templates")
    if not (folder / "query" / "lexicon.toml").is_file():
        raise MissingDependency(
            "The wordings that training reads are part of the repository, not of the installed "
            "package; run this from a checkout."
        )
    return folder


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


@contextmanager
def replacing(path: Path) -> Iterator[IO[bytes]]:
    """Yield a stream whose content takes the place of `path` once the block ends without error.

    A reader sees the old file or the new one, never half of it, and so does one after a power cut;
    an error leaves the old one. Who may read it is the umask's to say.

    Raises:
        Unwritten: If it cannot be written.
    """
    with replacing_by_name(path) as temporary:
        with _told_of(path):
            raw = _Raw(temporary, "wb")
        try:
            with io.BufferedWriter(raw) as stream:
                yield stream
        finally:  # a library tells in words of its own, or not at all, what hindered it
            if raw.failure is not None:
                with _told_of(path):
                    raise raw.failure


@contextmanager
def replacing_by_name(path: Path) -> Iterator[Path]:
    """Yield an empty file's name for what opens its files itself; else as `replacing`.

    It ends as `path` does: the ending tells some writers what to write. A block that removes the
    file leaves the old one.
    """
    token = f"{os.getpid()}-{os.urandom(4).hex()}"  # the rest is cut: a name has its longest
    temporary = path.with_name(f".{path.stem[:40]}.{token}{path.suffix[-10:]}")
    try:
        with _told_of(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        yield temporary
        if temporary.exists():
            with _told_of(path):
                _sync(temporary, os.O_RDWR)
            move_into_place(temporary, path)
    except BaseException:
        with suppress(OSError):  # a folder that is gone, or that takes no more
            temporary.unlink()
        raise


def move_into_place(temporary: Path, path: Path) -> None:
    """Let a file or a folder, whose content is on disk, take the place of `path`, kept as such."""
    with _told_of(path):
        os.replace(temporary, path)
    with suppress(OSError):  # Windows opens no folder, and some file systems sync none
        _sync(path.parent, os.O_RDONLY)


def append_text(path: Path, text: str) -> None:
    """Add `text` in UTF-8 to the end of a file, all of it or, on an error, nothing."""
    with _told_of(path), path.open("ab", buffering=0) as stream:
        end, rest = stream.tell(), memoryview(text.encode())
        try:
            while rest:
                rest = rest[stream.write(rest) :]
        except OSError:
            stream.truncate(end)
            raise


def reserve(path: Path) -> None:
    """Have the disk keep room for all of a file, before a part that is mapped is written."""
    with _told_of(path), path.open("r+b") as stream:
        if hasattr(os, "posix_fallocate"):  # elsewhere a full disk ends the process
            os.posix_fallocate(stream.fileno(), 0, os.fstat(stream.fileno()).st_size)


@contextmanager
def only_writer(path: Path) -> Iterator[bool]:
    """Yield whether no other process is in such a block about `path`.

    A lock file beside it says so while the block runs; the system forgets the lock with the
    process, however that ends. Where files cannot be locked, everybody is told to be the only one.

    Raises:
        Unwritten: If its folder cannot be made.
    """
    from filelock import FileLock, Timeout

    with _told_of(path):
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


class _Raw(io.FileIO):
    """A file that keeps why it could not be written."""

    failure: OSError | None = None

    def write(self, data: Any) -> int | None:
        try:
            return super().write(data)
        except OSError as error:
            self.failure = self.failure or error
            raise


@contextmanager
def _told_of(path: Path) -> Iterator[None]:
    """Tell an error of the system as one about writing `path`; others' errors pass."""
    try:
        yield
    except OSError as error:
        raise Unwritten(
            f"{path}: cannot be written ({error.strerror or error}); make room, or give another "
            f"place."
        ) from error


def _sync(path: Path, flags: int) -> None:
    handle = os.open(path, flags)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
