"""`geotlm-lm watch`: what happens at a sensor, or in a recording played, as it happens.

Conditions that it waits for, and what is done when one holds, are here as well.
"""

from __future__ import annotations

import json
import math
import shlex
import shutil
import subprocess
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from geotlm_lm.cli.options import (
    Answering,
    Pixels,
    TrackOutputs,
    argument,
    grouped,
    option,
    path_of,
)
from geotlm_lm.cli.progress import print_notes
from geotlm_lm.cli.track import (
    HEAD,
    INTERRUPTED,
    NO_EVENTS,
    NO_MOTION,
    aligned,
    event_line,
    totals_lines,
    write_table_and_plot,
)
from geotlm_lm.core.errors import (
    GeoTLMError,
    NotReached,
    TimedOut,
    UnreadableClip,
    UsageError,
    check_question,
)
from geotlm_lm.core.process import uninterrupted_step

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer
    from geotlm_lm.answering.monitor import Monitor, Verdict
    from geotlm_lm.core.clip import Frames
    from geotlm_lm.core.frame_spec import FrameSpec
    from geotlm_lm.recordings.streams import StreamFrame
    from geotlm_lm.track.events import Event
    from geotlm_lm.track.export import Exported, Units
    from geotlm_lm.track.tracker import Tracker

KEPT_FRAMES, APART_S, JITTER_S = 64, 0.08, 0.002
"""Frames kept for a question about a motion that is over: 15 MB at 320x240. At least so far apart,
they reach back over 5 s; one that is a little early still counts as on time."""

HELD_S = 1.0
"""Time after its end for which an event waits for others that ended before it."""


def _end_of(event: Event) -> tuple[float, float]:
    return event.end_s, event.begin_s


@dataclass(frozen=True)
class Conditions:
    """What is waited for."""

    until: list[str] | None = option(
        "End with exit code 0 once this holds: 'it has turned 30 degrees clockwise', 'it slips by "
        "more than 0.5 mm', 'contact is lost'. Of several the first ends it."
    )
    while_: list[str] | None = option("End with exit code 0 once this holds no more.", "--while")
    every: list[str] | None = option(
        "Print each time that this begins to hold, counted from the last time."
    )
    run: str | None = option(
        "Start this each time that --every holds, without a shell; it reads the verdict as JSON "
        "from its input.",
        metavar="COMMAND",
    )
    sure: float = option("Probability with which a condition has to hold.", default=0.95)
    lasting: float = option("Seconds for which it has to hold.", "--for", default=0.0)
    timeout: float | None = option(
        "Seconds of the stream after which --until ends with exit code 8."
    )

    @property
    def is_any(self) -> bool:
        """Whether anything is waited for."""
        return bool(self.until or self.while_ or self.every)

    @property
    def is_ending(self) -> bool:
        """Whether the command ends once something holds."""
        return bool(self.until or self.while_)

    def require(self) -> None:
        """Refuse options that do not go together, and a command that is not there.

        Raises:
            UsageError: Then.
        """
        if self.run is not None and not self.every:
            raise UsageError("--run starts a command whenever --every holds; give --every as well.")
        if self.timeout is not None and not self.is_ending:
            raise UsageError("--timeout ends --until and --while; give one of them as well.")
        if self.timeout is not None and not self.timeout > 0:
            raise UsageError(f"--timeout {self.timeout:g} was given, expected more than 0 seconds.")
        if self.run is not None and not shutil.which(self.command[0]):
            raise UsageError(
                f"--run: there is no program '{self.command[0]}' to be started; give its path."
            )

    @property
    def command(self) -> list[str]:
        """The words of --run.

        Raises:
            UsageError: If a quotation mark is left open, or there is none.
        """
        try:
            words = shlex.split(self.run or "")
        except ValueError as error:
            raise UsageError(f"--run '{self.run}' cannot be split into words: {error}.") from error
        if not words:
            raise UsageError("--run was given no command.")
        return words


@grouped
def watch(
    *,
    source: str = argument(
        "SOURCE", "A camera's number, its device file, or a recording.", "--source"
    ),
    as_json: bool = option(
        "Print one JSON object a line, the account last.", "--json", default=False
    ),
    outputs: TrackOutputs,
    question: str | None = option("Ask this about every motion that ends.", "--q"),
    at_its_rate: bool = option(
        "Play a recording as a camera would, dropping frames.", "--at-its-rate", default=False
    ),
    conditions: Conditions,
    pixels: Pixels,
    stalled_after: float = option(
        "Seconds without a frame of a camera after which it ends, with exit code 10.", default=10.0
    ),
    answering: Answering,
) -> None:
    """Print what touches when and how it moves, until the recording ends or Ctrl-C.

    A camera that gives no frames any more is told after 2 seconds, and ends it after 10.

    Before a camera the gel must be untouched at the start, or for half a second later on.
    Directions are told as seen in the camera image, for the object relative to the sensor.

    With --until, --while or --every it waits for a condition in words, and tells when it holds, how
    sure that is and what it rests on. Exit codes: 0 it holds, 8 the time is out, 9 the recording
    ended before, 10 the camera is lost.

    Example: geotlm-lm watch recording.avi --json

    Example: geotlm-lm watch 0 --until "it slips by more than 0.5 mm" --mm-per-px 0.06
    """
    conditions.require()
    if question is not None:
        check_question(question)
    outputs.require([path_of(source)])
    if not stalled_after > 0:
        raise UsageError(
            f"--stalled-after {stalled_after:g} was given, expected more than 0 seconds; leave it "
            f"out for 10, or give inf to wait without end."
        )
    from geotlm_lm.recordings.streams import Patience, open_source

    def silent(seconds: float) -> None:
        print_notes(f"No frame of {source} for {seconds:g} s.")

    scale, patience = answering.frame.mm_per_px, Patience(stalled_after, silent)
    waiting = None
    if conditions.is_any:  # what is not understood is refused before a camera opens
        waiting = Waiting(conditions, answering.load(), answering.frame)
    stream = open_source(source, at_its_rate=at_its_rate, patience=patience, **vars(pixels))

    # Imported only now: a camera that does not open must not wait for the model's libraries.
    from geotlm_lm.track.export import Exported

    answerer = answering.load() if waiting is None else waiting.answerer
    assumed = ", as is assumed; give the rate by --fps" if stream.is_rate_assumed else ""
    rate = f"{source} at {stream.fps:g} frames per second{assumed}."
    print_notes(rate, *stream.notes, *(() if waiting is None else waiting.notes()))
    # Of a recording the idle gel is looked for in all of it, as `track` does.
    whole = None if stream.is_live or at_its_rate else stream.whole()
    tracker = answerer.tracker(whole)
    if waiting is not None:
        waiting.follow(tracker)
    watching = Watching(
        answerer, tracker, stream, question, scale, as_json=as_json, waiting=waiting
    )
    ended = watching.follow(outputs.video, is_square=bool(pixels.square_pixels))
    track = watching.tracker.finish()
    exported = Exported(track if whole is None else answerer.seen_closely(whole, track), scale)
    if waiting is None or as_json:
        watching.conclude(exported)
    if len(exported.track):
        write_table_and_plot(outputs, exported, stream.name, stream.fps, in_frames=False)
    if isinstance(ended, GeoTLMError):
        raise ended
    if ended is not None:
        raise typer.Exit(INTERRUPTED)
    if waiting is not None:
        waiting.require_met()


class Watching:
    """Follows one stream to its end and prints what happens as it is over.

    The question is asked about every motion that ends; None asks none.
    """

    def __init__(
        self,
        answerer: Answerer,
        tracker: Tracker,
        stream: Any,
        question: str | None,
        mm_per_px: float | None,
        *,
        as_json: bool,
        waiting: Waiting | None = None,
    ) -> None:
        from geotlm_lm.recordings.streams import StuckPicture

        self._answerer, self._stream, self._question = answerer, stream, question
        self._mm_per_px, self._as_json = mm_per_px, as_json
        self._waiting = waiting
        self.tracker = tracker
        self._recent: deque[tuple[StreamFrame, Frames]] = deque(maxlen=KEPT_FRAMES)
        self._held: list[Event] = []
        self._printed: list[Event] = []
        self._shown: list[Event] = []
        self._shown_s = -math.inf
        self._frames, self._busy_s = 0, 0.0
        self._stuck = StuckPicture() if stream.is_live else None

    def follow(self, video: Path | None, *, is_square: bool) -> BaseException | None:
        """Track the stream, and draw it to a video; return what ended it early, if anything did.

        Args:
            video: The file, if any.
            is_square: Whether the camera's picture is square where its frames are of 224 x 224.
        """
        from geotlm_lm.recordings.pixels import with_square_pixels
        from geotlm_lm.track.drawing import filming
        from geotlm_lm.track.export import Units

        film = nullcontext() if video is None else filming(video, self._stream.fps)
        # Closed even where nobody reads on: a camera's thread must not outlive the command.
        with film as write, closing(iter(self._stream)) as frames:
            try:
                for frame in frames:
                    image = with_square_pixels(frame.image) if is_square else frame.image
                    units = Units(image.shape[:2], self._mm_per_px)
                    with uninterrupted_step():
                        events = self._take(image, frame)
                        if write is not None:
                            self._film(image, frame.time_s, events, units, write)
                    if self._waiting is None or self._as_json:
                        self._print(self._due(events, frame.time_s), units)
                    if self._waiting is not None and self._waiting.look(
                        frame.time_s, frame.number, as_json=self._as_json
                    ):
                        break
            except (KeyboardInterrupt, GeoTLMError) as error:
                return error
        return None

    def conclude(self, exported: Exported) -> None:
        """Print the events that the end cuts off, what it all comes to, and how it was kept up."""
        printed = {(event.kind, event.component, event.begin) for event in self._printed}
        rest = [
            event
            for event in exported.track.events
            if (event.kind, event.component, event.begin) not in printed
        ]
        self._print(sorted(rest, key=_end_of), exported.units)
        frames, dropped = self._frames, self._stream.dropped
        frame_ms = round(1e3 * self._busy_s / max(frames, 1), 2)
        if self._as_json:
            account = {"frames": frames, "dropped": dropped, "frame_ms": frame_ms}
            whole = {"totals": exported.totals(), "notes": list(exported.track.notes)}
            print(json.dumps({"type": "account"} | account | whole), flush=True)
            return
        track = exported.track
        if self._printed:
            print("\n".join(["", *totals_lines(exported)]), flush=True)
        elif self.tracker.idle is not None:  # without an idle gel nothing was judged
            print(NO_EVENTS if track.is_contact_known else NO_MOTION, flush=True)
        lost = f"{dropped} dropped" if dropped else "none dropped"
        account = f"{frames} frames, {lost}; each tracked in {frame_ms:.1f} ms."
        print_notes(*track.notes, account)

    def _due(self, events: list[Event], now_s: float) -> list[Event]:
        """Return the events that are to be printed now: by when they end, each once it is over."""
        self._held = sorted([*self._held, *events], key=_end_of)
        due = [event for event in self._held if now_s - event.end_s >= HELD_S]
        self._held = self._held[len(due) :]
        return due

    def _take(self, image: Frames, frame: StreamFrame) -> list[Event]:
        stuck = self._stuck and self._stuck.after(image, frame.time_s)
        if stuck:
            print_notes(stuck)
        started = time.perf_counter()
        events = self.tracker.feed(image, frame.time_s, frame.number)
        self._busy_s += time.perf_counter() - started
        self._frames += 1
        last_s = self._recent[-1][0].time_s if self._recent else -math.inf
        if self._question is not None and frame.time_s - last_s >= APART_S - JITTER_S:
            self._recent.append((frame, image))
        return events

    def _film(
        self,
        image: Frames,
        time_s: float,
        events: list[Event],
        units: Units,
        write: Callable[[Frames], None],
    ) -> None:
        from geotlm_lm.track.drawing import CAPTION_S, band_of, draw_mark, mark_of

        if events or time_s - self._shown_s > CAPTION_S:
            self._shown, self._shown_s = events, time_s
        bands = [band_of(event, units) for event in self._shown]
        write(draw_mark(image, mark_of(self.tracker.way, units, time_s, bands)))

    def _print(self, events: Sequence[Event], units: Units) -> None:
        for event in events:
            words = self._words(event)
            if self._as_json:
                plain = {"type": "event"} | units.event(event)
                line = json.dumps(plain | ({} if words is None else {"answer": words}))
            else:
                line = event_line(event, units) + (f"  {words}" if words else "")
                line = line if self._printed else f"{aligned(HEAD)}\n{line}"
            print(line, flush=True)
            self._printed.append(event)

    def _words(self, event: Event) -> str | None:
        """Return the answer about a motion that is over; None of what is none or not kept."""
        import numpy as np

        from geotlm_lm.core.clip import Clip

        is_motion = event.component is not None and event.kind.value != "slip"
        kept = [(frame.number, image) for frame, image in self._recent
                if event.begin <= frame.number <= event.end]  # fmt: skip
        if not is_motion or event.begin == event.end or len(kept) < 2:
            return None
        numbers, images = zip(*kept, strict=True)
        name = f"the {event.kind.value} of the stream"
        clip = Clip(np.stack(images), self._stream.fps, self.tracker.idle, name, numbers)
        part = self.tracker.so_far.between(event.begin, event.end)
        try:
            return self._answerer.ask(self._answerer.encode(clip, track=part), self._question).text
        except UnreadableClip as error:
            return f"I cannot read this motion's frames: {error}"


class Waiting:
    """Looks at every frame whether what is waited for holds; conditions are understood first.

    Raises:
        UsageError: If a condition is refused.
    """

    def __init__(self, conditions: Conditions, answerer: Answerer, frame: FrameSpec) -> None:
        from geotlm_lm.answering.monitor import Monitor

        self.answerer = answerer
        how = {"sure": conditions.sure, "lasting_s": conditions.lasting}

        def monitors(texts: list[str] | None, *, is_negated: bool = False, **more: Any) -> list:
            read = (answerer.condition(t, frame=frame, is_negated=is_negated) for t in texts or ())
            return [partial(Monitor, condition=condition, **how, **more) for condition in read]

        self._of_ending = [
            *monitors(conditions.until),
            *monitors(conditions.while_, is_negated=True),
        ]
        self._of_repeated = monitors(conditions.every, since="last")
        self._ending, self._repeated = [], []
        self._command = conditions.command if conditions.run else []
        self._timeout_s = math.inf if conditions.timeout is None else conditions.timeout
        self._started: list[subprocess.Popen] = []
        self._begin_s: float | None = None
        self.is_met = False

    def follow(self, tracker: Tracker) -> None:
        """Judge what this tracker follows."""
        self._ending = [monitor(tracker) for monitor in self._of_ending]
        self._repeated = [monitor(tracker) for monitor in self._of_repeated]

    def notes(self) -> Iterator[str]:
        """Yield how each condition was read."""
        for monitor in self._of_ending:
            yield f"Waiting until {monitor.keywords['condition'].restated}."
        for monitor in self._of_repeated:
            yield f"Telling each time that {monitor.keywords['condition'].restated}."

    def look(self, time_s: float, number: int, *, as_json: bool) -> bool:
        """Judge the frame that was tracked last; return whether waiting is over.

        Raises:
            TimedOut: If it took too long.
        """
        self._begin_s = time_s if self._begin_s is None else self._begin_s
        for monitor in (*self._ending, *self._repeated):
            verdict = monitor.judged(time_s, number)
            if verdict.is_new:
                _print_verdict(monitor, verdict, as_json=as_json)
                if monitor in self._repeated:
                    self._start(monitor, verdict)
                self.is_met |= monitor in self._ending
        if self.is_met:
            return True
        if time_s - self._begin_s > self._timeout_s:
            raise TimedOut(
                f"{self._unmet()} did not hold within {self._timeout_s:g} s; wait longer by "
                f"--timeout, or look at what was seen by leaving --until out."
            )
        return False

    def require_met(self) -> None:
        """Refuse that the stream ended before what should end it.

        Raises:
            NotReached: Then.
        """
        for each in self._started:
            each.wait()
        if self._ending and not self.is_met:
            raise NotReached(f"{self._unmet()} did not hold before the recording ended.")

    def _unmet(self) -> str:
        return "That " + ", or that ".join(each.condition.restated for each in self._ending)

    def _start(self, monitor: Monitor, verdict: Verdict) -> None:
        if not self._command:
            return
        text = json.dumps({"condition": monitor.condition.text} | verdict.to_dict())
        try:
            started = subprocess.Popen(self._command, stdin=subprocess.PIPE, text=True)  # noqa: S603
        except OSError as error:
            raise UsageError(f"--run: {self._command[0]} does not start: {error}.") from error
        try:
            with started.stdin as stream:
                stream.write(text)
        except BrokenPipeError:  # it reads nothing
            pass
        self._started = [each for each in (*self._started, started) if each.poll() is None]


def _print_verdict(monitor: Monitor, verdict: Verdict, *, as_json: bool) -> None:
    if as_json:
        line = {"type": "verdict", "condition": monitor.condition.text} | verdict.to_dict()
        print(json.dumps(line), flush=True)
        return
    seen = " seen from the sensor" if verdict.is_relative else ""
    print(
        f"{verdict.time_s:.2f} s, frame {verdict.number}: {monitor.condition.restated}{seen}, "
        f"{verdict.probability:.1%} sure, {verdict.latency_ms:.0f} ms after the frame. "
        f"{verdict.text}",
        flush=True,
    )
