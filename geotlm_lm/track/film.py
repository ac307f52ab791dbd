"""What was tracked, as a video: each frame with its turn and travel, its events as a caption."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np

from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.geometry import filled_size
from geotlm_lm.recordings.video import quiet_capture
from geotlm_lm.track.events import Event
from geotlm_lm.track.export import Exported, event_name
from geotlm_lm.views.pictures import ARROW_COLOUR, ARROW_THICKNESS, magnified

CAPTION_ROWS = 56
"""Pixels of the strip below the frame that holds two lines."""

DIAL_PX, DIAL_MARGIN = 30, 10
"""Radius of the dial that shows the turn, and its distance from the corner."""

TOLD_S = 0.5
"""Time for which an event that is over stays in the caption."""

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
        UsageError: If the file cannot be written, or not whole.
    """
    places = {int(number): place for place, number in enumerate(exported.track.numbers)}
    with _writer(path, fps) as write:
        for number, frame in frames:
            if number in places:
                write(drawn(exported, places[number], frame))
            if number >= max(places):
                break


def drawn(exported: Exported, place: int, frame: Frames) -> Frames:
    """Return a tracked frame with a dial of its turn, an arrow of its travel, and its events.

    Args:
        exported: The track.
        place: Of the frame in it, from 0.
        frame: The frame, uint8 RGB.

    Returns:
        uint8 RGB, magnified, with a strip for the caption below.
    """
    track, image = exported.track, magnified(frame)
    turn, right, down = exported.path[place, :3]
    rows, columns = image.shape[:2]
    filled = filled_size(*frame.shape[:2])
    middle = np.array([columns / 2, rows / 2])
    tip = middle + (right * columns / filled[1], down * rows / filled[0])
    if np.hypot(*(tip - middle)) > 2 * ARROW_THICKNESS:
        ends = [tuple(int(x) for x in np.rint(end)) for end in (middle, tip)]
        cv2.arrowedLine(image, *ends, ARROW_COLOUR, ARROW_THICKNESS, cv2.LINE_AA, tipLength=0.2)
    _draw_dial(image, turn)
    image = cv2.copyMakeBorder(image, 0, CAPTION_ROWS, 0, 0, cv2.BORDER_CONSTANT)
    across, along = exported.travelled(right, down)
    told = (
        f"turned {turn:+.0f} deg  travelled {across:+.1f} {exported.unit} right, {along:+.1f} down"
    )
    lines = (f"{track.times_s[place]:.2f} s  {told}", caption(exported, place))
    for line, (text, colour) in enumerate(zip(lines, (GREY, WHITE), strict=True)):
        at = (8, rows + 22 + 24 * line)
        cv2.putText(image, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.42, colour, 1, cv2.LINE_AA)
    # The codec halves the colours' resolution: odd sizes cannot be written.
    return image[: image.shape[0] // 2 * 2, : image.shape[1] // 2 * 2]


def caption(exported: Exported, place: int) -> str:
    """Return what happens in a frame, or has just happened."""
    number, time_s = exported.track.numbers[place], exported.track.times_s[place]
    events = [one for one in exported.track.events if one.begin <= number]
    now = [one for one in events if number <= one.end]
    told = now or [one for one in events if time_s - one.end_s <= TOLD_S]
    return ", ".join(_named(one, exported) for one in told)


def _named(event: Event, exported: Exported) -> str:
    found = exported.amount(event)
    if found is None:
        return event_name(event)
    return f"{event_name(event)} {abs(found[0].mean):.2g} {found[1]}"


def _draw_dial(image: Frames, turn_deg: float) -> None:
    """Draw a circle whose hand points up at the begin and turns as the object has."""
    middle = (DIAL_MARGIN + DIAL_PX, DIAL_MARGIN + DIAL_PX)
    angle = math.radians(turn_deg)
    hand = (
        round(middle[0] + DIAL_PX * math.sin(angle)),
        round(middle[1] - DIAL_PX * math.cos(angle)),
    )
    cv2.circle(image, middle, DIAL_PX, WHITE, 1, cv2.LINE_AA)
    cv2.line(image, middle, (middle[0], DIAL_MARGIN), GREY, 1, cv2.LINE_AA)
    cv2.line(image, middle, hand, ARROW_COLOUR, ARROW_THICKNESS, cv2.LINE_AA)


@contextmanager
def _writer(path: Path, fps: float) -> Iterator:
    """Yield what writes an image to a video, which takes the place of `path` once it is whole."""
    path.parent.mkdir(parents=True, exist_ok=True)  # a video's writer makes no folder
    part = path.with_name(f".{path.stem}.{os.getpid()}-{os.urandom(4).hex()}.mp4")
    writer: cv2.VideoWriter | None = None
    written = 0

    def write(image: Frames) -> None:
        nonlocal writer, written
        if writer is None:
            size = (image.shape[1], image.shape[0])
            writer = cv2.VideoWriter(str(part), cv2.VideoWriter_fourcc(*"mp4v"), fps, size)
            if not writer.isOpened():
                raise UsageError(f"{path} cannot be written as video; give another name.")
        writer.write(cv2.cvtColor(image, cv2.COLOR_RGB2BGR))
        written += 1

    try:
        yield write
        if writer is None:
            return
        writer.release()
        if not _is_whole(part, written):
            raise UsageError(
                f"{path} could not be written whole; free some room on the disk, or give a name on "
                f"another one."
            )
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def _is_whole(path: Path, written: int) -> bool:
    """Tell whether a video holds as many frames as were written: the codec says nothing of it."""
    with quiet_capture(str(path), cv2.CAP_FFMPEG) as capture:
        declared = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
        capture.set(cv2.CAP_PROP_POS_FRAMES, written - 1)
        return declared == written and capture.grab()
