"""What a LeRobot data set (v3) holds: its cameras, its episodes, and in which files they lie.

`meta/info.json` names features and paths, `meta/episodes/` has a row for each episode, `data/` a
row for each frame; a video or a table holds several episodes.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geotlm_lm.core.errors import MissingDependency, UnreadableClip, UsageError, first_line
from geotlm_lm.core.plain_name import plain_name

if TYPE_CHECKING:
    import pyarrow

INFO, STATISTICS, EPISODES = "meta/info.json", "meta/stats.json", "meta/episodes"

VERSION = "v3."
"""What the version of a layout that is read begins with."""

_NEEDED = {"fps", "features", "data_path", "total_episodes"}
_PLACE = ("data/chunk_index", "data/file_index", "dataset_from_index", "dataset_to_index")


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
class Episode:
    """Where an episode lies.

    Args:
        index: Its number.
        length: Frames.
        row: Its row of the episodes' table: numbers by column, without statistics.
    """

    index: int
    length: int
    row: dict[str, Any]


@dataclass(frozen=True)
class LeRobotDataSet:
    """A data set that is read where it lies.

    Args:
        root: Its folder.
        info: What `meta/info.json` holds.
        episodes: By their number.
    """

    root: Path
    info: dict[str, Any]
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
        kinds = {name: feature.get("dtype") for name, feature in self.features.items()}
        return tuple(sorted(name for name, kind in kinds.items() if kind in ("video", "image")))

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

    def table_of(self, episode: Episode) -> Path:
        """Return the file with the rows of an episode's frames."""
        return self.root / self.data_path(episode.row)

    def data_path(self, row: dict[str, Any]) -> str:
        """Return the path of an episode's rows, from the root on."""
        chunk, file = (int(row[name]) for name in _PLACE[:2])
        return self.info["data_path"].format(chunk_index=chunk, file_index=file)

    def video_of(self, episode: Episode, camera: str) -> tuple[Path, float]:
        """Return the video in which a camera saw an episode, and the second at which it begins.

        Raises:
            UnreadableClip: If the episodes' table does not say.
        """
        try:
            chunk, file, since = (
                episode.row[f"videos/{camera}/{name}"]
                for name in ("chunk_index", "file_index", "from_timestamp")
            )
        except KeyError as error:
            raise UnreadableClip(
                f"{self.root}: its episodes have no column {error.args[0]}, expected where the "
                f"camera's video lies; convert the data set to LeRobot's version 3."
            ) from error
        pattern = self.info["video_path"]
        named = pattern.format(video_key=camera, chunk_index=int(chunk), file_index=int(file))
        return self.root / named, float(since)


def read_data_set(root: Path) -> LeRobotDataSet:
    """Return the LeRobot data set in a folder; none of its frames is read.

    Raises:
        UnreadableClip: If it is none, of another version, or lacks a file, in one sentence.
        MissingDependency: If a package that reads it is not installed.
    """
    require_packages()
    info = _info(root)
    paths = sorted((root / EPISODES).glob("*/*.parquet"))
    if not paths:
        raise UnreadableClip(
            f"{root / EPISODES}: holds no table of episodes, expected chunk-000/file-000.parquet; "
            f"copy the data set again."
        )
    rows = [row for path in paths for row in _rows(path)]
    rows.sort(key=lambda row: row["episode_index"])
    found = tuple(Episode(int(row["episode_index"]), int(row["length"]), row) for row in rows)
    if [one.index for one in found] != list(range(int(info["total_episodes"]))):
        raise UnreadableClip(
            f"{root}: {len(found)} episodes were found, expected {info['total_episodes']} counted "
            f"from 0 as {INFO} says; copy the data set again."
        )
    return LeRobotDataSet(root, info, found)


def is_data_set(path: Path) -> bool:
    """Tell whether a folder looks like a LeRobot data set."""
    return (path / INFO).is_file()


def read_table(path: Path, columns: list[str] | None = None) -> pyarrow.Table:
    """Return a table, or some of its columns.

    Raises:
        UnreadableClip: If it is missing, damaged, or lacks a column.
    """
    import pyarrow
    import pyarrow.parquet

    try:
        # ParquetFile: read_table would look for columns in the names of the folders too.
        with plain_name(path) as plain, pyarrow.parquet.ParquetFile(plain) as file:
            found = file.read(columns=columns)
    except (OSError, pyarrow.ArrowException) as error:
        raise UnreadableClip(
            f"{path}: cannot be read ({first_line(error)}), expected a table of a LeRobot data "
            f"set; copy it again."
        ) from error
    missing = set(columns or ()) - set(found.column_names)
    if missing:
        raise UnreadableClip(
            f"{path}: has no column {min(missing)}, expected one of a LeRobot data set (v3); "
            f"convert or copy it again."
        )
    return found


def _info(root: Path) -> dict[str, Any]:
    path = root / INFO
    try:
        info = json.loads(path.read_text(encoding="utf-8"))
        version, missing = str(info["codebase_version"]), _NEEDED - set(info)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UnreadableClip(
            f"{root}: is no LeRobot data set, expected a readable {INFO}; give the folder that "
            f"holds meta and data."
        ) from error
    if not version.startswith(VERSION) or missing:
        raise UnreadableClip(
            f"{root}: is a LeRobot data set of version {version[:20]}, expected {VERSION}x with "
            f"{', '.join(sorted(_NEEDED))}; convert it with LeRobot's own script."
        )
    return info


def _rows(path: Path) -> list[dict[str, Any]]:
    table = read_table(path)
    plain = [name for name in table.column_names if not name.startswith("stats/")]
    missing = {"episode_index", "length", *_PLACE} - set(plain)
    if missing:
        raise UnreadableClip(
            f"{path}: has no column {min(missing)}, expected a table of episodes (v3); convert or "
            f"copy the data set again."
        )
    return table.select(plain).to_pylist()
