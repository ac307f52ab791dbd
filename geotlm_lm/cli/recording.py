"""What commands read: a recording, or one episode of a LeRobot data set."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from geotlm_lm.core.errors import UsageError

if TYPE_CHECKING:
    from geotlm_lm.cli.grouped import Reading
    from geotlm_lm.core.clip import Clip
    from geotlm_lm.data_sets.lerobot import LeRobotDataSet

EpisodeNumber = Annotated[
    int | None,
    typer.Option("--episode", min=0, help="Of a LeRobot data set: which one. [default: 0]"),
]
CameraName = Annotated[
    str | None,
    typer.Option(
        "--camera", help="Of a LeRobot data set: the touch sensor's. [default: the only one]"
    ),
]


def read_recording(path: Path, episode: int | None, camera: str | None, reading: Reading) -> Clip:
    """Return the recording at `path`, or an episode of the data set there.

    Args:
        path: Of a recording, or the folder of a LeRobot data set.
        episode: Number of the episode; None takes the first.
        camera: Name of its camera; None takes the only one.
        reading: How it is read.

    Raises:
        UsageError: If the episode or the camera is not there, or is given of a recording.
        UnreadableClip: If it cannot be read.
        MissingDependency: If a package that reads a data set is not installed.
    """
    from geotlm_lm.data_sets.lerobot import is_data_set
    from geotlm_lm.recordings.read import read_clip

    if is_data_set(path):
        return _episode(path, episode or 0, camera, reading)
    if episode is not None or camera is not None:
        raise UsageError(
            f"--episode and --camera are of a LeRobot data set, and {path} is none; leave them out."
        )
    return read_clip(path, **vars(reading))


def _episode(root: Path, episode: int, camera: str | None, reading: Reading) -> Clip:
    from geotlm_lm.data_sets.lerobot import StoredEpisode, read_data_set
    from geotlm_lm.recordings.pixels import check_layout
    from geotlm_lm.recordings.read import read_background, require_rate

    if reading.topic is not None:
        raise UsageError(f"--topic is of a bag, and {root} is a data set; give --camera instead.")
    checked, background = check_layout(reading.layout), reading.background
    require_rate(reading.fps)
    data_set = read_data_set(root)
    found, camera = data_set.episode(episode), touch_camera(data_set, camera)
    clip = StoredEpisode(data_set, found, camera, reading.fps, reading.square_pixels).read()
    if checked is not None:
        clip = clip.with_note(f"The layout {checked} is not used: only arrays have one to tell.")
    return clip if background is None else replace(clip, background=read_background(background))


def touch_camera(data_set: LeRobotDataSet, camera: str | None) -> str:
    """Return the camera that was named; the only one where none was.

    Raises:
        UsageError: If there is no such camera, or none was named of several.
    """
    if camera is None:
        if len(data_set.cameras) != 1:
            raise UsageError(
                f"{data_set.root}: has {len(data_set.cameras)} cameras: "
                f"{', '.join(data_set.cameras)}; give the touch sensor's by --camera."
            )
        camera = data_set.cameras[0]
    data_set.require_camera(camera)
    return camera
