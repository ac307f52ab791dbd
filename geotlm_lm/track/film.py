"""What was tracked, as a video: each frame with its turn and travel, its events as a caption."""

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
from geotlm_lm.core.geometry import filled_size
from geotlm_lm.recordings.video import quiet_capture
from geotlm_lm.track.amounts import Floats
from geotlm_lm.track.events import Event
from geotlm_lm.track.export import Exported, Units, event_name
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
        Unwritten: If the file cannot be written, or not whole.
    """
    track, units = exported.track, exported.units
    places = {int(number): place for place, number in enumerate(track.numbers)}
    with filming(path, fps) as write:
        for number, frame in frames:
            if number in places:
                time_s = track.times_s[places[number]]
                told = caption(going_on(track.events, number, time_s), units)
                write(captioned(frame, exported.path[places[number]], units, time_s, told))
            if number >= max(places):
                break


def draw_motion(frame: Frames, way: Floats, units: Units) -> Frames:
    """Return a frame, magnified, with a dial of the turn and an arrow of the travel.

    Args:
        frame: uint8 RGB.
        way: Turn (degrees), right and down (pixels of the 224-pixel square) since the first frame.
        units: Of the recording.
    """
    image, (turn, right, down) = magnified(frame), way[:3]
    rows, columns = image.shape[:2]
    filled = filled_size(*units.frame_size)
    middle = np.array([columns / 2, rows / 2])
    tip = middle + (right * columns / filled[1], down * rows / filled[0])
    if np.hypot(*(tip - middle)) > 2 * ARROW_THICKNESS:
        ends = [tuple(int(x) for x in np.rint(end)) for end in (middle, tip)]
        cv2.arrowedLine(image, *ends, ARROW_COLOUR, ARROW_THICKNESS, cv2.LINE_AA, tipLength=0.2)
    _draw_dial(image, turn)
    return image


def captioned(frame: Frames, way: Floats, units: Units, time_s: float, told: str) -> Frames:
    """Return a frame as `draw_motion` draws it, on a strip with its time, the way and what is told.

    Returns:
        uint8 RGB.
    """
    image = draw_motion(frame, way, units)
    rows = image.shape[0]
    image = cv2.copyMakeBorder(image, 0, CAPTION_ROWS, 0, 0, cv2.BORDER_CONSTANT)
    lines = ((f"{time_s:.2f} s  {way_in_words(way, units)}", GREY), (told, WHITE))
    for line, (text, colour) in enumerate(lines):
        at = (8, rows + 22 + 24 * line)
        cv2.putText(image, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.42, colour, 1, cv2.LINE_AA)
    # The codec halves the colours' resolution: odd sizes cannot be written.
    return image[: image.shape[0] // 2 * 2, : image.shape[1] // 2 * 2]


def way_in_words(way: Floats, units: Units) -> str:
    """Return how far it turned and travelled since the first frame, in few words."""
    across, along = units.travelled(way[1], way[2])
    travelled = f"travelled {across:+.1f} {units.name} right, {along:+.1f} down"
    return f"turned {way[0]:+.0f} deg  {travelled}"


def going_on(events: Iterable[Event], number: int, time_s: float) -> list[Event]:
    """Return the events in which a frame lies, or those that were over shortly before."""
    begun = [one for one in events if one.begin <= number]
    now = [one for one in begun if number <= one.end]
    return now or [one for one in begun if time_s - one.end_s <= TOLD_S]


def caption(events: Iterable[Event], units: Units) -> str:
    """Return events by their names and amounts."""
    return ", ".join(_named(one, units) for one in events)


def _named(event: Event, units: Units) -> str:
    found = units.amount(event)
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
def filming(path: Path, fps: float) -> Iterator[Callable[[Frames], None]]:
    """Yield what writes an image to a video, which takes the place of `path` once it is whole.

    Args:
        path: Of the .mp4 file; its folder is made if missing.
        fps: Frames per second of the video.

    Raises:
        Unwritten: If the file cannot be written, or not whole.
    """
    writer: cv2.VideoWriter | None = None
    written = 0

    def write(image: Frames) -> None:
        nonlocal writer, written
        if writer is None:
            # Read when the codecs are first used: what they say is told in one sentence here.
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
        if not _is_whole(part, written):
            raise Unwritten(
                f"{path} could not be written whole; free some room on the disk, or give a name on "
                f"another one."
            )


def _is_whole(path: Path, written: int) -> bool:
    """Tell whether a video holds as many frames as were written: the codec says nothing of it."""
    with quiet_capture(path, cv2.CAP_FFMPEG) as capture:
        declared = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
        capture.set(cv2.CAP_PROP_POS_FRAMES, written - 1)
        return declared == written and capture.grab()
