"""The frames of one episode of a LeRobot data set, and the episode as a recording."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import UnreadableClip, first_line
from geotlm_lm.data_sets.lerobot import Episode, LeRobotDataSet
from geotlm_lm.data_sets.tables import read_frames, read_table
from geotlm_lm.recordings.images import decoded_image
from geotlm_lm.recordings.pixels import with_pixel_shape
from geotlm_lm.recordings.policy import stride_for, stride_note

OFF_SHARE = 0.5
"""Share of the time between two frames by which a picture may be off its row's time."""

CONTAINERS = "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi"
"""Forms that hold pictures themselves: a playlist in a video's place would name other files."""


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
