"""Readings of a sliding window -> motion events with a start, an end and an amount.

A reading is the motion across the middle of its window, so that neighbouring readings overlap by
half: a motion of constant speed rises to half its speed just where it begins. Knows neither frames
nor files.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any, Literal

from geotlm_lm.core.labels import ROTATIONS, Motion, signed_amount

RESTING = (Motion.STILL, Motion.NONE)

VOTES = 2
"""Readings in a row that open an event, and that end it by saying something else."""

MEMORY = 6
"""Readings looked back over when an event opens: the votes, and as many as a window overlaps."""

EDGE_SHARE = 0.5
"""Share of a motion's speed at which it begins and ends."""


@dataclass(frozen=True)
class Reading:
    """What the model says of one window.

    Args:
        centre_s: Time in the middle of the window.
        sample_s: Time between two samples.
        motion: The most probable motion.
        probability: Of it, by the linear probe on the fused token.
        turn_deg: Turn per sample, positive clockwise as drawn.
        slide_x_px: Travel to the right per sample, pixels of the stream's frames.
        slide_y_px: Travel down the image per sample.
        growth_grey: Growth of the imprint per sample, grey levels (rms).
    """

    centre_s: float
    sample_s: float
    motion: Motion
    probability: float
    turn_deg: float = 0.0
    slide_x_px: float = 0.0
    slide_y_px: float = 0.0
    growth_grey: float = 0.0

    def along(self, motion: Motion) -> float:
        """Return how far the window goes the way `motion` names, in that motion's own unit."""
        far = signed_amount(
            motion,
            turn=self.turn_deg,
            right=self.slide_x_px,
            down=self.slide_y_px,
            inward=self.growth_grey,
        )
        if far is None:
            raise ValueError(f"{motion} goes no way")
        return far


@dataclass(frozen=True)
class MotionEvent:
    """One motion as it begins or ends; directions are those of the camera image, of the object.

    Args:
        phase: Whether it has just begun or is over.
        motion: What moves how.
        start_s: When it began, seconds into the stream.
        end_s: When it ended; None while it lasts.
        rotation_deg: Turn so far, positive clockwise as drawn.
        slide_x_px: Travel to the right so far, pixels of the stream's frames.
        slide_y_px: Travel down the image so far.
        probability: Mean of the readings that named it.
    """

    phase: Literal["start", "end"]
    motion: Motion
    start_s: float
    end_s: float | None
    rotation_deg: float
    slide_x_px: float
    slide_y_px: float
    probability: float

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return {
            "type": "motion",
            "phase": self.phase,
            "motion": self.motion.value,
            "start_s": round(self.start_s, 3),
            "end_s": None if self.end_s is None else round(self.end_s, 3),
            "rotation_deg": round(self.rotation_deg, 2),
            "slide_x_px": round(self.slide_x_px, 2),
            "slide_y_px": round(self.slide_y_px, 2),
            "probability": round(self.probability, 4),
        }

    def sentence(self) -> str:
        """Return the event as one line of words."""
        if self.end_s is None:
            return f"{self.start_s:8.2f} s  {self.motion.value} begins"
        lasted = f"in {self.end_s - self.start_s:.2f} s"
        return f"{self.end_s:8.2f} s  {self.motion.value} ends{self._amount()} {lasted}"

    def _amount(self) -> str:
        if self.motion in ROTATIONS:
            return f": {abs(self.rotation_deg):.1f} degrees"
        if self.motion in (Motion.PRESS, Motion.RELEASE):
            return ""
        return f": {(self.slide_x_px**2 + self.slide_y_px**2) ** 0.5:.1f} px"


class Segmenter:
    """Turns readings into events; one motion at a time."""

    def __init__(self) -> None:
        self._recent: deque[Reading] = deque(maxlen=MEMORY)
        self._motion: Motion | None = None
        self._start_s = 0.0
        self._readings: list[Reading] = []
        self._closed_s = float("-inf")

    def push(self, reading: Reading) -> list[MotionEvent]:
        """Take in the next reading and return the events it completes, oldest first."""
        events = []
        self._recent.append(reading)
        votes = list(self._recent)[-VOTES:]
        if self._motion is not None:
            self._readings.append(reading)
            if all(one.motion != self._motion for one in votes):
                events.append(self._close())
        agree = len(votes) == VOTES and all(one.motion == reading.motion for one in votes)
        if self._motion is None and agree and reading.motion not in RESTING:
            events.append(self._open(reading.motion))
        return events

    def finish(self) -> list[MotionEvent]:
        """Return the end of a motion that the stream's end cuts off."""
        return [] if self._motion is None else [self._close()]

    def _open(self, motion: Motion) -> MotionEvent:
        recent = [one for one in self._recent if one.centre_s > self._closed_s]
        # The last motion's end may cut into the votes.
        recent = recent or [self._recent[-1]]
        edge = EDGE_SHARE * max(one.along(motion) for one in recent)
        first = max(len(recent) - VOTES, 0)
        while first and recent[first - 1].along(motion) > max(edge, 0.0):
            first -= 1
        self._start_s = max(recent[first].centre_s - recent[first].sample_s / 2, self._closed_s)
        # One more reading rises to the edge; it holds a part of the motion.
        self._motion, self._readings = motion, recent[max(first - 1, 0) :]
        return self._event("start", None, self._readings)

    def _close(self) -> MotionEvent:
        motion, readings = self._motion, self._readings
        named = [place for place, one in enumerate(readings) if one.motion == motion]
        speeds = sorted(readings[place].along(motion) for place in named)
        edge = EDGE_SHARE * speeds[len(speeds) // 2]
        going = [place for place in named if readings[place].along(motion) > max(edge, 0.0)]
        # Where the geometry shows none of it, the readings alone say when it was.
        last = going[-1] if going else named[-1]
        end_s = max(readings[last].centre_s + readings[last].sample_s / 2, self._start_s)
        event = self._event("end", end_s, readings[: last + 2])
        self._motion, self._closed_s = None, end_s
        return event

    def _event(
        self, phase: Literal["start", "end"], end_s: float | None, amounts: list[Reading]
    ) -> MotionEvent:
        named = [one.probability for one in amounts if one.motion == self._motion]
        return MotionEvent(
            phase,
            self._motion,
            self._start_s,
            end_s,
            sum(one.turn_deg for one in amounts),
            sum(one.slide_x_px for one in amounts),
            sum(one.slide_y_px for one in amounts),
            sum(named) / len(named),
        )
