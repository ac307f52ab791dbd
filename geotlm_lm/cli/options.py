"""Options that several commands share, and the checks of what they name; imports nothing heavy."""

from __future__ import annotations

import shlex
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer
from typer.models import OptionInfo

from geotlm_lm.core.errors import UsageError


def path_of(text: str) -> Path:
    """Return the path that was typed; none is empty, as an unset variable of a script is.

    `Path` takes that for the current folder.
    """
    if not text:
        raise UsageError("An empty path was given, expected a file's or a folder's; give it.")
    return Path(text)


def path_option(*names: str, help: str) -> OptionInfo:
    """Return an option that takes a path; all of the commands do so by this one."""
    return typer.Option(*names, parser=path_of, metavar="<path>", help=help)


SquarePixels = Annotated[
    bool | None,
    typer.Option(
        "--square-pixels",
        help="The camera's picture is square: frames of 224x224 are else taken for a 4:3 picture "
        "squashed to a square.",
    ),
]
BundleFolder = Annotated[
    Path | None, path_option(help="Folder of a model bundle. [default: the one shipped]")
]
RealFolder = Annotated[
    Path | None, path_option(help="Folder of labelled recordings to add; see `evaluate`.")
]
DataSets = Annotated[
    list[Path] | None,
    path_option(
        "--data",
        help="TactileTracking's folder, or a manifest of clips such as ToucHD-Sim's, to add; "
        "may be given again.",
    ),
]
CameraName = Annotated[
    str | None,
    typer.Option(
        "--camera", help="Of a LeRobot data set: the touch sensor's. [default: the only one]"
    ),
]
ClusterAddress = Annotated[
    str | None,
    typer.Option(
        "--cluster",
        metavar="ADDRESS",
        help="Work on a Ray cluster: the address of its head, auto inside `ray job submit`, or "
        "local to start one here. [default: processes of this machine]",
    ),
]
Force = Annotated[
    bool, typer.Option("--force", help="Replace the file, if there is one of its name already.")
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object as the last line instead of words.")
]
Seed = Annotated[
    int, typer.Option("--seed", min=0, help="Root seed; the same seed, the same result.")
]


def require_writable(folder: Path, option: str) -> None:
    """Try to write in `folder`, so that a place where it fails is told before the work is done.

    One that is not there yet is left to whoever writes in it: a run that is refused after this
    leaves none behind. What is tried is the nearest folder above it.

    Raises:
        UsageError: If it cannot be created or written to.
    """
    try:
        tempfile.TemporaryFile(dir=_nearest_there(folder)).close()
    except OSError as error:
        raise UsageError(
            f"{option}: nothing can be written in the folder {folder} ({error.strerror}); give "
            f"another place."
        ) from error


def _nearest_there(folder: Path) -> Path:
    for part in (folder, *folder.parents):
        try:
            part.lstat()
        except FileNotFoundError:
            continue
        return part
    return folder


def require_writable_file(path: Path, option: str, *, inputs: Iterable[Path] = ()) -> None:
    """Try to write in the folder of `path`, for the same reason and as `require_writable`.

    Raises:
        UsageError: If the file cannot be written there, or is one of the inputs (files, and
            folders of images, that the command reads).
    """
    if path.is_dir():
        raise UsageError(f"{option}: {path} is a folder, expected the name of a file.")
    if path.exists() and not path.is_file():  # as /dev/null, which root could replace
        raise UsageError(f"{option}: {path} is no regular file, expected the name of one.")
    for source in inputs:
        if _is_of(path, source):
            raise UsageError(
                f"{option}: {path} is read by this command and would be replaced, expected the "
                f"name of another file; give one."
            )
    require_writable(path.parent, option)


def require_new_file(
    path: Path, option: str, *, is_forced: bool, inputs: Iterable[Path] = ()
) -> None:
    """Refuse to replace a file unless --force was given; else as `require_writable_file`."""
    require_writable_file(path, option, inputs=inputs)
    # A link that leads nowhere would be replaced, or followed, as well.
    if not is_forced and (path.exists() or path.is_symlink()):
        raise UsageError(
            f"{option}: {path} is there already and would be replaced, expected a new name; give "
            f"one, or --force to replace the file."
        )


def _is_of(path: Path, read: Path) -> bool:
    """Tell whether `path` is the file `read`, or an image of the folder `read`."""
    try:
        if path.samefile(read):
            return True
        if not path.parent.samefile(read):
            return False
    except OSError:  # one of them is not there
        return False
    from geotlm_lm.recordings.images import IMAGE_SUFFIXES

    return path.suffix.lower() in IMAGE_SUFFIXES


def command_line() -> str:
    """Return the command as a user would type it, whatever started the interpreter."""
    return shlex.join(["geotlm-lm", *sys.argv[1:]])


def require_record_file(path: Path, option: str, *, inputs: Iterable[Path] = ()) -> None:
    """As `require_writable_file`; of files that are there, only an earlier record is replaced.

    Args:
        path: Of the record to write.
        option: That names it.
        inputs: Files that the command reads.

    Raises:
        UsageError: If it cannot be written, or holds something else.
    """
    from geotlm_lm.core.record import RunRecord, UnreadableRecord

    require_writable_file(path, option, inputs=inputs)
    if not path.exists() or path.stat().st_size == 0:
        return
    try:
        RunRecord.load(path)
    except UnreadableRecord as error:
        raise UsageError(
            f"{option}: {path} holds something else than a run's record and would be replaced, "
            f"expected a new file or an earlier record; give another name."
        ) from error
