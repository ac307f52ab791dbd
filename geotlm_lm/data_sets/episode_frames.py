"""The frames of one episode of a LeRobot data set, and the episode as a recording."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import UnreadableClip, first_line
from geotlm_lm.data_sets.lerobot import Episode, LeRobotDataSet, read_table
from geotlm_lm.recordings.limits import stride_for, stride_note
from geotlm_lm.recordings.pixel_shape import with_pixel_shape

OFF_SHARE = 0.5
"""Share of the time between two frames by which a picture may be off its row's time."""


def episode_clip(
    data_set: LeRobotDataSet,
    episode: Episode,
    camera: str,
    *,
    square_pixels: bool | None = None,
) -> Clip:
    """Return what a camera saw in an episode; of one too long for memory, frames at a stride.

    Args:
        data_set: That it is of.
        episode: Which.
        camera: Name of a feature that is pictures.
        square_pixels: As of `read_clip`.

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
    """Yield the frame of each row of an episode, in order, uint8 RGB.

    Args:
        data_set: That it is of.
        episode: Which.
        camera: Name of a feature that is pictures.

    Raises:
        UsageError: If there is no such camera.
        UnreadableClip: If a file is missing or damaged, or holds fewer frames than rows.
    """
    data_set.require_camera(camera)
    if data_set.features[camera]["dtype"] == "image":
        yield from _stored_images(data_set, episode, camera)
        return
    path, since_s = data_set.video_of(episode, camera)
    times_s = since_s + _times_s(data_set, episode)
    yield from _video_frames(path, times_s, OFF_SHARE / data_set.fps)


def rows_of(data_set: LeRobotDataSet, episode: Episode, column: str) -> list:
    """Return a column of an episode's rows, in order of the frames.

    Raises:
        UnreadableClip: If there are not as many as the episode is long.
    """
    path = data_set.table_of(episode)
    table = read_table(path, ["episode_index", "frame_index", column])
    where = np.flatnonzero(table["episode_index"].to_numpy() == episode.index)
    order = np.argsort(table["frame_index"].to_numpy()[where], kind="stable")
    if len(where) != episode.length:
        raise UnreadableClip(
            f"{path}: holds {len(where)} rows of episode {episode.index}, expected "
            f"{episode.length}; copy the data set again."
        )
    return table[column].take(where[order]).to_pylist()


def _times_s(data_set: LeRobotDataSet, episode: Episode) -> NDArray[np.float64]:
    return np.asarray(rows_of(data_set, episode, "timestamp"), np.float64).reshape(-1)


def _video_frames(path: Path, times_s: NDArray[np.float64], off_s: float) -> Iterator[Frames]:
    """Yield the picture that a video shows at each time; times rise.

    Args:
        path: Of the video.
        times_s: Since its begin.
        off_s: How far a picture's own time may be off.
    """
    import av

    wanted = iter(times_s)
    time_s = next(wanted)
    try:
        with av.open(str(path), metadata_errors="replace") as container:
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


def _stored_images(data_set: LeRobotDataSet, episode: Episode, camera: str) -> Iterator[Frames]:
    for number, stored in enumerate(rows_of(data_set, episode, camera)):
        content = stored.get("bytes") if isinstance(stored, dict) else None
        image = None
        if content:
            image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
        if image is None:
            raise UnreadableClip(
                f"{data_set.table_of(episode)}: the picture of frame {number} of episode "
                f"{episode.index} cannot be decoded; copy or record the data set again."
            )
        yield cv2.cvtColor(image, cv2.COLOR_BGR2RGB)
