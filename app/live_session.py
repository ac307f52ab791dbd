"""What a visitor watches on the Live tab, and the conversation about it; knows no toolkit.

A new picture is told ten times a second, questions are asked meanwhile: what is watched is one
object that both look at, and whatever finds that it is watched no more ends.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geotlm_lm import FrameSpec, GeoTLMError, declared_bytes, is_streamed, open_source

from .budget import WORKING
from .clip_loading import Image, with_clip_name
from .facts import frame_preview
from .filling import COMPLAINT, Filled
from .live_stream import WATCH_FIRST, LiveStream
from .opening import Source
from .suggestions import OF_A_RECORDING
from .talking import Messages, Talking

if TYPE_CHECKING:
    from geotlm_lm import Answerer

SHOWN_EVERY_S = 0.25
"""Time between two pictures of a recording; the events come as they are found."""

STARTED_S = 2.0
"""Time without a frame of the camera after which the next one means that it was just started."""

UNASKED: Filled = {"chat": [], "last": None, "told": "", COMPLAINT: ""}

NOTHING: Filled = UNASKED | {"stage": {}, "chips": []}
"""What is shown before anything was watched."""


@dataclass
class LiveSession:
    """What one visitor watches.

    Args:
        stream: That is watched; None before, and once everything was emptied.
        camera_s: When the camera's last frame came, by the machine's clock.
        began_s: When the first one of the stream came, likewise.
        mm_per_px: Size of a pixel; None where it is not known.
        shape: Of the frames that this was said of.
    """

    stream: LiveStream | None = None
    camera_s: float = float("-inf")
    began_s: float = 0.0
    mm_per_px: float | None = None
    shape: tuple[int, ...] = ()

    def begin(self, stream: LiveStream) -> Filled:
        """Watch another stream, and return what the parts show of it at first."""
        told: Filled = {"chips": list(OF_A_RECORDING)}
        if self.shape not in ((), stream.shape):
            self.mm_per_px, told["mm_per_px"] = None, 0  # it was said of other pixels
        self.stream, self.shape = stream, stream.shape
        return told


def watch_recording(answerer: Answerer, path: str | None, live: LiveSession) -> Iterator[Filled]:
    """Yield what the parts show while a recording is watched to its end, or until another is.

    Args:
        answerer: The model.
        path: Of the recording; None when nothing was given yet.
        live: Of the visitor.

    Raises:
        GeoTLMError: If there is no recording or it cannot be read.
    """
    if not path:
        raise GeoTLMError("No recording was given; upload one first.")
    live.stream = None
    yield NOTHING  # what was said of the stream before
    # A video or a bag is decoded as it is watched, anything else is read whole before.
    size_bytes = 0 if is_streamed(path) else 2 * declared_bytes(Path(path))
    with WORKING.held(size_bytes), with_clip_name(Path(path).parent):
        source = iter(open_source(path))
        first = next(source)
        stream = LiveStream(answerer, Path(path).name, first.image.shape)
        yield live.begin(stream)
        yield from _told(stream, live, first, source)


def _told(
    stream: LiveStream, live: LiveSession, frame: Any, source: Iterator[Any]
) -> Iterator[Filled]:
    shown_s = float("-inf")
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


def follow_camera(answerer: Answerer, frame: Image | None, live: LiveSession) -> Filled:
    """Take in one camera frame and return what the parts show then, of those that change.

    Frames of another size are another camera: it is followed from its own beginning, as is one
    after everything was emptied. While a recording is watched only a camera that was just started
    takes its place.

    Args:
        answerer: The model.
        frame: uint8 RGB; None when the camera was stopped.
        live: Of the visitor.
    """
    if frame is None:
        return {}
    now_s, before_s = time.monotonic(), live.camera_s
    live.camera_s = now_s
    stream, told = live.stream, {}
    is_new = stream is None or (stream.is_camera and stream.shape != frame.shape)
    if stream is not None and not stream.is_camera:
        is_new = now_s - before_s > STARTED_S
        if not is_new:
            return {}
    if is_new:
        stream = LiveStream(answerer, "camera", frame.shape, is_camera=True)
        live.began_s = now_s
        told = UNASKED | live.begin(stream)
    stream.feed(frame, now_s - live.began_s)
    if live.stream is not stream:  # emptied meanwhile
        return {}
    return told | {"stage": stream.stage(frame, live.mm_per_px)}


@dataclass
class LiveTalk:
    """Answers questions about what is watched, as far as it was seen when they are asked.

    Args:
        answerer: The model.
    """

    answerer: Answerer

    def ask(
        self, question: str, chat: Messages, live: LiveSession, *others: Any
    ) -> Iterator[Filled]:
        """As `Talking.ask`, until something else is watched."""
        return self._answers(live, lambda to, *about: to.ask(question, chat, *about, *others))

    def again(self, chat: Messages, live: LiveSession, *others: Any) -> Iterator[Filled]:
        """As `Talking.again`, until something else is watched."""
        if not chat:
            return iter(())
        return self._answers(live, lambda to, *about: to.again(chat, *about, *others))

    def forget(self, live: LiveSession, facts: list[str], *_: Any) -> Iterator[Filled]:
        """Begin the conversation anew; the frame that the page shows still holds."""
        if live.stream is not None:
            live.stream.forget_talk()
        chips = [] if live.stream is None else list(OF_A_RECORDING)
        yield UNASKED | {"told": frame_preview(facts, None), "chips": chips}

    def resize(self, live: LiveSession, mm_per_px: float | None) -> Iterator[Filled]:
        """Tell lengths by another size of a pixel.

        Raises:
            GeoTLMError: If no camera has pixels of that size.
        """
        size = FrameSpec(mm_per_px=mm_per_px or None).mm_per_px
        if size == live.mm_per_px:
            return
        live.mm_per_px = size
        if live.stream is not None:
            yield {"stage": live.stream.stage(mm_per_px=size)}

    def _answers(self, live: LiveSession, asked: Callable[..., Any]) -> Iterator[Filled]:
        """Yield what the parts show of answers, but nothing of a stream that is watched no more."""
        if (stream := live.stream) is None:
            raise GeoTLMError(WATCH_FIRST)

        def redraw(shown: Any, _: Source) -> dict[str, Any]:
            live.mm_per_px = shown.session.frame.mm_per_px
            return stream.stage(mm_per_px=live.mm_per_px)

        to, source = Talking(self.answerer, redraw), Source(stream.name, stream.name)
        for filled in asked(to, stream.shown(), source):
            if live.stream is not stream:
                return
            yield {name: value for name, value in filled.items() if name in _PARTS}


_PARTS = frozenset(("chat", "question", "chips", "stage", "last", "frame", "told", "mm_per_px"))
"""Those that there are: the Ask tab has more."""
