"""The Live tab: the stage follows a recording, or a sensor that the browser sees as a camera."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import gradio as gr

import geotlm_lm as lm

from . import conversation, stage
from .guards import QUESTION_CHARACTERS
from .live import LiveSession, LiveTalk, follow_camera, stop, wait_for, watch_recording
from .sessions import remove_seen
from .toolkit import CAMERA, COMPLAINT, QUIET, Filled, complaint, on, sent

INVITES = (
    "Start the camera, or drop a recording here. Leave the gel untouched for the first half "
    "second: that is when its idle image is learnt."
)

UNWATCHED = "Start a camera or a recording: questions are answered from what was seen by then."

EMPTIED = ("stage", "chips", "chat", "framed", "mm_per_px")
"""What is filled when something else is watched, or nothing."""

ANSWERED = (*EMPTIED, "question", "frame")
"""What is filled when a question is answered."""


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
            with gr.Row(elem_classes=["ask-line"]):
                parts["condition"] = gr.Textbox(
                    label="Mark the moment when",
                    placeholder="it has turned 30 degrees clockwise",
                    max_length=QUESTION_CHARACTERS,
                    scale=6,
                    min_width=160,
                )
                parts["mark"] = gr.Button("Mark", scale=1, min_width=64)
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
            yield values | {"condition": "", "refused": "", "camera": camera}

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
    marked = (parts["mark"].click, parts["condition"].submit)
    facts = ("condition", "live", "frame", "mm_per_px")
    on(beside, marked, partial(wait_for, answerer), facts, ["stage"], **QUIET, **CAMERA)

    # Taken away and laid out anew, the camera's part lets its browser ask for the camera again.
    emptied = (*EMPTIED, "condition", "refused", "camera")
    (cleared,) = on(parts, [parts["clear"].click], clear, ["live"], emptied, js=STOP_CAMERA, **now)
    cleared.then(lambda: gr.Image(visible=True), None, parts["camera"], **now)

    outputs = [parts[name] for name in (*EMPTIED, COMPLAINT)]
    camera, inputs = parts["camera"], [parts["camera"], parts["live"]]
    camera.stream(follow, inputs, outputs, stream_every=0.1, **QUIET, **CAMERA)
