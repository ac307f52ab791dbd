"""What is drawn of a track: curves with their spans, bands of events, and marks over each frame.

The film is drawn here; the plot, the Rerun recording and the page read the same values.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import Unwritten
from geotlm_lm.core.figures import figure_of
from geotlm_lm.core.files import plain_name, replacing_by_name
from geotlm_lm.core.geometry import filled_size
from geotlm_lm.core.twist import Component, way_words
from geotlm_lm.motion.belief import SPAN_DEVIATIONS
from geotlm_lm.recordings.video import quiet_capture
from geotlm_lm.track.events import Event
from geotlm_lm.track.export import Exported, Units, event_name
from geotlm_lm.track.track import Track
from geotlm_lm.views import ARROW_COLOUR, ARROW_THICKNESS, magnified

Floats = NDArray[np.float64]

CAPTION_S = 0.5
"""Time for which an event that is over stays in the caption."""

CAPTION_ROWS = 56
"""Pixels of the strip below the frame that holds two lines."""

DIAL_PX, DIAL_MARGIN = 30, 10
"""Radius of the dial that shows the turn, and its distance from the corner."""

WHITE, GREY = (255, 255, 255), (150, 150, 150)


@dataclass(frozen=True, eq=False)
class Curve:
    """A number of each frame over time."""

    panel: str  # "turn", "travel", "depth" or "contact"; curves of one panel share an axis
    name: str  # the panel's, or "right" and "down" of the travel
    unit: str  # "deg", "px" or "mm"; empty for a probability
    mean: Floats  # (n,)
    # half the width of the span that holds nine tenths, (n,); None for a probability
    spread: Floats | None = None


@dataclass(frozen=True)
class Band:
    """An event over time, where and how far it goes: `amount` between `low` and `high`, unsigned.

    Way and unit are empty where the event goes nowhere, as a touch or a rest.
    """

    event: Event
    name: str
    way: str = ""
    unit: str = ""
    amount: float = 0.0
    low: float = 0.0
    high: float = 0.0


@dataclass(frozen=True, eq=False)
class Mark:
    """What is drawn over one frame: the motion since the first frame."""

    hand_deg: float  # turn, clockwise
    arrow: Floats  # travel right and down, shares of the picture's width and height, (2,)
    lines: tuple[str, str]  # the time and the way in words; what happens


@dataclass(frozen=True, eq=False)
class Drawing:
    """A track as a list of things to draw."""

    units: Units  # of the recording
    numbers: NDArray[np.int64]  # of the frames, (n,)
    times_s: Floats  # when they were taken, (n,)
    way: Floats  # turn (deg), right, down (pixels of the 224-pixel square) and inward (mm), (n, 4)
    arrows: Floats  # travel as of `Mark`, (n, 2)
    curves: tuple[Curve, ...]  # of all frames
    bands: tuple[Band, ...]  # by when they begin

    def mark(self, place: int) -> Mark:
        """Return what is drawn over the frame at a place of the track."""
        number, time_s = self.numbers[place], self.times_s[place]
        begun = [band for band in self.bands if band.event.begin <= number]
        now = [band for band in begun if number <= band.event.end]
        now = now or [band for band in begun if time_s - band.event.end_s <= CAPTION_S]
        return mark_of(self.way[place], self.units, time_s, now)

    def up_to(self, now_s: float, way: Floats) -> Drawing:
        """Return the drawing led on to a later frame, which is not settled yet.

        Its spans and its contact are taken to be those of the last settled frame.

        Args:
            now_s: When the frame was taken.
            way: Up to it, as of `Drawing`, (4,).
        """
        now = _curves(self.units, way[None], np.zeros((1, 4)), np.zeros(1))
        curves = []
        for curve, later in zip(self.curves, now, strict=True):
            mean, spread = later.mean, None
            if curve.spread is None:
                mean = curve.mean[-1:] if len(curve.mean) else mean
            else:
                last = curve.spread[-1:] if len(curve.spread) else later.spread
                spread = np.concatenate([curve.spread, last])
            curves.append(replace(curve, mean=np.concatenate([curve.mean, mean]), spread=spread))
        return replace(
            self,
            numbers=np.append(self.numbers, self.numbers.max(initial=-1) + 1),
            times_s=np.append(self.times_s, now_s),
            way=np.concatenate([self.way, way[None]]),
            arrows=np.concatenate([self.arrows, _arrows(way[None], self.units)]),
            curves=tuple(curves),
        )


def drawing_of(track: Track, units: Units) -> Drawing:
    """Return what is drawn of a track, in the units of its recording."""
    path = track.path_from_start
    curves = _curves(units, path, SPAN_DEVIATIONS * track.held_deviations, track.contact)
    bands = tuple(band_of(event, units) for event in track.events)
    arrows = _arrows(path, units)
    return Drawing(units, track.numbers, track.times_s, path, arrows, curves, bands)


def mark_of(way: Floats, units: Units, time_s: float, bands: Iterable[Band]) -> Mark:
    """Return what is drawn over a frame after a way, as of `Drawing`, while some events go on."""
    right, down = units.travelled(way[1], way[2])
    travelled = f"travelled {right:+.1f} {units.name} right, {down:+.1f} down"
    words = [f"{b.name} {figure_of(b.amount)} {b.unit}" if b.unit else b.name for b in bands]
    lines = (f"{time_s:.2f} s  turned {way[0]:+.0f} deg  {travelled}", ", ".join(words))
    return Mark(float(way[0]), _arrows(way[None], units)[0], lines)


def band_of(event: Event, units: Units) -> Band:
    """Return an event as it is drawn."""
    amount = units.amount(event)
    if amount is None:
        return Band(event, event_name(event))
    span, unit = amount
    low, high = sorted((abs(span.low), abs(span.high)))
    low = 0.0 if span.low < 0 < span.high else low
    way = event.twist.way(event.component)
    is_slide = event.component is Component.SLIDE
    lesser, is_diagonal = event.twist.lesser_way() if is_slide else (None, False)
    words = way_words(way, lesser, is_diagonal=is_diagonal)
    return Band(event, event_name(event), words, unit, abs(span.mean), low, high)


def _curves(units: Units, way: Floats, spread: Floats, contact: Floats) -> tuple[Curve, ...]:
    right, down = units.travelled(way[:, 1], way[:, 2])
    right_spread, down_spread = units.travelled(spread[:, 1], spread[:, 2])
    return (
        Curve("turn", "turn", "deg", way[:, 0], spread[:, 0]),
        Curve("travel", "right", units.name, right, right_spread),
        Curve("travel", "down", units.name, down, down_spread),
        Curve("depth", "depth", "mm", way[:, 3], spread[:, 3]),
        Curve("contact", "contact", "", contact),
    )


def _arrows(way: Floats, units: Units) -> Floats:
    rows, columns = filled_size(*units.frame_size) if min(units.frame_size) > 0 else (1, 1)
    return way[:, 1:3] / (columns, rows)


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
