"""A stream followed to its end: events printed as they are over, frames drawn as they come."""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import closing, nullcontext
from pathlib import Path
from typing import Any

from geotlm_lm.answering import Answerer
from geotlm_lm.cli.tracked import HEAD, NO_EVENTS, aligned, event_line, totals_lines
from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import GeoTLMError, UnreadableClip
from geotlm_lm.core.process import uninterrupted_step
from geotlm_lm.recordings.pixels import with_square_pixels
from geotlm_lm.recordings.streams import StreamFrame, StuckPicture
from geotlm_lm.track.events import Event, EventKind
from geotlm_lm.track.export import Exported, Units
from geotlm_lm.track.film import TOLD_S, caption, captioned, filming
from geotlm_lm.track.recent import RecentFrames


class Watching:
    """Follows one stream to its end and tells what happens as it is over.

    Args:
        answerer: The model.
        stream: Frames with their times and numbers.
        question: Asked about every motion that ends; None asks none.
        mm_per_px: As of `Units`.
        as_json: Whether lines are JSON objects.
    """

    def __init__(
        self,
        answerer: Answerer,
        stream: Any,
        question: str | None,
        mm_per_px: float | None,
        *,
        as_json: bool,
    ) -> None:
        self._answerer, self._stream, self._question = answerer, stream, question
        self._mm_per_px, self._as_json = mm_per_px, as_json
        self.tracker = answerer.tracker()
        self._recent = RecentFrames(stream.fps)
        self._told: list[Event] = []
        self._shown: list[Event] = []
        self._shown_s = -math.inf
        self._frames, self._busy_s = 0, 0.0
        self._stuck = StuckPicture() if stream.is_live else None

    def follow(self, video: Path | None, *, is_square: bool) -> BaseException | None:
        """Track the stream until it ends; return what ended it before, if anything did.

        Args:
            video: Where each frame is drawn to as it comes, if anywhere.
            is_square: Whether the camera's pixels are square though its frames are of 224 x 224.
        """
        film = nullcontext() if video is None else filming(video, self._stream.fps)
        # Closed even where nobody reads on: a camera's thread must not outlive the command.
        with film as write, closing(iter(self._stream)) as frames:
            try:
                for frame in frames:
                    image = with_square_pixels(frame.image) if is_square else frame.image
                    with uninterrupted_step():
                        events = self._take(image, frame, write)
                    self._tell(events, Units(image.shape[:2], self._mm_per_px))
            except (KeyboardInterrupt, GeoTLMError) as error:
                return error
        return None

    def conclude(self, exported: Exported) -> None:
        """Tell the events that the end cuts off, what it all comes to, and how it was kept up."""
        told = set(map(id, self._told))
        rest = [one for one in exported.track.events if id(one) not in told]
        self._tell(rest, exported.units)
        frames, dropped = self._frames, self._stream.dropped
        frame_ms = round(1e3 * self._busy_s / max(frames, 1), 2)
        if self._as_json:
            account = {"frames": frames, "dropped": dropped, "frame_ms": frame_ms}
            whole = {"totals": exported.totals(), "notes": list(exported.track.notes)}
            print(json.dumps({"type": "account"} | account | whole), flush=True)
            return
        lines = ["", *totals_lines(exported)] if self._told else [NO_EVENTS]
        print("\n".join(lines), flush=True)
        lost = f"{dropped} dropped" if dropped else "none dropped"
        account = f"{frames} frames, {lost}; each tracked in {frame_ms:.1f} ms."
        for note in (*exported.track.notes, account):
            print(f"note: {note}", file=sys.stderr)

    def _take(
        self, image: Frames, frame: StreamFrame, write: Callable[[Frames], None] | None
    ) -> list[Event]:
        stuck = self._stuck and self._stuck.after(image, frame.time_s)
        if stuck:
            print(f"note: {stuck}", file=sys.stderr, flush=True)
        started = time.perf_counter()
        events = self.tracker.feed(image, frame.time_s, frame.number)
        self._busy_s += time.perf_counter() - started
        self._frames += 1
        if self._question is not None:
            self._recent.add(image, frame.number, frame.time_s)
        if write is not None:
            units = Units(image.shape[:2], self._mm_per_px)
            if events or frame.time_s - self._shown_s > TOLD_S:
                self._shown, self._shown_s = events, frame.time_s
            told = caption(self._shown, units)
            write(captioned(image, self.tracker.way, units, frame.time_s, told))
        return events

    def _tell(self, events: Sequence[Event], units: Units) -> None:
        for event in events:
            words = self._words(event)
            if self._as_json:
                told = {"type": "event"} | units.event(event)
                line = json.dumps(told | ({} if words is None else {"answer": words}))
            else:
                line = event_line(event, units) + (f"  {words}" if words else "")
                line = line if self._told else f"{aligned(HEAD)}\n{line}"
            print(line, flush=True)
            self._told.append(event)

    def _words(self, event: Event) -> str | None:
        """Return the answer about a motion that is over; None of what is none or not kept."""
        is_motion = event.component is not None and event.kind is not EventKind.SLIP
        if self._question is None or not is_motion or event.begin == event.end:
            return None
        clip = self._recent.clip_of(event, self.tracker.idle)
        if clip is None:
            return None
        part = self.tracker.so_far.between(event.begin, event.end)
        try:
            return self._answerer.ask(self._answerer.encode(clip, track=part), self._question).text
        except UnreadableClip as error:
            return f"I cannot read this motion's frames: {error}"
