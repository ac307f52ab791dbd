"""An episode that is named now and read as a recording later, perhaps by another process."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from geotlm_lm.core.clip import Clip
from geotlm_lm.data_sets.episode_frames import episode_clip
from geotlm_lm.data_sets.layout import INFO
from geotlm_lm.data_sets.lerobot import Episode, LeRobotDataSet
from geotlm_lm.recordings.listing import stamp_of
from geotlm_lm.recordings.read import require_motion


@dataclass(frozen=True)
class StoredEpisode:
    """What a camera saw in an episode.

    Args:
        data_set: That it is of.
        episode: Which.
        camera: Name of a feature that is pictures.
        fps: Frames per second; None for the data set's.
        square_pixels: As of `read_clip`.
    """

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
    """Yield the episodes of a data set in order.

    Args:
        data_set: That they are of.
        camera: Name of a feature that is pictures.
        reading: Further fields of `StoredEpisode`.
    """
    alone = replace(data_set, episodes=())  # each has its own: processes are sent it
    for episode in data_set.episodes:
        yield StoredEpisode(alone, episode, camera, **reading)
