"""A LeRobot data set (v3): its cameras, its episodes, and what a camera saw in each.

`meta/info.json` names features and paths, `meta/episodes/` has a row for each episode, `data/` a
row for each frame; a video or a table holds several episodes.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import UnreadableClip, UsageError, choice_of, first_line, require_package
from geotlm_lm.data_sets.layout import (
    EPISODES,
    INFO,
    column_of,
    contained,
    filled,
    read_frames,
    read_info,
    read_table,
)
from geotlm_lm.recordings.images import decoded_image
from geotlm_lm.recordings.pixels import with_pixel_shape
from geotlm_lm.recordings.policy import stride_for, stride_note
from geotlm_lm.recordings.read import require_motion, stamp_of

OFF_SHARE = 0.5
"""Share of the time between two frames by which a picture may be off its row's time."""

CONTAINERS = "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi"
"""Forms that hold pictures themselves: a playlist in a video's place would name other files."""


@dataclass(frozen=True)
class VideoPlace:
    """Where the pictures of an episode lie."""

    chunk: int
    file: int
    since_s: float


@dataclass(frozen=True)
class Episode:
    """Where an episode of `length` frames lies: its table, and the video of each camera."""

    index: int
    length: int
    chunk: int
    file: int
    videos: Mapping[str, VideoPlace]


@dataclass(frozen=True)
class LeRobotDataSet:
    """A data set that is read where it lies; its episodes are numbered from 0 in order."""

    root: Path
    info: dict[str, Any]  # as of `read_info`
    episodes: tuple[Episode, ...]

    @property
    def fps(self) -> float:
        """Frames per second."""
        return float(self.info["fps"])

    @property
    def features(self) -> dict[str, dict[str, Any]]:
        """What each column is, by its name."""
        return self.info["features"]

    @property
    def cameras(self) -> tuple[str, ...]:
        """Names of the features that are pictures, by name."""
        return tuple(sorted(names_of(self.features, "video", "image")))

    def require_camera(self, camera: str) -> None:
        """Refuse a camera that the data set lacks."""
        if camera not in self.cameras:
            raise UsageError(
                f"{self.root}: has no camera {camera[:80]}; "
                f"{choice_of(camera, self.cameras or ['none'])}"
            )

    def episode(self, index: int) -> Episode:
        """Return an episode."""
        if not 0 <= index < len(self.episodes):
            raise UsageError(
                f"{self.root}: has no episode {index}, expected 0 to {len(self.episodes) - 1}; "
                f"give one of these."
            )
        return self.episodes[index]

    def data_path(self, episode: Episode) -> str:
        """Return the path of the table with an episode's frames, from the root on."""
        return filled(self.info["data_path"], episode.chunk, episode.file)

    def table_of(self, episode: Episode) -> Path:
        """Return the file with the rows of an episode's frames."""
        return contained(self.root, self.data_path(episode))

    def video_of(self, episode: Episode, camera: str) -> Path | None:
        """Return the video in which a camera saw an episode; None where its table has pictures."""
        if camera not in episode.videos:
            return None
        place = episode.videos[camera]
        name = filled(self.info["video_path"], place.chunk, place.file, camera)
        return contained(self.root, name)


def read_data_set(root: Path) -> LeRobotDataSet:
    """Return the LeRobot data set in a folder; none of its frames is read.

    Raises:
        UnreadableClip: If it is none, of another version, lacks a file, or one says something that
            cannot be, in one sentence.
        MissingDependency: If a package that reads it is not installed.
    """
    for package in ("pyarrow", "av"):
        require_package(package, f"A LeRobot data set is read with {package}", "lerobot")
    info = read_info(root)
    paths = sorted((root / EPISODES).glob("*/*.parquet"))
    if not paths:
        raise UnreadableClip(
            f"{root / EPISODES}: holds no table of episodes, expected chunk-000/file-000.parquet; "
            f"copy the data set again."
        )
    cameras = names_of(info["features"], "video")
    total = info["total_episodes"]
    episodes = [episode for path in paths for episode in _episodes(path, cameras)]
    episodes.sort(key=lambda episode: episode.index)
    if len(episodes) != total or any(k != e.index for k, e in enumerate(episodes)):
        raise UnreadableClip(
            f"{root}: {len(episodes)} episodes were found, expected {total} counted "
            f"from 0 as {INFO} says; copy the data set again."
        )
    return LeRobotDataSet(root, info, tuple(episodes))


def names_of(features: dict[str, dict[str, Any]], *kinds: str) -> list[str]:
    """Return the names of the features that are of some kinds."""
    return [name for name, feature in features.items() if feature["dtype"] in kinds]


def is_data_set(path: Path) -> bool:
    """Tell whether a folder looks like a LeRobot data set."""
    return os.path.isfile(path / INFO)


def _episodes(path: Path, cameras: list[str]) -> Iterator[Episode]:
    """Yield the episodes of a table, whose pictures these cameras have in videos."""
    own = ("episode_index", "length", "data/chunk_index", "data/file_index")
    places = ("chunk_index", "file_index", "from_timestamp")
    of_videos = [[f"videos/{camera}/{place}" for place in places] for camera in cameras]
    table = read_table(path, [*own, *sum(of_videos, [])])

    def rows_of(names: Sequence[str]) -> list[tuple]:
        columns = (
            column_of(path, table, name, is_whole=not name.endswith(places[-1])) for name in names
        )
        return list(zip(*(column.tolist() for column in columns), strict=True))

    episodes = rows_of(own)
    videos = [[VideoPlace(*place) for place in rows_of(names)] for names in of_videos]
    if any(length == 0 for _, length, *_ in episodes):
        raise UnreadableClip(
            f"{path}: an episode has a length of 0 frames, expected 1 or more; record the data "
            f"set again."
        )
    for row, numbers in enumerate(episodes):
        yield Episode(
            *numbers, {camera: seen[row] for camera, seen in zip(cameras, videos, strict=True)}
        )


def episode_clip(
    data_set: LeRobotDataSet,
    episode: Episode,
    camera: str,
    *,
    square_pixels: bool | None = None,
) -> Clip:
    """Return what a camera saw in an episode; of one too long for memory, frames at a stride.

    Raises:
        UsageError: If there is no such camera.
        UnreadableClip: If a file is missing or damaged, or holds fewer frames than rows.
    """
    name = f"{data_set.root} episode {episode.index}"
    seen = episode_frames(data_set, episode, camera)
    with closing(seen):
        first = next(seen)
        stride = stride_for(episode.length, *first.shape[:2], name)
        frames = list(itertools.islice(itertools.chain([first], seen), 0, None, stride))
    if len({frame.shape for frame in frames}) > 1:
        raise UnreadableClip(
            f"{name}: its frames are of several sizes, expected one; export the data set again."
        )
    clip = Clip(
        np.stack(frames),
        fps=data_set.fps,
        name=name,
        frame_numbers=tuple(range(0, episode.length, stride)),
        recorded_frames=episode.length,
        notes=(stride_note(stride, episode.length),) if stride > 1 else (),
    )
    return with_pixel_shape(clip, is_square=square_pixels)


def episode_frames(data_set: LeRobotDataSet, episode: Episode, camera: str) -> Iterator[Frames]:
    """Yield the frame of each row of an episode, in order, uint8 RGB."""
    data_set.require_camera(camera)
    path = data_set.table_of(episode)
    table = read_frames(path)
    rows = table.rows_of(episode.index, episode.length)
    video = data_set.video_of(episode, camera)
    if video is None:
        yield from _stored_images(path, rows, camera)
        return
    times_s = episode.videos[camera].since_s + table.times_s[rows]
    yield from _video_frames(video, times_s, OFF_SHARE / data_set.fps)


def _video_frames(path: Path, times_s: NDArray[np.float64], off_s: float) -> Iterator[Frames]:
    """Yield the picture that a video shows at each time; times rise."""
    import av

    wanted = iter(times_s)
    time_s = next(wanted)
    try:
        if not os.path.isfile(path):  # a pipe would be waited for
            raise FileNotFoundError("there is no such file")
        options = {"format_whitelist": CONTAINERS}
        with av.open(str(path), options=options, metadata_errors="replace") as container:
            stream = container.streams.video[0]
            stream.codec_context.thread_count = 1  # processes share the work instead
            # A frame earlier: rounded up it would lead to the key frame behind.
            container.seek(int((time_s - off_s) / stream.time_base), stream=stream)
            for frame in container.decode(stream):
                while frame.time is not None and frame.time >= time_s - off_s:
                    if frame.time > time_s + off_s:
                        break  # the video has no picture of this row's time
                    yield frame.to_ndarray(format="rgb24")
                    time_s = next(wanted)
    except StopIteration:
        return
    except (OSError, av.FFmpegError, IndexError) as error:
        raise UnreadableClip(
            f"{path}: cannot be decoded ({first_line(error)}), expected a video of a LeRobot data "
            f"set; copy it again."
        ) from error
    raise UnreadableClip(
        f"{path}: has no picture within {1000 * off_s:.0f} ms of {time_s:.3f} s, where a row of "
        f"the data set says that one was taken; copy or record it again."
    )


def _stored_images(path: Path, rows: NDArray[np.int64], camera: str) -> Iterator[Frames]:
    for row, stored in zip(rows, read_table(path, [camera])[camera].take(rows), strict=True):
        cell = stored.as_py()
        content = cell.get("bytes") if isinstance(cell, dict) else None
        name = f"{path} column {camera} row {row}"
        yield decoded_image(content if isinstance(content, bytes) else b"", name)


@dataclass(frozen=True)
class StoredEpisode:
    """What a camera saw in an episode."""

    data_set: LeRobotDataSet
    episode: Episode
    camera: str
    fps: float | None = None
    square_pixels: bool | None = None

    @property
    def name(self) -> str:
        """Tells the episode by its number."""
        return f"episode-{self.episode.index:06d}"

    def read(self) -> Clip:
        """Return its frames, two or more.

        Raises:
            UsageError: If there is no such camera.
            UnreadableClip: As of `episode_clip`, or if it has one frame only.
        """
        clip = episode_clip(
            self.data_set, self.episode, self.camera, square_pixels=self.square_pixels
        )
        require_motion(clip)
        return clip if self.fps is None else replace(clip, fps=self.fps)

    @property
    def seen_at(self) -> Path:
        """What a machine that reads it must have."""
        return self.data_set.root / INFO

    def stamp(self) -> list[Any]:
        """Return what changes when its files do or are read otherwise, plain JSON values."""
        paths = [
            self.data_set.table_of(self.episode),
            self.data_set.video_of(self.episode, self.camera),
        ]
        files = [stamp_of(path) for path in paths if path is not None]
        place = asdict(self.episode)
        return [self.name, self.camera, place, files, self.fps, self.square_pixels]


def every_episode(data_set: LeRobotDataSet, camera: str, **reading: Any) -> Iterator[StoredEpisode]:
    """Yield the episodes of a data set in order."""
    alone = replace(data_set, episodes=())  # each has its own: processes are sent it
    for episode in data_set.episodes:
        yield StoredEpisode(alone, episode, camera, **reading)
