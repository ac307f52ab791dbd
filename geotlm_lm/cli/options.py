"""Options of the commands, how they are declared, and the checks of what they name.

What several commands share is declared once: an option as an annotation, options that go together
as a dataclass, which is taken whole. Imports nothing heavy.
"""

from __future__ import annotations

import shlex
import sys
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import Field, dataclass, field, fields, is_dataclass, replace
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_type_hints

import typer

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer
    from geotlm_lm.core.clip import Clip
    from geotlm_lm.data_sets.lerobot import LeRobotDataSet

ENDINGS = {
    "out": (".csv", ".parquet", ".json"),
    "plot": (".png", ".svg", ".pdf"),
    "video": (".mp4",),
    "rerun": (".rrd",),
}


def path_of(text: str) -> Path:
    """Return the path that was typed; none is empty, as an unset variable of a script is.

    `Path` takes that for the current folder.
    """
    if not text:
        raise UsageError("An empty path was given, expected a file's or a folder's; give it.")
    return Path(text)


def option(help: str, *names: str, default: Any = None, **more: Any) -> Any:
    """Declare an option of a command, or of a dataclass of options, that `grouped` reads.

    Args:
        help: What it is.
        names: That it is given by; none for the parameter's own.
        default: Its value where it is not given; without one, and of a type that takes no None, it
            must be.
        more: As of `typer.Option`. A path gets its parser and its metavar by itself.
    """
    return field(default=default, metadata={"help": help, "names": names} | more)


def argument(metavar: str, help: str, alias: str = "") -> Any:
    """Declare what is given without an option; `alias` is a hidden option for it, if any."""
    return field(default=None, metadata={"metavar": metavar, "help": help, "alias": alias})


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command whose parameters are declared by `option`, `argument` and dataclasses.

    A dataclass's fields are options in its place, and it is given whole. The command takes all by
    keyword.
    """
    groups, aliases, parameters = {}, {}, []
    hints = get_type_hints(command, include_extras=True)
    for parameter in signature(command).parameters.values():
        declared = [(parameter.name, hints[parameter.name], parameter.default)]
        if is_dataclass(hints[parameter.name]):
            group = groups[parameter.name] = hints[parameter.name]
            own = get_type_hints(group, include_extras=True)
            declared = [(field.name, own[field.name], field) for field in fields(group)]
        for name, hint, about in declared:
            default = about.default if isinstance(about, Field) else about
            kind, about = get_args(hint) if hasattr(hint, "__metadata__") else (hint, about)
            if default is None and NoneType not in get_args(kind):
                default = Parameter.empty
            if alias := about.metadata.get("alias"):
                aliases[name] = (about.metadata["metavar"], alias, default is Parameter.empty)
                kind, default = kind | None, None
            for key, info in _declared(name, kind, dict(about.metadata)).items():
                annotation = Annotated[kind, info]
                parameters.append(Parameter(key, Parameter.KEYWORD_ONLY, default=default,
                                            annotation=annotation))  # fmt: skip

    @wraps(command)
    def call(**values: Any) -> None:
        for name, (metavar, alias, is_required) in aliases.items():
            by_option = values.pop(f"{name}_by_option")
            if by_option is not None and values[name] is not None:
                raise UsageError(f"{metavar} and {alias} are the same: give one of them.")
            values[name] = values[name] if by_option is None else by_option
            if is_required and values[name] is None:
                raise missing(metavar)
        for name, group in groups.items():
            values[name] = group(**{field.name: values.pop(field.name) for field in fields(group)})
        command(**values)

    call.__signature__ = Signature(parameters)
    call.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return call


def _declared(name: str, kind: Any, about: dict[str, Any]) -> dict[str, Any]:
    """Return how Typer declares an option, or an argument and the option that stands for it."""
    is_path = kind is Path or Path in get_args(kind) or list[Path] in get_args(kind)
    parsed = {"parser": path_of} if is_path else {}
    if "alias" not in about:
        shown = {"metavar": "<path>"} if is_path else {}
        return {name: typer.Option(*about.pop("names"), **shown, **parsed, **about)}
    alias = about.pop("alias")
    same = typer.Option(alias, hidden=True, help="The same.", **parsed)
    declared = {name: typer.Argument(**about, **parsed)}
    return declared | ({f"{name}_by_option": same} if alias else {})


def missing(metavar: str) -> UsageError:
    """Return the error of a call without one of its arguments."""
    return UsageError(f"Missing argument '{metavar}'; see `geotlm-lm --help`.")


SquarePixels = Annotated[
    bool | None,
    option(
        "The camera's picture is square: frames of 224x224 are else taken for a 4:3 picture "
        "squashed to a square.",
        "--square-pixels",
    ),
]
BundleFolder = Annotated[
    Path | None, option("Folder of a model bundle. [default: the one shipped]")
]
DataSets = Annotated[
    list[Path] | None,
    option(
        "TactileTracking's folder, or a manifest of clips such as ToucHD-Sim's, to add; may be "
        "given again.",
        "--data",
    ),
]
CameraName = Annotated[
    str | None,
    option("Of a LeRobot data set: the touch sensor's. [default: the only one]", "--camera"),
]
ClusterAddress = Annotated[
    str | None,
    option(
        "Work on a Ray cluster: the address of its head, auto inside `ray job submit`, or local to "
        "start one here. [default: processes of this machine]",
        "--cluster",
        metavar="ADDRESS",
    ),
]
Force = Annotated[bool, option("Replace the file, if there is one of its name already.", "--force")]
AsJson = Annotated[
    bool, option("Print one JSON object as the last line instead of words.", "--json")
]
Seed = Annotated[int, option("Root seed; the same seed, the same result.", "--seed", min=0)]


@dataclass(frozen=True)
class Pixels:
    """How the frames of a recording or a camera are read."""

    layout: str | None = option(
        "Axes of an array, THWC, TCHW or THW (grey); BGR, or THWC-BGR, where OpenCV gave its "
        "colours. [default: axes by the shape, red first]"
    )
    fps: float | None = option("Frames per second. [default: what the file says]")
    square_pixels: SquarePixels = None
    topic: str | None = option("Topic of a bag's images. [default: the only one that has images]")


@dataclass(frozen=True)
class Reading(Pixels):
    """How a recording is read: options of `read_clip`, by their names."""

    background: Path | None = option(
        "Image or .npy of the untouched gel. [default: from the recording, else estimated]"
    )


@dataclass(frozen=True)
class Recording(Reading):
    """A recording, or an episode of a LeRobot data set."""

    file: Path | None = argument(
        "FILE",
        "Recording: .npy, .npz, a video, a .gif, a .tif of several pages, a bag of ROS (.mcap, "
        ".db3, .bag, or its folder), a folder of images, or a LeRobot data set.",
        "--clip",
    )
    frames: str | None = option(
        "Frames to track inside, both included, counted from 0. [default: the whole recording]",
        metavar="FIRST:LAST",
    )
    episode: int | None = option("Of a LeRobot data set: which one. [default: 0]", min=0)
    camera: CameraName = None

    @property
    def path(self) -> Path:
        """The file or folder, which must be given."""
        if self.file is None:
            raise missing("FILE")
        return self.file

    @property
    def span(self) -> tuple[int, int] | None:
        """FIRST and LAST of --frames; None when not given."""
        if self.frames is None:
            return None
        first, _, last = self.frames.partition(":")
        if not all(number.isdecimal() and len(number) < 10 for number in (first, last)):
            raise UsageError(
                f"--frames '{self.frames[:40]}' was given, expected FIRST:LAST such as 40:60."
            )
        return int(first), int(last)

    @property
    def reading(self) -> Reading:
        """How it is read."""
        return Reading(**{field.name: getattr(self, field.name) for field in fields(Reading)})

    def read(self) -> Clip:
        """Read it.

        Raises:
            UsageError: If the episode or the camera is not there, or is given of a recording.
            UnreadableClip: If it cannot be read.
            MissingDependency: If a package that reads a data set is not installed.
        """
        from geotlm_lm.data_sets.lerobot import is_data_set
        from geotlm_lm.recordings.read import read_clip

        if is_data_set(self.path):
            return self._read_episode()
        if self.episode is not None or self.camera is not None:
            raise UsageError(
                f"--episode and --camera are of a LeRobot data set, and {self.path} is none; leave "
                f"them out."
            )
        return read_clip(self.path, **vars(self.reading))

    def _read_episode(self) -> Clip:
        from geotlm_lm.data_sets.lerobot import StoredEpisode, read_data_set
        from geotlm_lm.recordings.pixels import check_layout
        from geotlm_lm.recordings.read import read_background, require_rate

        if self.topic is not None:
            raise UsageError(
                f"--topic is of a bag, and {self.path} is a data set; give --camera instead."
            )
        layout = check_layout(self.layout)
        require_rate(self.fps)
        data_set = read_data_set(self.path)
        episode, camera = data_set.episode(self.episode or 0), touch_camera(data_set, self.camera)
        clip = StoredEpisode(data_set, episode, camera, self.fps, self.square_pixels).read()
        if layout is not None:
            clip = clip.with_note(f"The layout {layout} is not used: only arrays have one to tell.")
        if self.background is None:
            return clip
        return replace(clip, background=read_background(self.background))


def touch_camera(data_set: LeRobotDataSet, camera: str | None) -> str:
    """Return the camera that was named, which must be there; the only one where none was."""
    if camera is None:
        if len(data_set.cameras) != 1:
            raise UsageError(
                f"{data_set.root}: has {len(data_set.cameras)} cameras: "
                f"{', '.join(data_set.cameras)}; give the touch sensor's by --camera."
            )
        camera = data_set.cameras[0]
    data_set.require_camera(camera)
    return camera


@dataclass(frozen=True)
class Answering:
    """Which model answers, and in which unit of length."""

    mm_per_px: float | None = option(
        "Width on the gel of a pixel of the recording, in mm: slides are then told in mm. "
        "[default: told in pixels]"
    )
    model: BundleFolder = None

    @property
    def frame(self) -> FrameSpec:
        """The frame that answers are told in."""
        return FrameSpec(mm_per_px=self.mm_per_px)

    def load(self) -> Answerer:
        """Load the model; its libraries only now, so that a wrong path need not wait for them."""
        from geotlm_lm.answering import Answerer

        return Answerer.load(self.model)


@dataclass(frozen=True)
class Encoder:
    """A released encoder's file."""

    encoder: str | None = option(
        "Released encoder: anytouch2, anytouch1, sparsh, t3, internvit or unit. [default: "
        "recognised by the file]"
    )
    weights: Path | None = option("The file the encoder's authors release; see docs/encoders.md.")
    heads: int | None = option(
        "Attention heads of the encoder. [default: those of its width]", min=1
    )

    def require_alone(self, model: Path | None) -> None:
        """Refuse an encoder without a file, or beside a bundle."""
        if self.weights is None and (self.encoder is not None or self.heads is not None):
            raise UsageError("--encoder and --heads need --weights with the encoder's file.")
        if self.weights is not None and model is not None:
            raise UsageError("--model and --weights exclude each other: give one of them.")


@dataclass(frozen=True)
class Outputs:
    """Files that a command may write beside what it prints."""

    force: Force = False

    def require(self, inputs: Iterable[Path]) -> None:
        """Refuse files that cannot be written, before any work is done for them.

        Raises:
            UsageError: If a name ends otherwise than it must, or is there already.
            MissingDependency: If a package that writes one is not installed.
        """
        given = {name: path for name in ENDINGS if (path := getattr(self, name, None)) is not None}
        if self.force and not given:
            raise UsageError(
                "--force lets --out and other options replace files; give one of them, or leave it "
                "out."
            )
        if not given:
            return
        from geotlm_lm.track.export import SERVE, require_packages

        for name, path in given.items():
            is_served = name == "rerun" and path == SERVE
            if path.suffix not in ENDINGS[name] and not is_served:
                endings = " or ".join(ENDINGS[name])
                raise UsageError(
                    f"--{name} {path} was given, expected a name that ends in {endings}."
                )
            require_packages(path)
            if not is_served:
                require_new_file(path, f"--{name}", is_forced=self.force, inputs=inputs)


@dataclass(frozen=True)
class RerunOutput(Outputs):
    """A file for the Rerun viewer."""

    rerun: Path | None = option(
        "Write frames, arrows, curves and events for the Rerun viewer to this .rrd; `serve` shows "
        "them in a browser instead."
    )


@dataclass(frozen=True)
class TrackOutputs(Outputs):
    """Files of a track."""

    out: Path | None = option("Write a row for every frame to this .csv, .parquet or .json file.")
    plot: Path | None = option(
        "Draw turn, slide, depth, contact and grip over time to this .png, .svg or .pdf."
    )
    video: Path | None = option("Write the frames, with what was tracked, to this .mp4.")


@dataclass(frozen=True)
class AllOutputs(TrackOutputs, RerunOutput):
    """All of them."""


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
