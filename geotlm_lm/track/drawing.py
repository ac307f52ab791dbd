"""What is drawn of a track: curves with their spans, bands of events, and marks over each frame.

The plot, the film, the Rerun recording and the page read these values; none works out its own.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import filled_size
from geotlm_lm.motion.belief import SPAN_DEVIATIONS
from geotlm_lm.track.events import Event
from geotlm_lm.track.export import Units, event_name
from geotlm_lm.track.track import Track

Floats = NDArray[np.float64]

CAPTION_S = 0.5
"""Time for which an event that is over stays in the caption."""


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
    """An event over time, and how far it goes: `amount` between `low` and `high`, unsigned.

    The unit is empty where the event goes nowhere, as a touch or a rest.
    """

    event: Event
    name: str
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
    curves = _curves(units, path, SPAN_DEVIATIONS * track.path_deviations, track.contact)
    bands = tuple(band_of(event, units) for event in track.events)
    arrows = _arrows(path, units)
    return Drawing(units, track.numbers, track.times_s, path, arrows, curves, bands)


def mark_of(way: Floats, units: Units, time_s: float, bands: Iterable[Band]) -> Mark:
    """Return what is drawn over a frame after a way, as of `Drawing`, while some events go on."""
    right, down = units.travelled(way[1], way[2])
    travelled = f"travelled {right:+.1f} {units.name} right, {down:+.1f} down"
    words = [f"{b.name} {b.amount:.2g} {b.unit}" if b.unit else b.name for b in bands]
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
    return Band(event, event_name(event), unit, abs(span.mean), low, high)


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
