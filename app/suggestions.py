"""Questions that fit the recording that is open; none tells how it moves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from .error_display import gradio

if TYPE_CHECKING:
    from .clip_loading import LoadedClip

OF_A_CLIP = (
    "Which way is it moving?",
    "How far did it go?",
    "Is it turning or sliding?",
    "Is anything touching the gel?",
)
OF_A_RECORDING = (
    "What happens first and what then?",
    "When did it stop?",
    "How far did it turn?",
    "How often did it turn back?",
    "How long did it touch?",
)
IN_MM = "How many mm did it slide?"
OF_AN_ANSWER = ("How sure are you?", "Why do you say so?", "And seen from the object's side?")

SCRIPT = """
const show = () => element.firstElementChild.replaceChildren(
  ...(props.value || []).map((text) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = text;
    button.onclick = () => trigger("click", { text });
    return button;
  }));
watch("value", show);
show();
"""


def suggested(shown: LoadedClip | None) -> list[str]:
    """Return the questions to offer; those about an answer once there is one.

    Args:
        shown: The clip that is open; None when none is.
    """
    if shown is None:
        return []
    session = shown.session
    asked = [turn.question for turn in session.history]
    own: Sequence[str] = OF_A_CLIP if shown.encoded.track is None else OF_A_RECORDING
    if session.frame.mm_per_px is not None:
        own = (*own, IN_MM)
    about_last = OF_AN_ANSWER if session.last is not None else ()
    return [one for one in (*about_last, *own) if one not in asked]


def chips() -> Any:
    """Return the component that offers them; a click on one tells its text."""
    return gradio().HTML(
        [],
        html_template='<div role="group" aria-label="Questions to try"></div>',
        js_on_load=SCRIPT,
        apply_default_css=False,
        elem_classes=["chips"],
    )
