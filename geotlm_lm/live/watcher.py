"""Frames in, motion events out: the sliding window over a stream.

A window is four samples a fixed time apart, as many frames as an answer looks at. Every new sample
completes a window; the model perceives it only where something touches, and the language model not
at all. Measured on one thread of an AMD EPYC (medians, simulated 224 px frames): 17 ms a window,
1.9 ms for each frame's comparison with the idle gel. At 25 frames a second and a window every third
frame that is two tenths of one core; `geotlm-lm watch` prints both figures at its end.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import Motion
from geotlm_lm.live.events import MotionEvent, Reading, Segmenter
from geotlm_lm.recordings.imprints import FAINT_IMPRINT
from geotlm_lm.track.idle_tracker import IdleTracker

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer, Encoded

SAMPLE_S = 0.12
"""Time between samples: three frames of a GelSight Mini, so that a window spans 0.36 s. A hand that
twists by 90 degrees a second turns 32 degrees in it, within what the model was trained on."""

KEPT_SAMPLES = 64
"""Samples kept for a question about the motion that has just ended: 7.7 s, 15 MB at 320x240."""

WHOLE_WINDOW = 1.5
"""The shear changes from the mean of the first two samples to that of the last two: two steps of
the three between the first and the last."""

WITHOUT_DIRECTION = (Motion.PRESS, Motion.RELEASE, Motion.STILL, Motion.NONE)
"""What a window may be that is untouched in part: no direction can be read from no contact."""


NO_IDLE = "No untouched gel was seen, so nothing could be judged; start while nothing touches."


@dataclass(frozen=True, eq=False)
class Window:
    """What the model says of four samples.

    Args:
        motion: The most probable of the motions asked about.
        probability: Of it.
        turn_deg: Turn from the first sample to the last, clockwise.
        slide_x_px: Travel between the same, to the right, pixels of the frames.
        slide_y_px: Travel down the image.
        encoded: Everything that was perceived, for whoever draws it; None where that shows no
            contact.
    """

    motion: Motion
    probability: float
    turn_deg: float = 0.0
    slide_x_px: float = 0.0
    slide_y_px: float = 0.0
    encoded: Any = None


ReadWindow = Callable[[Clip, Sequence[Motion]], Window]
"""Four frames with a background, and the motions in question, to what the model says."""


@dataclass
class StreamStatistics:
    """How a stream was kept up with.

    Args:
        frames: Frames taken in.
        windows: Windows the model perceived.
        perceive_ms: Milliseconds of each of them.
        follow_ms: Milliseconds of each frame's comparison with the idle gel.
    """

    frames: int = 0
    windows: int = 0
    perceive_ms: list[float] = field(default_factory=list)
    follow_ms: list[float] = field(default_factory=list)

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values: medians, and the windows per second they allow."""
        perceive, follow = (
            float(np.median(values)) if values else 0.0
            for values in (self.perceive_ms, self.follow_ms)
        )
        return {
            "frames": self.frames,
            "windows": self.windows,
            "window_ms_median": round(perceive, 2),
            "frame_ms_median": round(follow, 3),
        }


@dataclass(frozen=True, eq=False)
class Sample:
    """One frame of a window."""

    frame: Frames
    time_s: float
    strength: float

    @property
    def is_touched(self) -> bool:
        """Whether something touches the gel."""
        return self.strength > FAINT_IMPRINT


class Watcher:
    """Follows one stream.

    Args:
        read: What names the motion of a window; `model_reader` makes it of an `Answerer`.
        sample_s: Time between samples.
    """

    def __init__(self, read: ReadWindow, sample_s: float = SAMPLE_S) -> None:
        self._read, self._sample_s = read, sample_s
        self._idle, self._segmenter = IdleTracker(), Segmenter()
        self._samples: deque[Sample] = deque(maxlen=KEPT_SAMPLES)
        self._due_s = float("-inf")
        self.account = StreamStatistics()
        self.perceived: Any = None
        """What the model saw in the last window; None while nothing touches."""

    @property
    def background(self) -> Frames | None:
        """The idle gel as learnt so far; None while it is being learnt."""
        return self._idle.background

    @property
    def warning(self) -> str | None:
        """Why no motion could be told so far, in one sentence; None where it could."""
        return NO_IDLE if self.background is None else None

    def push(self, frame: Frames, time_s: float) -> list[MotionEvent]:
        """Take in the next frame and return the events it completes.

        Args:
            frame: uint8, shape (rows, columns, 3), RGB; all of one size.
            time_s: When it was taken; later than the frame before.

        Raises:
            UnreadableClip: If it is of another size than the frames before.
        """
        started = time.perf_counter()
        strength = self._idle.strength(frame)
        self.account.frames += 1
        self.account.follow_ms.append(1e3 * (time.perf_counter() - started))
        if strength is None or time_s < self._due_s - _JITTER_S:
            return []
        # A late frame does not delay the ones after it; after a gap, counting starts anew.
        on_time = time_s - self._due_s < self._sample_s
        self._due_s = (self._due_s if on_time else time_s) + self._sample_s
        self._samples.append(Sample(frame, time_s, strength))
        return self._segmenter.push(self._reading()) if len(self._samples) >= FRAME_COUNT else []

    def finish(self) -> list[MotionEvent]:
        """Return the end of a motion that the stream's end cuts off."""
        return self._segmenter.finish()

    def clip_of(self, event: MotionEvent) -> Clip | None:
        """Return the samples of a motion that ended, with the idle gel; None if they are gone.

        Its frame rate is their mean one.
        """
        kept = [s for s in self._samples if event.start_s <= s.time_s <= (event.end_s or np.inf)]
        if len(kept) < 2:
            return None
        frames = np.stack([sample.frame for sample in kept])
        lasted_s = kept[-1].time_s - kept[0].time_s
        return Clip(
            frames,
            fps=(len(kept) - 1) / lasted_s if lasted_s > 0 else None,
            background=self.background,
            name=f"{event.motion.value} of the stream",
        )

    def _reading(self) -> Reading:
        window = list(self._samples)[-FRAME_COUNT:]
        touched = [sample.is_touched for sample in window]
        first, second, third, last = (sample.strength for sample in window)
        seen = Window(Motion.NONE, 1.0)
        if any(touched):
            frames = np.stack([sample.frame for sample in window])
            clip = Clip(frames, background=self.background, name="stream")
            started = time.perf_counter()
            seen = self._read(clip, tuple(Motion) if all(touched) else WITHOUT_DIRECTION)
            self.account.windows += 1
            self.account.perceive_ms.append(1e3 * (time.perf_counter() - started))
        self.perceived = seen.encoded
        steps = FRAME_COUNT - 1
        return Reading(
            centre_s=(window[0].time_s + window[-1].time_s) / 2,
            sample_s=(window[-1].time_s - window[0].time_s) / steps,
            motion=seen.motion,
            probability=seen.probability,
            turn_deg=seen.turn_deg / steps,
            slide_x_px=seen.slide_x_px / steps,
            slide_y_px=seen.slide_y_px / steps,
            growth_grey=(third + last - first - second) / 4,
        )


_JITTER_S = 0.002
"""A frame this much early still counts as on time."""


def model_reader(answerer: Answerer) -> ReadWindow:
    """Return what reads a window with the model's linear probe; no word is generated.

    How far a turn or a slide goes is what is believed of the clip. Of other motions degrees and
    pixels are the rigid motion in the learned shear change, which is physical where DGR was trained
    with the simulator's true displacement, as in the bundle that ships.
    """
    from geotlm_lm.answering.abstention import shows_contact
    from geotlm_lm.answering.measured_motion import amount_along

    def read(clip: Clip, among: Sequence[Motion]) -> Window:
        try:
            encoded = answerer.encode(clip)
        except UnreadableClip:  # a flash or a covered lens must not end the stream
            return Window(Motion.NONE, 0.0)
        token = encoded.perception.fused_token
        odds = answerer.bundle.model.probe.probabilities(token, among)[0].tolist()
        best = int(np.argmax(odds))
        motion = among[best]
        if answerer.bundle.calibration.withholds(motion, encoded.contact_share):
            motion = Motion.STILL
        went = amount_along(encoded, motion) or learned_motion(encoded)
        drawn = encoded if shows_contact(answerer.bundle, encoded) else None
        return Window(motion, odds[best], *went, drawn)

    return read


def learned_motion(encoded: Encoded) -> tuple[float, float, float]:
    """Return the rigid motion in the learned shear change: degrees, px to the right, px down.

    From the first of four frames evenly apart to the last; pixels are those of the clip's own
    frames.
    """
    from geotlm_lm.model import rigid_motion  # by now it is loaded; a stream alone needs none

    size = encoded.clip.frames.shape[1:3]
    turn_deg, x, y = rigid_motion(encoded.perception.geometry, encoded.view, size)
    return WHOLE_WINDOW * turn_deg, WHOLE_WINDOW * x, WHOLE_WINDOW * y
