"""A track as a video: each frame with its turn and travel, its events as a caption."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import cv2
import numpy as np

from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import Unwritten
from geotlm_lm.core.files import plain_name, replacing_by_name
from geotlm_lm.recordings.video import quiet_capture
from geotlm_lm.track.drawing import Mark, drawing_of
from geotlm_lm.track.export import Exported
from geotlm_lm.views import ARROW_COLOUR, ARROW_THICKNESS, magnified

CAPTION_ROWS = 56
"""Pixels of the strip below the frame that holds two lines."""

DIAL_PX, DIAL_MARGIN = 30, 10
"""Radius of the dial that shows the turn, and its distance from the corner."""

WHITE, GREY = (255, 255, 255), (150, 150, 150)


def write_film(
    path: Path, exported: Exported, frames: Iterable[tuple[int, Frames]], fps: float
) -> None:
    """Write a drawing of every tracked frame to a video file, which appears when it is whole.

    Args:
        path: Of the .mp4 file; its folder is made if missing.
        exported: The track.
        frames: The recording's, uint8 RGB, each after its number; those not tracked are left out.
        fps: Frames per second of the video.

    Raises:
        Unwritten: If the file cannot be written, or not whole.
    """
    drawing = drawing_of(exported.track, exported.units)
    places = {int(number): place for place, number in enumerate(drawing.numbers)}
    with filming(path, fps) as write:
        for number, frame in frames:
            if number in places:
                write(draw_mark(frame, drawing.mark(places[number])))
            if number >= max(places):
                break


def draw_mark(frame: Frames, mark: Mark) -> Frames:
    """Return a frame, magnified, with its arrow and its dial, on a strip with two lines of text."""
    image = magnified(frame)
    rows, columns = image.shape[:2]
    middle = np.array([columns / 2, rows / 2])
    tip = middle + mark.arrow * (columns, rows)
    if np.hypot(*(tip - middle)) > 2 * ARROW_THICKNESS:
        ends = [tuple(int(x) for x in np.rint(end)) for end in (middle, tip)]
        cv2.arrowedLine(image, *ends, ARROW_COLOUR, ARROW_THICKNESS, cv2.LINE_AA, tipLength=0.2)
    _draw_dial(image, mark.hand_deg)
    image = cv2.copyMakeBorder(image, 0, CAPTION_ROWS, 0, 0, cv2.BORDER_CONSTANT)
    for line, (text, colour) in enumerate(zip(mark.lines, (GREY, WHITE), strict=True)):
        at = (8, rows + 22 + 24 * line)
        cv2.putText(image, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.42, colour, 1, cv2.LINE_AA)
    # The codec halves the colours' resolution: odd sizes cannot be written.
    return image[: image.shape[0] // 2 * 2, : image.shape[1] // 2 * 2]


def _draw_dial(image: Frames, turn_deg: float) -> None:
    """Draw a circle whose hand points up at the begin and turns as the object has."""
    middle, angle = (DIAL_MARGIN + DIAL_PX, DIAL_MARGIN + DIAL_PX), math.radians(turn_deg)
    right, up = DIAL_PX * math.sin(angle), DIAL_PX * math.cos(angle)
    hand = (round(middle[0] + right), round(middle[1] - up))
    cv2.circle(image, middle, DIAL_PX, WHITE, 1, cv2.LINE_AA)
    cv2.line(image, middle, (middle[0], DIAL_MARGIN), GREY, 1, cv2.LINE_AA)
    cv2.line(image, middle, hand, ARROW_COLOUR, ARROW_THICKNESS, cv2.LINE_AA)


@contextmanager
def filming(path: Path, fps: float) -> Iterator[Callable[[Frames], None]]:
    """Yield what writes an image to a video, which takes the place of `path` once it is whole.

    Raises:
        Unwritten: If the file cannot be written, or not whole.
    """
    writer: cv2.VideoWriter | None = None
    written = 0

    def write(image: Frames) -> None:
        nonlocal writer, written
        if writer is None:
            # Read when the codecs are first used: their messages become one sentence here.
            os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
            size = (image.shape[1], image.shape[0])
            plain = opened.enter_context(plain_name(part))
            writer = cv2.VideoWriter(plain, cv2.VideoWriter_fourcc(*"mp4v"), fps, size)
            if not writer.isOpened():
                raise Unwritten(f"{path} cannot be written as video; give another name.")
        writer.write(cv2.cvtColor(image, cv2.COLOR_RGB2BGR))
        written += 1

    with ExitStack() as opened, replacing_by_name(path) as part:
        yield write
        if writer is None:
            part.unlink()
            return
        writer.release()
        # The codec reports no failure: as many frames must be there as were written.
        with quiet_capture(part, cv2.CAP_FFMPEG) as capture:
            declared = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
            capture.set(cv2.CAP_PROP_POS_FRAMES, written - 1)
            is_whole = declared == written and capture.grab()
        if not is_whole:
            raise Unwritten(
                f"{path} could not be written whole; free some room on the disk, or give a name on "
                f"another one."
            )
