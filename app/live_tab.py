"""The Live tab: the stage follows a recording, or a sensor that the browser sees as a camera.

A new picture arrives ten times a second, questions are asked meanwhile: what is watched is one
object that both look at, and whatever sees that it is watched no more ends.
"""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import gradio as gr
import numpy as np

import geotlm_lm as lm

from . import conversation, guards, stage
from .clips import Image, LoadedClip, perceive, without_folder
from .conversation import WATCHED, fields_of
from .live_talk import UNASKED, LiveTalk
from .sessions import remove_seen
from .toolkit import CAMERA, COMPLAINT, QUIET, Filled, complaint, on, sent

INVITES = (
    "Start the camera: allow it, then press Record, which only watches. Or drop a recording here. "
    "Leave the gel untouched for the first half second: that is when its idle image is learnt."
)

UNWATCHED = "Start a camera or a recording: questions are answered from what was seen by then."

EMPTIED = ("stage", "chips", "chat", "framed", "mm_per_px")
"""What is filled when something else is watched, or nothing."""

ANSWERED = (*EMPTIED, "question", "frame")
"""What is filled when a question is answered."""

SHOWN_EVERY_S = 0.25
"""Time between two pictures of a recording; the events come as they are found."""

STARTED_S = 2.0
"""Time without a frame of the camera after which the next one means that it was just started."""

WINDOW_S, FIRST_WINDOW_S = 30.0, 6.0
"""Time that the timeline shows while frames arrive, and has room for at first; once they end it
shows all."""

SIDE, QUALITY = 448, 75
"""Longer side (pixels) and JPEG quality of what is shown."""

IDLE_AGAIN_S = 5.0
"""Time after which the idle gel is sent anew: it is followed as the light drifts."""

NOTES_FROM_S = 3.0
"""Time from which on what is amiss is shown: the idle gel is learnt before."""

KEPT_BYTES = 32 * guards.MIB
"""Of frames kept for questions, of each stream; of more every second one is dropped."""

LEAST_FRAMES = 5
"""Fewer are no recording: they would be taken for the four frames of a clip."""

LEAST_KEPT = 3 * LEAST_FRAMES
"""Frames that are kept however large they are: of half of them enough are settled."""

NOW_S = 0.4
"""How far back the present reaches."""

STILL = "Still watched for"

MARK = "Mark: "
"""Stands before the likeliest meaning of a condition that was refused, on a button."""

NO_GEL_YET = (
    "No untouched gel was seen yet, so that nothing is followed; let go of what touches it for a "
    "moment."
)

TOO_FEW = "Too few frames were seen so far; ask again in a moment."

NOTHING: Filled = UNASKED | {"stage": {}, "chips": []}
"""What is shown before anything was watched."""


def build(answerer: lm.Answerer) -> None:
    """Lay the tab out and connect it; call it inside a `gradio.Tab`."""
    parts: dict[str, Any] = {"live": gr.State(LiveSession())}
    with gr.Row(elem_classes=["ask", "live"]):
        with gr.Column(elem_classes=["ask-talk"]):
            parts |= conversation.talk(UNWATCHED)
        with gr.Column(elem_classes=["ask-stage"]):
            parts["stage"] = stage.build(invites=INVITES)
    parts |= _sources()
    with conversation.drawer():
        parts |= conversation.frame_of_reference()
    _connect_sources(parts, answerer)
    conversation.connect(parts, LiveTalk(answerer), "live", ANSWERED)


def _sources() -> dict[str, Any]:
    parts = {}
    with gr.Row(elem_classes=["sources"]):
        parts["camera"] = gr.Image(
            sources=["webcam"],
            streaming=True,
            type="numpy",
            label="Sensor as camera",
            elem_classes=["live-camera"],
            height=164,
            min_width=200,
            # Mirrored, as people like to see themselves, every direction would be reversed.
            webcam_options=gr.WebcamOptions(mirror=False),
        )
        with gr.Column(min_width=220):
            parts["path"] = gr.File(
                label="Recording",
                file_types=list(lm.CLIP_SUFFIXES),
                type="filepath",
                height=96,
                elem_classes=["drop"],
            )
            with gr.Row(elem_classes=["watching"]):
                parts["go"] = gr.Button("Watch again", min_width=110, elem_classes=["again"])
                parts["clear"] = gr.Button(
                    "Stop and clear", min_width=120, elem_classes=["only-shown"]
                )
        with gr.Column(min_width=220):
            words = ("Mark the moment when", "it has turned 30 degrees clockwise", "Mark")
            parts["condition"], parts["mark"] = conversation.line_of_words(*words)
            parts["guess"] = gr.Button(visible=False, size="sm")
            parts["refused"] = complaint()
    return parts


STOP_CAMERA = """(...given) => {
    for (const video of document.querySelectorAll('.live-camera video'))
        for (const track of video.srcObject ? video.srcObject.getTracks() : []) track.stop();
    return given;
}"""
"""Turns the camera off in the browser, whatever the server does meanwhile."""


def _connect_sources(parts: dict[str, Any], answerer: lm.Answerer) -> None:
    def clear(live: LiveSession) -> Iterator[Filled]:
        live.condition = None
        for values in stop(live):
            camera = gr.Image(value=None, visible=False)
            emptied = {"condition": "", "refused": "", "guess": gr.Button(visible=False)}
            yield values | emptied | {"camera": camera}

    # No generator: the toolkit would ask it for more instead of giving it the next frame. Nor does
    # it empty the complaint, ten times a second, which another error may fill.
    def follow(*given: Any) -> dict[Any, Any]:
        remove_seen(parts["camera"])
        try:
            values = follow_camera(answerer, *given) or {"stage": gr.skip()}
        except lm.GeoTLMError as error:
            values = {COMPLAINT: str(error)}
        return {parts[name]: sent(name, value) for name, value in values.items()}

    path, now = parts["path"], {**QUIET, "queue": False}
    watched = (path.upload, parts["go"].click)
    watch = partial(watch_recording, answerer)
    on(parts, watched, watch, ("path", "live"), EMPTIED, **QUIET, **CAMERA)
    on(parts, [path.clear], stop, ("live", "path"), EMPTIED, **now)

    beside = parts | {COMPLAINT: parts["refused"]}  # what is wrong with it stands by the condition
    words = f"(label) => label.slice({len(MARK)})"
    taken = parts["guess"].click(None, parts["guess"], parts["condition"], js=words, **now)
    marked = (parts["mark"].click, parts["condition"].submit, taken.then)
    facts = ("condition", "live", "frame", "mm_per_px")
    on(beside, marked, partial(wait_for, answerer), facts, ["stage", "guess"], **QUIET, **CAMERA)

    # Taken away and laid out anew, the camera's part lets its browser ask for the camera again.
    emptied = (*EMPTIED, "condition", "refused", "guess", "camera")
    (cleared,) = on(parts, [parts["clear"].click], clear, ["live"], emptied, js=STOP_CAMERA, **now)
    cleared.then(lambda: gr.Image(visible=True), None, parts["camera"], **now)

    outputs = [parts[name] for name in (*EMPTIED, COMPLAINT)]
    camera, inputs = parts["camera"], [parts["camera"], parts["live"]]
    camera.stream(follow, inputs, outputs, stream_every=0.1, **QUIET, **CAMERA)


class LiveStream:
    """Follows the frames of one camera or recording; a camera goes on for as long as it likes."""

    def __init__(
        self, answerer: lm.Answerer, name: str, shape: Sequence[int], *, is_camera: bool = False
    ) -> None:
        guards.MEMORY.take(KEPT_BYTES).keep_with(self)
        self.name, self.shape, self.is_camera = name, tuple(shape), is_camera
        self.key, self.count, self.is_over = secrets.token_hex(4), 0, False
        self._answerer, self._tracker = answerer, answerer.tracker()
        self._kept: list[tuple[int, Image]] = []
        self._monitor: Any = None
        self._moment: tuple[float, str] | None = None
        self.is_kept = False  # whether the condition outlived another, which was refused
        self._apart, self._stuck = 1, lm.StuckPicture()
        self._now_s = self._idle_sent_s = -np.inf
        self._began_s = 0.0 if is_camera else time.monotonic()
        self._shown: tuple[tuple[int, bool, bool], LoadedClip] | None = None
        self.session: Any = None  # the conversation; none before the first question

    def feed(self, frame: Image, time_s: float, number: int | None = None) -> list[Any]:
        """Take in the next frame, as `Tracker.feed`, and return the events that are over."""
        number = self.count if number is None else number
        events = self._tracker.feed(frame, time_s, number)
        if self._monitor is not None and self._moment is None:
            verdict = self._monitor.judged(time_s, number)
            if verdict.holds:
                self._moment = verdict.time_s, verdict.text
        if self.is_camera:
            self._stuck.after(frame, time_s)
        self._keep(number, frame)
        self.count += 1
        self._now_s = time_s
        return events

    def _keep(self, number: int, frame: Image) -> None:
        """Keep a frame for questions: of those before the newest handful every so many stay."""
        self._kept.append((number, frame))
        if (self.count - LEAST_FRAMES) % self._apart:
            del self._kept[-LEAST_FRAMES - 1 : -LEAST_FRAMES]
        if len(self._kept) > LEAST_KEPT and len(self._kept) * frame.nbytes > KEPT_BYTES:
            newest, self._apart = self._kept[-LEAST_FRAMES:], 2 * self._apart
            self._kept = self._kept[:-LEAST_FRAMES][::2] + newest

    def wait_for(self, condition: Any) -> None:
        """Mark the moment at which a condition first holds, in what was seen by now or from now on.

        None waits for nothing.
        """
        self._monitor = None if condition is None else lm.Monitor(self._tracker, condition)
        held = None if self._monitor is None else self._monitor.look_back()
        self._moment = None if held is None else (held.time_s, held.text)

    def finish(self) -> None:
        """Take the last events as the end cuts them off; nothing is fed after that."""
        self._tracker.finish()
        self.is_over = True

    def stage(self, frame: Image | None = None, mm_per_px: float | None = None) -> dict[str, Any]:
        """Return what the stage shows now, as plain JSON values; it keeps the pictures before.

        The frame is the last one that was fed; None adds no picture.
        """
        track, idle, now_s = self._tracker.so_far, self._tracker.idle, self._now_s
        rows, columns = lm.camera_size(*self.shape[:2])
        if self.is_over:
            window, now = [0.0, now_s or FIRST_WINDOW_S], None  # 0 s of a single frame
        else:
            window = [max(now_s - WINDOW_S, 0.0), max(now_s, FIRST_WINDOW_S)]
            now = now_s, self._tracker.way
        given = track, lm.Units(self.shape[:2], mm_per_px), "s", window[0]
        shows_notes = self.is_over or self._now_s > NOTES_FROM_S
        learnt = "no untouched gel seen yet" if shows_notes else "learning the idle gel"
        learnt = learnt if idle is None else "idle gel learnt"
        return {
            "stream": self.key,
            "live": not self.is_over,
            "name": self.name,
            "about": f"{learnt} · {self.count} frames{self._speed()}",
            "aspect": columns / rows,
            "unit": "s",
            "loops": False,
            "window": [round(end, 3) for end in window],
            "timeline": stage.timeline_of(*given, now=now, has_idle=idle is not None),
            "picture": None if frame is None else self._picture(frame, idle),
            "idle": self._idle_to_send(idle),
            "condition": self._condition_text(),
            "marks": [] if self._moment is None else [round(self._moment[0], 3)],
            "notes": [*filter(None, [self._stuck.note]), *(track.notes if shows_notes else ())],
        }

    def _speed(self) -> str:
        """Return how much faster a recording is watched than it was taken."""
        if self.is_camera or self.is_over:
            return ""
        factor = self._now_s / max(time.monotonic() - self._began_s, 1e-3)
        return f" · {factor:.0f} times as fast" if factor >= 1.5 else ""

    def _condition_text(self) -> str:
        if self._monitor is None:
            return ""
        moment, evidence = self._moment or (None, "")
        state = "did not hold" if self.is_over else ""
        state = state if moment is None else f"noticed at {moment:.2f} s"
        heads = (
            [STILL, *filter(None, [state])]
            if self.is_kept
            else [state.capitalize() or "Waiting for this"]
        )
        return f"{', '.join(heads)}: {self._monitor.condition.restated}. {evidence}".strip()

    def shown(self, *, is_now: bool = False) -> LoadedClip:
        """Return what was seen up to the last frame, ready for questions; the conversation goes on.

        Of the present it is the last tenths of a second.
        """
        if self.count and self._tracker.idle is None:
            raise lm.GeoTLMError(NO_GEL_YET)
        track = self._tracker.so_far if self.is_over else self._tracker.now()
        numbers = track.numbers.tolist()
        kept = [item for item in self._kept if numbers and numbers[0] <= item[0] <= numbers[-1]]
        if len(kept) < LEAST_FRAMES:
            raise lm.GeoTLMError(TOO_FEW)
        if is_now:  # at least two frames that are kept and were followed, however slow the camera
            recent = track.numbers[track.times_s >= track.times_s[-1] - NOW_S]
            begin = min(int(recent[0]), numbers[-2], kept[-2][0])
            kept = [item for item in kept if item[0] >= begin]
            track = track.between(begin, numbers[-1])
        seen = int(track.numbers[-1]), self.is_over, is_now  # its end cuts off the last events
        if self._shown is not None and self._shown[0] == seen:
            return self._shown[1]
        numbers, frames = zip(*kept, strict=True)
        span_s = float(track.times_s[-1] - track.times_s[0])
        rate_hz = (int(track.numbers[-1]) - int(track.numbers[0])) / span_s
        clip = lm.Clip(np.stack(frames), rate_hz, self._tracker.idle, self.name, numbers)
        grown = perceive(self._answerer, clip, track=track)
        # Each question looks at other frames: of all of them the conversation keeps four.
        encoded = replace(grown.encoded, recording=None)
        if self.session is None:
            self.session = self._answerer.session(encoded)
        else:
            self.session.grow(encoded)
        grown = replace(grown, encoded=encoded, session=self.session)
        self._shown = seen, grown
        return grown

    def forget_talk(self) -> None:
        """Begin the conversation anew with the next question."""
        self._shown = self.session = None

    def _picture(self, frame: Image, idle: Image | None) -> dict[str, Any]:
        return {
            "at": round(self._now_s, 3),
            "number": self.count - 1,
            "image": stage.jpeg_address(frame, SIDE, QUALITY),
            "outline": [] if idle is None else stage.outline(lm.change_map(frame, idle)),
        }

    def _idle_to_send(self, idle: Image | None) -> str | None:
        if idle is None or self._now_s - self._idle_sent_s < IDLE_AGAIN_S:
            return None
        self._idle_sent_s = self._now_s
        return stage.jpeg_address(idle, SIDE, QUALITY)


@dataclass
class LiveSession:
    """What one visitor watches."""

    stream: LiveStream | None = None  # also once everything was emptied
    camera_s: float = float("-inf")  # when the camera's last frame came, by the machine's clock
    began_s: float = 0.0  # when the first one of the stream came, likewise
    mm_per_px: float | None = None
    shape: tuple[int, ...] = ()  # of the frames that have pixels of this size
    condition: Any = None  # whose moment is marked

    def begin(self, stream: LiveStream) -> Filled:
        """Watch another stream, and return what the parts show of it at first."""
        values: Filled = {"chips": list(WATCHED)}
        if self.shape not in ((), stream.shape):
            self.mm_per_px, values["mm_per_px"] = None, 0  # it was stated of other pixels
        self.stream, self.shape = stream, stream.shape
        stream.wait_for(self.condition)
        return values

    def waiting(self, *, is_kept: bool = False) -> Filled:
        """Return what the stage shows of the condition, which may have outlived a refused one."""
        if self.stream is not None:
            self.stream.is_kept = is_kept
            return {"stage": self.stream.stage(mm_per_px=self.mm_per_px)}
        head = STILL if is_kept else "Will wait for this"
        words = self.condition and f"{head}: {self.condition.restated}."
        return {"stage": {"condition": words or ""}}


def wait_for(
    answerer: lm.Answerer, text: str, live: LiveSession, facts: list[str], mm_per_px: float | None
) -> Iterator[Filled]:
    """Mark the moment when a condition in words first holds; no words wait for nothing.

    One that is refused leaves the condition before it as it is.
    """
    frame = lm.FrameSpec(**fields_of(facts), mm_per_px=mm_per_px or None)
    read = partial(answerer.condition, frame=frame)
    try:
        live.condition = read(text) if text.strip() else None
    except lm.GeoTLMError as error:
        yield live.waiting(is_kept=True) | {"guess": _offered(read, getattr(error, "guess", ""))}
        raise
    if live.stream is not None:
        live.stream.wait_for(live.condition)
    yield live.waiting() | {"guess": gr.Button(visible=False)}


def _offered(read: Callable[[str], Any], words: str) -> gr.Button:
    """Return a button that marks a condition, hidden where that would be refused in its turn."""
    with suppress(lm.GeoTLMError):
        read(words)
        return gr.Button(f"{MARK}{words}", visible=True)
    return gr.Button(visible=False)


def watch_recording(answerer: lm.Answerer, path: str | None, live: LiveSession) -> Iterator[Filled]:
    """Yield what the parts show while a recording is watched to its end, or until another is."""
    if not path:
        raise lm.GeoTLMError("No recording was given; upload one first.")
    live.stream = None
    yield NOTHING  # the stream before is gone
    # A video or a bag is decoded as it is watched, anything else is read whole before.
    size_bytes = 0 if lm.is_streamed(path) else 2 * lm.declared_bytes(Path(path))
    with guards.MEMORY.held(size_bytes), without_folder(Path(path).parent):
        source = iter(lm.open_source(path))
        frame, shown_s = next(source), float("-inf")
        stream = LiveStream(answerer, Path(path).name, frame.image.shape)
        yield live.begin(stream)
        while frame is not None and live.stream is stream:
            events = stream.feed(frame.image, frame.time_s, frame.number)
            last, frame = frame, next(source, None)
            if live.stream is not stream:  # another is watched since
                break
            if frame is None:
                stream.finish()
            if events or frame is None or last.time_s - shown_s > SHOWN_EVERY_S:
                shown_s = last.time_s
                yield {"stage": stream.stage(last.image, live.mm_per_px)}
        if live.stream is None:
            yield NOTHING  # what was on its way when everything was emptied


def stop(live: LiveSession, *_: Any) -> Iterator[Filled]:
    """End the watching, forget what a camera showed so far, and show nothing."""
    live.stream, live.camera_s = None, float("-inf")
    yield NOTHING


def follow_camera(answerer: lm.Answerer, frame: Image | None, live: LiveSession) -> Filled:
    """Take in one camera frame and return what the parts show then, of those that change.

    Frames of another size are another camera: it is followed from its own beginning, as is one
    after everything was emptied. While a recording is watched only a camera that was just started
    takes its place. The frame is None when the camera was stopped.
    """
    if frame is None:
        return {}
    now_s, before_s = time.monotonic(), live.camera_s
    live.camera_s = now_s
    stream, values = live.stream, {}
    is_new = stream is None or (stream.is_camera and stream.shape != frame.shape)
    if stream is not None and not stream.is_camera:
        is_new = now_s - before_s > STARTED_S
        if not is_new:
            return {}
    if is_new and not frame.any():  # what a browser sends before its camera's first picture
        return {}
    if is_new:
        stream = LiveStream(answerer, "camera", frame.shape, is_camera=True)
        live.began_s = now_s
        values = UNASKED | live.begin(stream)
    stream.feed(frame, now_s - live.began_s)
    if live.stream is not stream:  # emptied meanwhile
        return {}
    return values | {"stage": stream.stage(frame, live.mm_per_px)}
