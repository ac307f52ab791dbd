"""Every frame of a recording, also where only a part of them fits into memory."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.recordings.bags import bag_images, is_bag
from geotlm_lm.recordings.pixel_shape import with_square_pixels
from geotlm_lm.recordings.video import VIDEO_SUFFIXES
from geotlm_lm.recordings.video_file import video_file


def each_frame(
    clip: Clip, *, square_pixels: bool = False, topic: str | None = None
) -> Iterator[tuple[int, Frames]]:
    """Yield the number of every frame of a recording, and the frame, uint8 RGB.

    A video or a bag of which only a part fits into memory is decoded anew, frame by frame.

    Args:
        clip: As it was read.
        square_pixels: As it was read with.
        topic: Likewise.
    """
    numbers, path = clip.frame_numbers, Path(clip.name)
    is_whole = len(numbers) < 2 or np.diff(numbers).min() == 1
    if not is_whole and path.suffix.lower() in VIDEO_SUFFIXES:
        frames = _of_video(path)
    elif not is_whole and is_bag(path):
        frames = (image.decoded() for image in bag_images(path, topic))
    else:
        yield from zip(numbers, clip.frames, strict=True)
        return
    for number, image in enumerate(frames):
        yield number, with_square_pixels(image) if square_pixels else image


def _of_video(path: Path) -> Iterator[Frames]:
    with video_file(path) as capture:
        while (read := capture.read())[0]:
            yield cv2.cvtColor(read[1], cv2.COLOR_BGR2RGB)
