"""One stream that is watched: what of it is kept, shown on the stage, and asked about."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from geotlm_lm import (
    Clip,
    GeoTLMError,
    StuckPicture,
    Units,
    camera_size,
    change_map,
    drawing_of,
)

from .budget import WORKING
from .clip_loading import Image, LoadedClip, perceive
from .stage import jpeg_address
from .timeline import Axis, timeline_of

if TYPE_CHECKING:
    from geotlm_lm import Answerer

WINDOW_S = 30.0
"""Time that the timeline shows while frames arrive; once they end it shows all."""

FIRST_WINDOW_S = 6.0
"""Time that it has room for at first: it grows from there."""

SIDE, QUALITY = 448, 75
"""Longer side (pixels) and JPEG quality of what is shown."""

IDLE_AGAIN_S = 5.0
"""Time after which the idle gel is sent anew: it is followed as the light drifts."""

NOTES_FROM_S = 3.0
"""Time from which on what is amiss is told: the idle gel is learnt before."""

KEPT_BYTES = 32 * 2**20
"""Of frames kept for questions, of each stream; of more every second one is dropped."""

LEAST_FRAMES = 5
"""Fewer are no recording: they would be taken for the four frames of a clip."""

LEAST_KEPT = 3 * LEAST_FRAMES
"""Frames that are kept however large they are: of half of them enough are settled."""

WATCH_FIRST = "Nothing was watched yet; start the camera or a recording first."


class LiveStream:
    """Follows the frames of one camera or recording.

    Args:
        answerer: The model.
        name: As the page calls it.
        shape: Of each frame.
        is_camera: Whether it goes on for as long as it likes.
    """

    def __init__(
        self, answerer: Answerer, name: str, shape: Sequence[int], *, is_camera: bool = False
    ) -> None:
        WORKING.take(KEPT_BYTES).keep_with(self)
        self.name, self.shape, self.is_camera = name, tuple(shape), is_camera
        self.key, self.count, self.is_over = secrets.token_hex(4), 0, False
        self._answerer, self._tracker = answerer, answerer.tracker()
        self._kept: list[tuple[int, Image]] = []
        self._apart, self._stuck = 1, StuckPicture()
        self._now_s = self._idle_sent_s = -np.inf
        self._shown: tuple[tuple[int, bool], LoadedClip] | None = None
        self._talk: LoadedClip | None = None

    def feed(self, frame: Image, time_s: float, number: int | None = None) -> list[Any]:
        """Take in the next frame, as `Tracker.feed`, and return the events that are over."""
        number = self.count if number is None else number
        events = self._tracker.feed(frame, time_s, number)
        if self.is_camera:
            self._stuck.after(frame, time_s)
        if self.count % self._apart == 0:
            self._kept.append((number, frame))
            if len(self._kept) > LEAST_KEPT and len(self._kept) * frame.nbytes > KEPT_BYTES:
                self._kept, self._apart = self._kept[::2], 2 * self._apart
        self.count += 1
        self._now_s = time_s
        return events

    def finish(self) -> None:
        """Take the last events as the end cuts them off; nothing is fed after that."""
        self._tracker.finish()
        self.is_over = True

    def stage(self, frame: Image | None = None, mm_per_px: float | None = None) -> dict[str, Any]:
        """Return what the stage shows now, as plain JSON values; it keeps the pictures before.

        Args:
            frame: The last one that was fed; None adds no picture.
            mm_per_px: Size of a pixel; None tells travel in pixels.
        """
        track, units = self._tracker.so_far, Units(self.shape[:2], mm_per_px)
        since_s = -np.inf if self.is_over else self._now_s - WINDOW_S
        drawing = drawing_of(track, units)
        if not self.is_over:
            drawing = drawing.up_to(self._now_s, self._tracker.way)
        idle = self._tracker.idle
        rows, columns = camera_size(*self.shape[:2])
        first_s, last_s = self._window()
        tells_notes = self.is_over or self._now_s > NOTES_FROM_S
        return {
            "key": secrets.token_hex(4),
            "stream": self.key,
            "live": not self.is_over,
            "name": self.name,
            "about": self._about(idle),
            "aspect": columns / rows,
            "unit": "s",
            "loops": False,
            "window": [round(first_s, 3), round(last_s, 3)],
            "timeline": timeline_of(drawing, Axis(True), since_s),
            "picture": None if frame is None else self._picture(frame, idle),
            "idle": self._idle_to_send(idle),
            "notes": [*filter(None, [self._stuck.note]), *(track.notes if tells_notes else ())],
            "overlays": {
                "contact": {
                    "corners": [[0, 0], [1, 1]],
                    "told": "red: where the gel has changed",
                },
                "fields": [],
            },
        }

    def shown(self) -> LoadedClip:
        """Return what was seen so far, ready for questions; the conversation goes on.

        Raises:
            GeoTLMError: If nothing was seen yet.
        """
        track = self._tracker.so_far
        kept = [one for one in self._kept if len(track) and one[0] <= track.numbers[-1]]
        if len(kept) < LEAST_FRAMES:
            raise GeoTLMError(WATCH_FIRST)
        seen = len(track), self.is_over  # its end cuts off the last events
        before, talk = self._shown, self._talk
        if before is not None and before[0] == seen:
            return before[1]
        numbers, frames = zip(*kept, strict=True)
        span_s = float(track.times_s[-1] - track.times_s[0])
        rate = (int(track.numbers[-1]) - int(track.numbers[0])) / span_s
        clip = Clip(np.stack(frames), rate, self._tracker.idle, self.name, numbers)
        grown = perceive(self._answerer, clip, track=track)
        # Each question looks at other frames: of all of them the conversation keeps four.
        encoded = replace(grown.encoded, recording=None)
        if talk is None:
            session = self._answerer.session(encoded)
        else:
            session = talk.session
            session.grow(encoded)
        grown = replace(grown, encoded=encoded, session=session)
        self._shown, self._talk = (seen, grown), grown
        return grown

    def forget_talk(self) -> None:
        """Begin the conversation anew with the next question."""
        self._shown = self._talk = None

    def _window(self) -> tuple[float, float]:
        if self.is_over:
            return 0.0, self._now_s or FIRST_WINDOW_S  # of a single frame
        return max(self._now_s - WINDOW_S, 0.0), max(self._now_s, FIRST_WINDOW_S)

    def _about(self, idle: Image | None) -> str:
        learnt = "idle gel learnt" if idle is not None else "learning the idle gel"
        return f"{learnt} · {self.count} frames"

    def _picture(self, frame: Image, idle: Image | None) -> dict[str, Any]:
        touched = None if idle is None else change_map(frame, idle).round(2).tolist()
        return {
            "at": round(self._now_s, 3),
            "number": self.count - 1,
            "image": jpeg_address(frame, SIDE, QUALITY),
            "touched": touched,
        }

    def _idle_to_send(self, idle: Image | None) -> str | None:
        if idle is None or self._now_s - self._idle_sent_s < IDLE_AGAIN_S:
            return None
        self._idle_sent_s = self._now_s
        return jpeg_address(idle, SIDE, QUALITY)
