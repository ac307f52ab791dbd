"""Events of a recording in words: what happens, how far, and from when to when."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from geotlm_lm.answering.amounts import Amount, Measure
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.measured_motion import pixel_scale
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.tolerance import TOLERANCES
from geotlm_lm.core.twist import COUNTING_PX, Component
from geotlm_lm.track.events import TOGETHER_S, Event, EventKind
from geotlm_lm.track.whole import path_of_event

MOST_TOLD = 6
"""Events told one after another; of more, the largest."""

LONGER = 1.25
"""How many times as long as the net way the whole one is where that is told as well."""

ENDS_OF_CONTACT = (EventKind.TOUCH, EventKind.RELEASE)


def times_of(encoded: Encoded, events: Sequence[Event]) -> str:
    """Return from when to when events went on: "from 1.2 s to 3.4 s", or in frames."""
    first, last = min(events, key=lambda one: one.begin), max(events, key=lambda one: one.end)
    if not encoded.clip.is_timed:
        return f"from frame {first.begin} to {last.end}"
    return f"from {seconds(first.begin_s)} to {seconds(last.end_s)}"


def times_of_component(encoded: Encoded, component: Component) -> str:
    """Return from when to when a component of a recording's motion went on; empty of a clip."""
    events = [] if encoded.track is None else encoded.track.of(component)
    events = [one for one in events if one.component is component]
    return times_of(encoded, events) if events else ""


def there_and_back(encoded: Encoded, component: Component, frame: FrameSpec) -> list[str]:
    """Return a sentence on the whole way of a turn or slide that goes back on itself, or none."""
    track = encoded.track
    if track is None or component is Component.PRESS:
        return []
    way, net = track.path(component), abs(track.net(component).mean)
    if way.mean < LONGER * net or len(track.of(component)) < 2:
        return []
    words = TrackWording(encoded, frame)
    parts = [words.amount(one) for one in track.of(component)]
    far = sum(one.value for one in parts)
    together = replace(parts[0], value=float(f"{far:.3g}"))
    return [f"There and back it {component.value}s by {together.phrase}."]


def seconds(time_s: float) -> str:
    """Return a time or a duration in seconds, as exactly as events are found."""
    return f"{time_s:.1f} s"


class TrackWording:
    """Puts the events of one recording into words.

    Args:
        encoded: The recording, or a span of it.
        frame: In which to tell directions and lengths.
    """

    def __init__(self, encoded: Encoded, frame: FrameSpec) -> None:
        self._encoded, self._track, self._frame = encoded, encoded.track, frame

    def story(self, events: Sequence[Event]) -> str:
        """Return events as one clause after another, by when they begin."""
        clauses, told = [], list(events)
        pressed = _pressed_at_once(told)
        while told:
            one = told.pop(0)
            if one.kind is EventKind.TOUCH and pressed is not None:
                told.remove(pressed)
                clauses.append(f"{self.clause(one)} and {self._press(pressed)}")
            else:
                clauses.append(self.clause(one))
        kept = [one for one in events if one is not pressed]
        text = clauses[0]
        for (before, one), clause in zip(pairwise(kept), clauses[1:], strict=True):
            text += f"{'; meanwhile' if _overlap(before, one) else ', then'} {clause}"
        return text

    def largest(self, events: Sequence[Event]) -> list[Event]:
        """Return what is told of many events: where contact begins and ends, and the largest."""
        kept = sorted(
            events,
            key=lambda one: (one.kind not in ENDS_OF_CONTACT, -path_of_event(self._track, one)),
        )[:MOST_TOLD]
        return [one for one in events if one in kept]

    def in_order(self, events: Sequence[Event]) -> list[Event]:
        """Return what is worth telling, by when it begins; of the same moment the larger first.

        A span may cut off an event all but a part that does not count.
        """
        kept = [
            one
            for one in events
            if one.kind in (*ENDS_OF_CONTACT, EventKind.STICK)
            or path_of_event(self._track, one) >= COUNTING_PX
        ]
        found: list[Event] = []
        while kept:
            first_s = min(one.begin_s for one in kept)
            now = [one for one in kept if one.begin_s <= first_s + TOGETHER_S]
            kept = [one for one in kept if one not in now]
            now.sort(
                key=lambda one: (
                    one.kind is not EventKind.TOUCH,
                    one.kind is EventKind.RELEASE,
                    -path_of_event(self._track, one),
                )
            )
            found += now
        return found

    def clause(self, event: Event, *, with_time: bool = True) -> str:
        """Return an event as a clause: "it turns clockwise, about 58 degrees, from 1 s to 3 s"."""
        times = self._times(event) if with_time else ""
        if event.kind is EventKind.TOUCH:
            return f"it touches{times}"
        if event.kind is EventKind.STICK:
            return f"it is held still{times}"
        if event.kind is EventKind.RELEASE:
            return f"it lets go{times}" if event.begin == event.end else f"it lifts off{times}"
        amount = f", {self.amount(event).phrase}" if abs(event.amount.mean) > 0 else ""
        if event.kind is EventKind.PRESS:
            return f"it presses in{amount}{times}"
        who = "the sensor" if self._frame.actor == "sensor" else "it"
        verb = "slips" if event.kind is EventKind.SLIP else f"{event.component.value}s"
        return f"{who} {verb} {self._frame.tell(event.motion).value}{amount}{times}"

    def amount(self, event: Event) -> Amount:
        """Return how far an event goes, in the unit that is told."""
        far, deviation = abs(event.amount.mean), event.amount.deviation
        if event.component is Component.TURN:
            return Measure(far, deviation, "deg", TOLERANCES["deg"], "turning").amount()
        if event.component is Component.PRESS:
            return Measure(far, deviation, "mm", TOLERANCES["mm"], "pressing in").amount()
        unit, per_px = self.length_of(event)
        tolerance = TOLERANCES["px"] * per_px
        return Measure(far * per_px, deviation * per_px, unit, tolerance, "sliding").amount()

    def length_of(self, event: Event) -> tuple[str, float]:
        """Return the unit slides are told in, and how much of it a pixel along a slide is."""
        unit, scale = pixel_scale(self._encoded, self._frame)
        way = np.array([event.twist.right_px, event.twist.down_px])
        return unit, float(np.linalg.norm(scale @ way) / max(np.linalg.norm(way), 1e-9))

    def time(self, time_s: float) -> str:
        """Return a moment: "1.2 s", or "frame 31" of a recording without a frame rate."""
        if self._encoded.clip.is_timed:
            return seconds(time_s)
        place = min(int(np.searchsorted(self._track.times_s, time_s)), len(self._track) - 1)
        return f"frame {self._track.numbers[place]}"

    def long(self, duration_s: float) -> str:
        """Return a duration: "1.2 s", or "31 frames"."""
        if self._encoded.clip.is_timed:
            return seconds(duration_s)
        track = self._track
        step = np.median(np.diff(track.times_s)) / np.median(np.diff(track.numbers))
        return f"{round(duration_s / float(step))} frames"

    def _press(self, event: Event) -> str:
        amount = f", {self.amount(event).phrase}," if abs(event.amount.mean) > 0 else ""
        return f"presses in{amount} until {self.time(event.end_s)}"

    def _times(self, event: Event) -> str:
        begin, end = self.time(event.begin_s), self.time(event.end_s)
        return f" at {begin}" if begin == end else f", {times_of(self._encoded, [event])}"


def _pressed_at_once(events: Sequence[Event]) -> Event | None:
    """Return the press that the first touch told begins with."""
    touch = next((one for one in events if one.kind is EventKind.TOUCH), None)
    if touch is None:
        return None
    presses = (one for one in events if one.kind is EventKind.PRESS)
    return next((one for one in presses if abs(one.begin_s - touch.begin_s) <= TOGETHER_S), None)


def _overlap(before: Event, one: Event) -> bool:
    """Tell whether an event begins well before the one told before it is over."""
    return one.begin_s < before.end_s - TOGETHER_S
