"""What the tabs share of the toolkit: parts filled by name, errors beside the field, plain text."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import wraps
from html import escape
from pathlib import Path
from typing import Any

import gradio as gr

import geotlm_lm as lm

from .guards import AT_ONCE
from .turns import LISTENER

MODEL_LINE = "model"

MODEL = {"concurrency_limit": AT_ONCE, "concurrency_id": MODEL_LINE}
"""Options of what uses the model: requests are worked on at once and take turns at it (`turns`);
those of one visitor wait for each other (`sessions.keep_order`)."""

CAMERA = {"concurrency_limit": AT_ONCE, "concurrency_id": "camera"}
"""Options of what watches, for as long as it likes: its visitor's questions do not wait for it."""

QUIET = {"api_visibility": "private", "show_progress": "hidden"}
"""Options of an event whose parts show by themselves that they are being filled."""


def report_progress(what: str, done: int, total: int) -> None:
    """Show how far a request is where its results will stand, or to the client that listens."""
    if (listener := LISTENER.get()) is not None:
        listener(what, done, total)
    else:
        gr.Progress()((done, total), desc=what)


COMPLAINT = "complaint"
"""Name of the part that shows an error; emptied by whatever works."""

Filled = dict[str, Any]
"""New values of some parts by their names; the others stay."""


def complaint() -> Any:
    """Return the component that shows an error, empty; screen readers read it out."""
    return html("", '<p role="alert">${value}</p>', "complaint")


def html(value: Any, template: str, name: str, script: str | None = None) -> Any:
    """Return a component of the page's own, whose script is run when it is laid out.

    The name is its class in the style sheet; unless a script is given it is the part of `parts.js`
    that is named likewise.
    """
    if script is None:
        parts = Path(__file__).with_name("parts.js").read_text("utf-8")
        script = f"{parts}\nrun(parts['{name}']);"
    return gr.HTML(
        value,
        html_template=template,
        css_template="",
        js_on_load=script,
        apply_default_css=False,
        elem_classes=[name],
    )


def sent(name: str, value: Any) -> Any:
    """Return a part's value as it travels: the stage's as one text, which is copied at no cost."""
    return (
        {"json": json.dumps(value)}
        if name.startswith("stage") and isinstance(value, dict)
        else value
    )


def filling(
    parts: Mapping[str, Any], function: Callable[..., Iterator[Filled]]
) -> Callable[..., Iterator[dict[Any, Any]]]:
    """Return a handler of the toolkit that fills parts with what a function yields for their names.

    Its errors are shown in the complaint. An argument that tells of a click or of the visit has the
    toolkit's class as its annotation.
    """

    # Not its name: a tool may have the same.
    @wraps(function, assigned=["__annotations__"])
    def fill(*given: Any) -> Iterator[dict[Any, Any]]:
        values: Filled | None = None
        # Emptied once: what runs on for long must not take away another error.
        emptied: Filled = {COMPLAINT: ""}
        try:
            for values in function(*given):
                yield {parts[name]: sent(name, each) for name, each in (emptied | values).items()}
                emptied = {}
        except lm.GeoTLMError as error:
            # A recording's name is part of the sentence, and anybody may have chosen it.
            yield {parts[COMPLAINT]: escape(str(error), quote=False)}
            return
        if values is None:  # of what yields nothing the toolkit would empty every part
            yield {parts[COMPLAINT]: ""}

    return fill


def on(
    parts: Mapping[str, Any],
    triggers: Sequence[Callable[..., Any]],
    function: Callable[..., Iterator[Filled]],
    reads: Sequence[str] = (),
    fills: Sequence[str] = (),
    **options: Any,
) -> list[Any]:
    """Let events fill parts with what a function, as of `filling`, makes of others, all by name.

    The complaint is always filled. Programs have tools of their own: no event is one.
    """
    handler = filling(parts, function)
    inputs = [parts[name] for name in reads]
    outputs = [parts[name] for name in (*fills, COMPLAINT)]
    options["api_visibility"] = "private"
    return [trigger(handler, inputs, outputs, **options) for trigger in triggers]
