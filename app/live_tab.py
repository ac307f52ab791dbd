"""The Live tab: what happens in a recording, or at a sensor that the browser sees as a camera."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geotlm_lm import (
    CLIP_SUFFIXES,
    GeoTLMError,
    Units,
    draw_motion,
    open_source,
    way_in_words,
)

from .clip_loading import with_clip_name
from .error_display import CAMERA, gradio, model_at, with_errors_shown
from .session_files import remove_seen
from .theme import BUTTONS

if TYPE_CHECKING:
    from geotlm_lm import Answerer, Tracker

HEADERS = ["from (s)", "to (s)", "event", "how far", "sure"]
SHOWN_EVERY_S = 0.5
"""Time between two pictures of a recording; the events come as they are found."""


NOTHING = (None, [], "")
"""Picture, events and account before anything was watched."""


@dataclass
class WatchRequest:
    """What a session wants to see; what runs looks here whether it still is.

    The toolkit's own way to end what runs lets through what is already on its way to the page,
    where it would stand in what was just emptied.

    Args:
        path: Of the recording to watch: any other's watching ends.
        cleared: How often everything was emptied: a camera is followed anew each time.
    """

    path: str | None = None
    cleared: int = 0


@dataclass(frozen=True)
class CameraSession:
    """What a session keeps of its camera.

    Args:
        tracker: Of the frames so far.
        shape: Of each of them.
        began_s: When the first came, by the machine's clock.
        cleared: How often everything had been emptied by then.
        count: How many frames came.
        rows: The events so far.
    """

    tracker: Tracker
    shape: tuple[int, ...]
    began_s: float
    cleared: int = 0
    count: int = 0
    rows: list[list[Any]] = field(default_factory=list)


def build(answerer: Answerer) -> None:
    """Lay the tab out and connect it; call it inside a `gradio.Tab`."""
    gr = gradio()
    following, wanted = gr.State(), gr.State(WatchRequest())
    gr.Markdown(
        "Leave the gel untouched for the first half second: that is when its idle image is learnt."
    )
    with gr.Row():
        with gr.Column():
            path = gr.File(
                label="Recording",
                file_types=list(CLIP_SUFFIXES),
                type="filepath",
                height=120,
            )
            with gr.Row():
                go = gr.Button("Watch", variant="primary")
                clear = gr.Button("Stop and clear")
            camera = gr.Image(
                sources=["webcam"],
                streaming=True,
                type="numpy",
                label="Or a sensor as camera",
                # Mirrored, as people like to see themselves, every direction would be reversed.
                webcam_options=gr.WebcamOptions(mirror=False),
            )
        with gr.Column():
            seen = gr.Image(label="Turn and travel", interactive=False, buttons=BUTTONS)
            events = gr.Dataframe(headers=HEADERS, label="Motion events", interactive=False)
            account = gr.Markdown()
    private = {"api_visibility": "private"}
    watch = with_errors_shown(partial(watch_recording, answerer))
    shown = [seen, events, account]
    go.click(watch, [path, wanted], shown, **model_at(seen))
    path.change(_want, [path, wanted], shown, **private, queue=False)
    clear.click(clear_all, wanted, shown, **private, queue=False)

    def follow_and_forget(*given: Any) -> tuple[CameraSession | None, Any, list, str]:
        for part in (camera, seen):
            remove_seen(part)
        return process_frame(answerer, *given)

    camera.stream(
        with_errors_shown(follow_and_forget),
        [camera, following, wanted],
        [following, *shown],
        stream_every=0.1,
        **private,
        **CAMERA,
    )


def watch_recording(
    answerer: Answerer, path: str | None, wanted: WatchRequest | None = None
) -> Iterator[tuple[Any, list, str]]:
    """Yield picture, events so far and account while a recording is watched.

    Args:
        answerer: The model.
        path: Of the recording; None when nothing was given yet.
        wanted: Whose change to another recording, or to none, ends the watching, with nothing left.

    Raises:
        GeoTLMError: If there is no recording or it cannot be read.
    """
    if not path:
        raise GeoTLMError("No recording was given; upload one first.")
    wanted = wanted or WatchRequest()
    wanted.path = path
    try:
        with with_clip_name(Path(path).parent):
            for step in _watched(answerer, path):
                if wanted.path != path:
                    yield NOTHING
                    return
                yield step
    except Exception:
        yield NOTHING  # what was said of the recording before
        raise


def _want(path: str | None, wanted: WatchRequest) -> tuple[Any, list, str]:
    """Show nothing until the recording at `path`, if any, is watched."""
    wanted.path = path
    return NOTHING


def _watched(answerer: Answerer, path: str) -> Iterator[tuple[Any, list, str]]:
    tracker, rows, shown_s = answerer.tracker(), [], float("-inf")
    image, account, units = None, "", None
    for count, frame in enumerate(open_source(path), start=1):
        units = Units(frame.image.shape[:2])
        new = tracker.feed(frame.image, frame.time_s, frame.number)
        rows += [row_of(event, units) for event in new]
        account = _told(tracker, count, units)
        if new or frame.time_s - shown_s > SHOWN_EVERY_S:
            shown_s, image = frame.time_s, draw_motion(frame.image, tracker.way, units)
            yield image, list(rows), account
    track = tracker.finish()
    rows = [row_of(event, units) for event in track.events]
    yield image, rows, " ".join((account, *track.notes))


def clear_all(wanted: WatchRequest) -> tuple[Any, list, str]:
    """End the watching, forget what a camera showed so far, and show nothing."""
    wanted.cleared += 1
    return _want(None, wanted)


def process_frame(
    answerer: Answerer,
    frame: Any,
    following: CameraSession | None,
    wanted: WatchRequest | None = None,
) -> tuple[CameraSession | None, Any, list, str]:
    """Take in one camera frame of a session and return what it follows and what there is to show.

    Another size of frames is another camera: it is followed from its own beginning, as is one after
    everything was emptied.
    """
    cleared = 0 if wanted is None else wanted.cleared
    if following is not None and following.cleared != cleared:
        following = None
    if frame is None:
        return None, None, [] if following is None else following.rows, ""
    now_s = time.monotonic()
    if following is None or following.shape != frame.shape:
        following = CameraSession(answerer.tracker(), frame.shape, now_s, cleared)
    tracker, units = following.tracker, Units(frame.shape[:2])
    new = tracker.feed(frame, now_s - following.began_s)
    rows = following.rows + [row_of(event, units) for event in new]
    following = replace(following, rows=rows, count=following.count + 1)
    account = _told(tracker, following.count, units)
    return following, draw_motion(frame, tracker.way, units), rows, account


def row_of(event: Any, units: Units) -> list[Any]:
    """Return an event as a row of the table."""
    facts = units.event(event)
    name = " ".join(one for one in (facts["event"], facts["way"]) if one)
    far = f"{abs(facts['amount']):.3g} {facts['unit']}" if "unit" in facts else ""
    times = (round(facts[one], 2) for one in ("begin_s", "end_s"))
    return [*times, name, far, round(facts["probability"], 2)]


def _told(tracker: Tracker, count: int, units: Units) -> str:
    state = "idle gel learnt" if tracker.idle is not None else "learning the idle gel"
    return f"{state} · {count} frames · {way_in_words(tracker.way, units)}"
