"""Options that go together, declared once as dataclasses and taken whole by several commands."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_type_hints

import typer

from geotlm_lm.cli.options import (
    BundleFolder,
    CameraName,
    Force,
    SquarePixels,
    path_of,
    path_option,
    require_new_file,
)
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer
    from geotlm_lm.core.clip import Clip
    from geotlm_lm.data_sets.lerobot import LeRobotDataSet

ENDINGS = {
    "out": (".csv", ".parquet", ".json"),
    "plot": (".png",),
    "video": (".mp4",),
    "rerun": (".rrd",),
}


@dataclass(frozen=True)
class Positional:
    """Marks a parameter that is given without an option; `alias` is a hidden option for it."""

    alias: str
    metavar: str
    help: str


@dataclass(frozen=True)
class Pixels:
    """How the frames of a recording or a camera are read."""

    layout: Annotated[
        str | None,
        typer.Option(
            help="Axes of an array, THWC, TCHW or THW (grey); BGR, or THWC-BGR, where OpenCV gave "
            "its colours. [default: guessed, stated]"
        ),
    ] = None
    fps: Annotated[
        float | None, typer.Option(help="Frames per second. [default: what the file says]")
    ] = None
    square_pixels: SquarePixels = None
    topic: Annotated[
        str | None,
        typer.Option(help="Topic of a bag's images. [default: the only one that has images]"),
    ] = None


@dataclass(frozen=True)
class Reading(Pixels):
    """How a recording is read: options of `read_clip`, by their names."""

    background: Annotated[
        Path | None,
        path_option(
            help="Image or .npy of the untouched gel. [default: from the recording, else estimated]"
        ),
    ] = None


@dataclass(frozen=True)
class Recording(Reading):
    """A recording, or an episode of a LeRobot data set."""

    file: Annotated[
        Path | None,
        Positional(
            "--clip",
            "FILE",
            help="Recording: .npy, .npz, a video, a .gif, a .tif of several pages, a bag of ROS "
            "(.mcap, .db3, .bag, or its folder), a folder of images, or a LeRobot data set.",
        ),
    ] = None
    frames: Annotated[
        str | None,
        typer.Option(
            metavar="FIRST:LAST",
            help="Frames to track inside, both included, counted from 0. [default: the whole "
            "recording]",
        ),
    ] = None
    episode: Annotated[
        int | None, typer.Option(min=0, help="Of a LeRobot data set: which one. [default: 0]")
    ] = None
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

    mm_per_px: Annotated[
        float | None,
        typer.Option(
            help="Width on the gel of a pixel of the recording, in mm: slides are then told in mm. "
            "[default: told in pixels]"
        ),
    ] = None
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

    encoder: Annotated[
        str | None,
        typer.Option(
            help="Released encoder: anytouch2, anytouch1, sparsh, t3, internvit or unit. "
            "[default: recognised by the file]"
        ),
    ] = None
    weights: Annotated[
        Path | None,
        path_option(help="The file the encoder's authors release; see docs/encoders.md."),
    ] = None
    heads: Annotated[
        int | None,
        typer.Option(min=1, help="Attention heads of the encoder. [default: those of its width]"),
    ] = None

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

    rerun: Annotated[
        Path | None,
        path_option(
            help="Write frames, arrows, curves and events for the Rerun viewer to this .rrd; "
            "`serve` shows them in a browser instead."
        ),
    ] = None


@dataclass(frozen=True)
class TrackOutputs(Outputs):
    """Files of a track."""

    out: Annotated[
        Path | None,
        path_option(help="Write a row for every frame to this .csv, .parquet or .json file."),
    ] = None
    plot: Annotated[
        Path | None, path_option(help="Draw turn, travel and contact over time to this .png.")
    ] = None
    video: Annotated[
        Path | None, path_option(help="Write the frames, with what was tracked, to this .mp4.")
    ] = None


@dataclass(frozen=True)
class AllOutputs(TrackOutputs, RerunOutput):
    """All of them."""


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command with the fields of its dataclasses as options in their place.

    A parameter marked `Positional` is given without an option, or by its alias. The command takes
    all by keyword; what is annotated with a dataclass is given whole.
    """
    groups, aliases, parameters = {}, {}, []
    hints = get_type_hints(command, include_extras=True)
    for parameter in signature(command).parameters.values():
        declared = [(parameter.name, hints[parameter.name], parameter.default)]
        if is_dataclass(hints[parameter.name]):
            group = groups[parameter.name] = hints[parameter.name]
            own = get_type_hints(group, include_extras=True)
            declared = [(field.name, own[field.name], field.default) for field in fields(group)]
        for name, hint, default in declared:
            kind, *marks = get_args(hint) if hasattr(hint, "__metadata__") else (hint,)
            if marks and isinstance(marks[0], Positional):
                mark, parser = marks[0], str if kind in (str, str | None) else path_of
                aliases[name] = (mark, default is Parameter.empty)
                argument = typer.Argument(parser=parser, metavar=mark.metavar, help=mark.help)
                same = typer.Option(mark.alias, parser=parser, hidden=True, help="The same.")
                both = {name: argument, f"{name}_by_option": same}
                hints_of = {key: Annotated[kind | None, info] for key, info in both.items()}
            else:
                hints_of = {name: hint}
            parameters += [
                Parameter(key, Parameter.KEYWORD_ONLY, annotation=annotation,
                          default=None if key in aliases or len(hints_of) > 1 else default)
                for key, annotation in hints_of.items()
            ]  # fmt: skip

    @wraps(command)
    def call(**values: Any) -> None:
        for name, (mark, is_required) in aliases.items():
            by_option = values.pop(f"{name}_by_option")
            if by_option is not None and values[name] is not None:
                raise UsageError(f"{mark.metavar} and {mark.alias} are the same: give one of them.")
            values[name] = values[name] if by_option is None else by_option
            if is_required and values[name] is None:
                raise missing(mark.metavar)
        for name, group in groups.items():
            values[name] = group(**{field.name: values.pop(field.name) for field in fields(group)})
        command(**values)

    call.__signature__ = Signature(parameters)
    call.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return call


def missing(metavar: str) -> UsageError:
    """Return the error of a call without one of its arguments."""
    return UsageError(f"Missing argument '{metavar}'; see `geotlm-lm --help`.")
