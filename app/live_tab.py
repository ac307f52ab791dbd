"""The Live tab: the stage follows a recording, or a sensor that the browser sees as a camera."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

from geotlm_lm import CLIP_SUFFIXES

from . import conversation, stage
from .conversation import PRIVATE
from .error_display import CAMERA, gradio, with_errors_shown
from .filling import COMPLAINT, Filled, filling
from .live_session import LiveSession, LiveTalk, follow_camera, stop, watch_recording
from .session_files import remove_seen

if TYPE_CHECKING:
    from geotlm_lm import Answerer

INVITES = (
    "Start the camera below, or drop a recording there and press Watch. Leave the gel untouched "
    "for the first half second: that is when its idle image is learnt."
)

WATCHED = ("stage", "chips", COMPLAINT)
"""What is filled while frames arrive."""

EMPTIED = (*WATCHED, "chat", "last", "told", "mm_per_px")
"""What is filled when something else is watched, or nothing."""

CONTEXT = ("live", "frame", "mm_per_px")
"""What questions are about."""

ANSWERED = (
    *("chat", "question", "chips", "stage", "last"),
    *("frame", "told", "mm_per_px", COMPLAINT),
)
"""What is filled when a question is answered."""


def build(answerer: Answerer) -> None:
    """Lay the tab out and connect it; call it inside a `gradio.Tab`."""
    gr = gradio()
    parts: dict[str, Any] = {"live": gr.State(LiveSession()), "last": gr.State()}
    with gr.Row(elem_classes=["ask"]):
        with gr.Column(scale=11, min_width=320, elem_classes=["ask-stage"]):
            parts["stage"] = stage.build(invites=INVITES)
            parts |= _sources(gr)
        with gr.Column(scale=9, min_width=320, elem_classes=["ask-talk"]):
            parts |= conversation.talk()
    with gr.Accordion("Frame of reference", open=False):
        parts |= conversation.frame_of_reference()
    _connect_sources(parts, answerer)
    talk = LiveTalk(answerer)
    conversation.connect(parts, talk, CONTEXT, ANSWERED)
    resized = filling(parts, talk.resize)
    for trigger in (parts["mm_per_px"].submit, parts["mm_per_px"].blur):
        trigger(resized, *_ends(parts, ("live", "mm_per_px"), WATCHED), **_hidden(CAMERA))


def _sources(gr: Any) -> dict[str, Any]:
    parts = {}
    with gr.Row(elem_classes=["sources"]):
        parts["camera"] = gr.Image(
            sources=["webcam"],
            streaming=True,
            type="numpy",
            label="Sensor as camera",
            elem_classes=["live-camera"],
            height=150,
            min_width=200,
            # Mirrored, as people like to see themselves, every direction would be reversed.
            webcam_options=gr.WebcamOptions(mirror=False),
        )
        with gr.Column(min_width=220):
            parts["path"] = gr.File(
                label="Recording",
                file_types=list(CLIP_SUFFIXES),
                type="filepath",
                height=96,
                elem_classes=["drop"],
            )
            with gr.Row(elem_classes=["watching"]):
                parts["go"] = gr.Button("Watch", variant="primary", min_width=80)
                parts["clear"] = gr.Button("Stop and clear", min_width=120)
    return parts


STOP_CAMERA = """(...given) => {
    for (const one of document.querySelectorAll('.live-camera video'))
        for (const track of one.srcObject ? one.srcObject.getTracks() : []) track.stop();
    return given;
}"""
"""Turns the camera off in the browser, whatever the server does meanwhile."""


def _stop(gr: Any, live: LiveSession) -> Iterator[Filled]:
    for told in stop(live):
        yield told | {"camera": gr.Image(value=None, visible=False)}


def _connect_sources(parts: dict[str, Any], answerer: Answerer) -> None:
    gr = gradio()
    watch = filling(parts, partial(watch_recording, answerer))
    parts["go"].click(watch, *_ends(parts, ("path", "live"), EMPTIED), **_hidden(CAMERA))
    emptied = {**PRIVATE, "queue": False, "show_progress": "hidden"}
    parts["path"].change(filling(parts, stop), *_ends(parts, ("live", "path"), EMPTIED), **emptied)
    # Taken away and laid out anew, the camera's part lets its browser ask for the camera again.
    parts["clear"].click(
        filling(parts, partial(_stop, gr)),
        *_ends(parts, ("live",), (*EMPTIED, "camera")),
        js=STOP_CAMERA,
        **emptied,
    ).then(lambda: gr.Image(visible=True), None, parts["camera"], **emptied)

    # No generator: the toolkit would ask it for more instead of giving it the next frame.
    def follow(*given: Any) -> dict[Any, Any]:
        remove_seen(parts["camera"])
        # It takes no empty dictionary either.
        told = follow_camera(answerer, *given) or {"stage": gradio().skip()}
        return {parts[name]: value for name, value in told.items()}

    parts["camera"].stream(
        with_errors_shown(follow),
        *_ends(parts, ("camera", "live"), EMPTIED),
        stream_every=0.1,
        **_hidden(CAMERA),
    )


def _ends(parts: dict[str, Any], *names: tuple[str, ...]) -> Iterator[list[Any]]:
    """Return the components that an event reads and fills."""
    return ([parts[one] for one in some] for some in names)


def _hidden(line: dict[str, Any]) -> dict[str, Any]:
    return {**PRIVATE, "show_progress": "hidden", **line}
