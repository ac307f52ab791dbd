"""Options that several commands share, and the checks of what they name; imports nothing heavy."""

from __future__ import annotations

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
EncoderName = Annotated[
    str | None,
    typer.Option(
        "--encoder",
        help="Released encoder: anytouch2, anytouch1, sparsh, t3, internvit or unit. [default: "
        "recognised by the file]",
    ),
]
EncoderWeights = Annotated[
    Path | None,
    path_option("--weights", help="The file the encoder's authors release; see docs/encoders.md."),
]
EncoderHeads = Annotated[
    int | None,
    typer.Option(
        "--heads", min=1, help="Attention heads of the encoder. [default: those of its width]"
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


def require_one_model(
    model: Path | None, weights: Path | None, encoder: str | None, heads: int | None
) -> None:
    """Refuse an encoder without a file, or beside a bundle."""
    if weights is None and (encoder is not None or heads is not None):
        raise UsageError("--encoder and --heads need --weights with the encoder's file.")
    if weights is not None and model is not None:
        raise UsageError("--model and --weights exclude each other: give one of them.")


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
