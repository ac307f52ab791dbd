"""What a LeRobot data set (v3) holds: its cameras, its episodes, and in which files they lie.

`meta/info.json` names features and paths, `meta/episodes/` has a row for each episode, `data/` a
row for each frame; a video or a table holds several episodes.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from geotlm_lm.core.errors import MissingDependency, UnreadableClip, UsageError
from geotlm_lm.data_sets.layout import EPISODES, INFO, Info, contained, read_info
from geotlm_lm.data_sets.tables import read_table, seconds, whole_numbers


def require_packages() -> None:
    """Refuse to go on where what reads tables and videos is not installed.

    Raises:
        MissingDependency: If a package is not there.
    """
    for package in ("pyarrow", "av"):
        if find_spec(package) is None:
            raise MissingDependency(
                f"A LeRobot data set is read with {package}, which is not installed; run "
                f"`pip install 'geotlm-lm[lerobot]'`."
            )


@dataclass(frozen=True)
class VideoPlace:
    """Where the pictures of an episode lie.

    Args:
        chunk: Number of the folder.
        file: Number of the file in it.
        since_s: When the episode begins in the video.
    """

    chunk: int
    file: int
    since_s: float


@dataclass(frozen=True)
class Episode:
    """Where an episode lies.

    Args:
        index: Its number.
        length: Frames.
        chunk: Number of the folder with the table of its frames.
        file: Number of that table.
        videos: Of each camera whose pictures are in videos.
    """

    index: int
    length: int
    chunk: int
    file: int
    videos: Mapping[str, VideoPlace]


@dataclass(frozen=True)
class LeRobotDataSet:
    """A data set that is read where it lies.

    Args:
        root: Its folder.
        info: What it says of itself.
        episodes: In order of their numbers, which count from 0.
    """

    root: Path
    info: Info
    episodes: tuple[Episode, ...]

    @property
    def fps(self) -> float:
        """Frames per second."""
        return self.info.fps

    @property
    def features(self) -> dict[str, dict[str, Any]]:
        """What each column is, by its name."""
        return self.info.content["features"]

    @property
    def cameras(self) -> tuple[str, ...]:
        """Names of the features that are pictures, by name."""
        kinds = self.info.kinds.items()
        return tuple(sorted(name for name, kind in kinds if kind in ("video", "image")))

    def require_camera(self, camera: str) -> None:
        """Refuse a camera that the data set lacks.

        Raises:
            UsageError: If it does.
        """
        if camera not in self.cameras:
            raise UsageError(
                f"{self.root}: has no camera {camera[:80]}, expected one of "
                f"{', '.join(self.cameras) or 'none'}; give its name."
            )

    def episode(self, index: int) -> Episode:
        """Return an episode.

        Raises:
            UsageError: If there is none of this number.
        """
        if not 0 <= index < len(self.episodes):
            raise UsageError(
                f"{self.root}: has no episode {index}, expected 0 to {len(self.episodes) - 1}; "
                f"give one of these."
            )
        return self.episodes[index]

    def data_path(self, episode: Episode) -> str:
        """Return the path of the table with an episode's frames, from the root on."""
        return self.info.data_path.filled(episode.chunk, episode.file)

    def table_of(self, episode: Episode) -> Path:
        """Return the file with the rows of an episode's frames.

        Raises:
            UnreadableClip: If a link leads out of the data set there.
        """
        return contained(self.root, self.data_path(episode))

    def video_of(self, episode: Episode, camera: str) -> Path | None:
        """Return the video in which a camera saw an episode; None where its table has pictures.

        Raises:
            UnreadableClip: If a link leads out of the data set there.
        """
        if self.info.video_path is None or camera not in episode.videos:
            return None
        place = episode.videos[camera]
        name = self.info.video_path.filled(place.chunk, place.file, camera)
        return contained(self.root, name)


def read_data_set(root: Path) -> LeRobotDataSet:
    """Return the LeRobot data set in a folder; none of its frames is read.

    Raises:
        UnreadableClip: If it is none, of another version, lacks a file, or one says something that
            cannot be, in one sentence.
        MissingDependency: If a package that reads it is not installed.
    """
    require_packages()
    info = read_info(root)
    paths = sorted((root / EPISODES).glob("*/*.parquet"))
    if not paths:
        raise UnreadableClip(
            f"{root / EPISODES}: holds no table of episodes, expected chunk-000/file-000.parquet; "
            f"copy the data set again."
        )
    cameras = [name for name, kind in info.kinds.items() if kind == "video"]
    episodes = [episode for path in paths for episode in _episodes(path, cameras)]
    episodes.sort(key=lambda episode: episode.index)
    if [one.index for one in episodes] != list(range(len(episodes))) or (
        len(episodes) != info.total_episodes
    ):
        raise UnreadableClip(
            f"{root}: {len(episodes)} episodes were found, expected {info.total_episodes} counted "
            f"from 0 as {INFO} says; copy the data set again."
        )
    return LeRobotDataSet(root, info, tuple(episodes))


def is_data_set(path: Path) -> bool:
    """Tell whether a folder looks like a LeRobot data set."""
    return os.path.isfile(path / INFO)


def _episodes(path: Path, cameras: list[str]) -> Iterator[Episode]:
    """Yield the episodes of a table, whose pictures these cameras have in videos."""
    own = ("episode_index", "length", "data/chunk_index", "data/file_index")
    counted = {
        camera: [f"videos/{camera}/{name}" for name in ("chunk_index", "file_index")]
        for camera in cameras
    }
    since = {camera: f"videos/{camera}/from_timestamp" for camera in cameras}
    table = read_table(path, [*own, *sum(counted.values(), []), *since.values()])
    columns = [whole_numbers(path, table, name).tolist() for name in own]
    videos = [
        [
            VideoPlace(*place)
            for place in zip(
                *(whole_numbers(path, table, name).tolist() for name in counted[camera]),
                seconds(path, table, since[camera]).tolist(),
                strict=True,
            )
        ]
        for camera in cameras
    ]
    if 0 in columns[1]:
        raise UnreadableClip(
            f"{path}: an episode has a length of 0 frames, expected 1 or more; record the data "
            f"set again."
        )
    for row, numbers in enumerate(zip(*columns, strict=True)):
        places = {camera: videos[number][row] for number, camera in enumerate(cameras)}
        yield Episode(*numbers, places)
