"""A conversation as the page lays it out: exchanges, questions to try, the facts that hold."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import gradio as gr

import geotlm_lm as lm

from .guards import QUESTION_CHARACTERS
from .toolkit import COMPLAINT, MODEL, QUIET, Filled, complaint, html, on

if TYPE_CHECKING:
    from .clips import LoadedClip
    from .talking import Talking

EMPTY = "Ask how the touched object moves, in plain English, once a recording is open."

MIRRORED, UPSIDE_DOWN = "image is mirrored", "image is upside down"
CLOCKWISE = "image is turned 90° clockwise"
COUNTERCLOCKWISE = "image is turned 90° counterclockwise"
OTHER_SIDE, SENSOR_MOVES = "seen from the object", "sensor moves"
TURNS = {UPSIDE_DOWN: 180, CLOCKWISE: 90, COUNTERCLOCKWISE: 270}
FACTS = {
    MIRRORED: ("image_mirrored", True),
    UPSIDE_DOWN: ("image_upside_down", True),
    CLOCKWISE: ("image_quarter_turn", "clockwise"),
    COUNTERCLOCKWISE: ("image_quarter_turn", "counterclockwise"),
    OTHER_SIDE: ("viewpoint", "object"),
    SENSOR_MOVES: ("actor", "sensor"),
}
"""What can be checked about a recording, and the field of a `FrameSpec` that it stands for."""

OF_A_CLIP = (
    "Which way is it moving?",
    "How far did it go?",
    "Is it turning or sliding?",
    "Is anything touching the gel?",
)
STORY = "What happens first and what then?"
OF_EVENTS = {
    "turn": ("How far did it turn?", "How fast did it turn?"),
    "slide": ("How far did it slide?", "When did it slip?"),
    "touch": ("How long did it touch?",),
}
"""Questions about events of a kind."""

TURNED_BACK, STOPPED = "How often did it turn back?", "When did it stop?"
WATCHED = (
    "What is happening now?",
    STORY,
    STOPPED,
    "How far did it turn?",
    "How long did it touch?",
)
"""Questions about what is being watched."""

IN_MM = "How many mm did it slide?"
OF_AN_ANSWER = {
    "way": ("How sure are you?", "And seen from the object's side?"),
    "number": ("How sure are you?", "Why do you say so?"),
    "time": ("How sure are you?", "And in frames?"),
    "bool": ("How sure are you?", "Why do you say so?"),
}
"""Questions about an answer, by its kind."""

OF_TWO = ("Did they turn the same way?", "Which turned further?", "Which slid further?")
"""Questions about two recordings."""

MOST_SUGGESTED = 5


def fields_of(facts: list[str]) -> dict[str, Any]:
    """Return the fields of a `FrameSpec` that the checked facts stand for; turns add up."""
    usual = lm.FrameSpec()
    fields = {field: getattr(usual, field) for field, _ in FACTS.values()}
    fields |= lm.FrameSpec.fields_of_turn(sum(TURNS.get(fact, 0) for fact in facts))
    return fields | dict(FACTS[fact] for fact in facts if fact not in TURNS)


def facts_of(frame: lm.FrameSpec) -> list[str]:
    """Return the facts to check for a frame: what the conversation stated shows in the page."""
    return [fact for fact, (field, value) in FACTS.items() if getattr(frame, field) == value]


def in_frame(facts: list[str], direction: str | None) -> str:
    """Return the last direction, if there was one, as the frame of the checked facts tells it."""
    frame = lm.FrameSpec(**fields_of(facts))
    if direction is None:
        return f"Frame: {frame.sentence()}."
    way = frame.edit.of_way(lm.Motion(direction)).value
    return f"In this frame ({frame.sentence()}) that is **{way}**."


def update_facts(facts: list[str], fact: str, is_checked: bool) -> list[str]:
    """Return the facts as they hold once one was checked or not.

    An image is turned by a quarter one way or the other: of both the one checked last holds.
    """
    quarters = (CLOCKWISE, COUNTERCLOCKWISE)
    replaced = quarters if is_checked and fact in quarters else (fact,)
    return [held for held in facts if held not in replaced] + [fact] * is_checked


def suggested(shown: LoadedClip | None) -> list[str]:
    """Return the questions that fit what is open and, once there is one, the last answer."""
    if shown is None:
        return []
    session, track = shown.session, shown.encoded.track
    asked = [turn.question for turn in session.history]
    own: list[str] = list(OF_A_CLIP)
    if track is not None:
        kinds = {event.kind.value for event in track.events}
        own = [STORY, *(text for kind in OF_EVENTS if kind in kinds for text in OF_EVENTS[kind])]
        own[2:2] = [TURNED_BACK] if track.turned_back() else []
    if session.frame.mm_per_px is not None:
        own.insert(0, IN_MM)
    if shown.second is not None:
        own[:0] = OF_TWO
    last = session.last
    about_last = OF_AN_ANSWER.get(last.kind, ()) if last is not None and session.history else ()
    fitting = [question for question in (*about_last, *own) if question not in asked]
    return fitting[:MOST_SUGGESTED]


def exchanges(session: Any, pending: str | None = None) -> dict[str, Any]:
    """Return a conversation as the page shows it, with a question that is being answered."""
    turns = [] if session is None else session.history
    return {
        "exchanges": [
            {"question": turn.question, "answer": turn.answer.text, "sure": _sure(turn.answer)}
            for turn in turns
        ],
        "pending": pending,
    }


def _sure(answer: Any) -> int | None:
    """Return how sure an answer is, percent; None where its words tell, or nothing is claimed."""
    if answer.abstained or answer.kind in ("talk", "fact"):
        return None
    return round(100 * answer.confidence)


TALK = (
    '<div class="talk-head"><span>Conversation</span>'
    '<button type="button" data-part="clear" aria-label="Clear the conversation" hidden>Clear'
    "</button>"
    '<button type="button" data-part="details" aria-expanded="false">Details</button></div>'
    '<div data-part="list" class="talk-list" role="log" aria-label="Conversation" tabindex="0">'
    "</div>"
)


def talk(empty: str = EMPTY) -> dict[str, Any]:
    """Lay out the conversation; the question comes first for the keyboard."""
    parts = {}
    with gr.Row(elem_classes=["ask-line"]):
        parts["question"] = gr.Textbox(
            label="Question",
            show_label=False,
            container=False,
            placeholder="Ask how it moves",
            max_length=QUESTION_CHARACTERS,
            max_lines=3,
            scale=6,
            min_width=160,
            elem_classes=["question"],
        )
        parts["ask"] = gr.Button("Ask", variant="primary", scale=1, min_width=64)
    parts[COMPLAINT] = complaint()
    parts["chat"] = html({"empty": empty}, TALK, "talk")
    group = '<div role="group" aria-label="Questions to try"></div>'
    parts["chips"] = html([], group, "chips")
    return parts


@contextmanager
def drawer() -> Iterator[None]:
    """Lay out what a first look does without: it slides in from the right."""
    with gr.Column(elem_classes=["drawer"]):
        head = (
            "<h3>Details</h3>"
            '<button type="button" class="drawer-close" aria-label="Close the details">✕</button>'
        )
        html("", head, "drawer-head", part="drawer")
        yield


def frame_of_reference() -> dict[str, Any]:
    """Lay out the facts that directions and lengths are told by."""
    parts = {}
    gr.Markdown(
        "#### Frame of reference\nDirections are told **as seen in the camera image** (looking out "
        "of the sensor at the object), for the object relative to the sensor. Check what is "
        "different about yours."
    )
    parts["frame"] = gr.CheckboxGroup(list(FACTS), label="Tell it for another frame")
    parts["mm_per_px"] = gr.Number(
        label="Millimetres per pixel (0: slides are told in pixels)", value=0, step=0.01
    )
    parts["framed"] = gr.Markdown(in_frame([], None))
    return parts


def connect(parts: dict[str, Any], talking: Talking, about: str, answered: Sequence[str]) -> None:
    """Connect the conversation about what a part holds, and the facts beside it."""
    beside, chat, size = (about, "frame", "mm_per_px"), parts["chat"], parts["mm_per_px"]
    options = {"show_progress_on": [parts["chips"]], **MODEL}

    def ask(*triggers: Any) -> list[Any]:
        if "reading" in parts:
            waited = ("question", "reading", about)
            on(parts, triggers, talking.wait, waited, ["chat"], queue=False)
        return on(parts, triggers, talking.ask, ("question", *beside), answered, **options)

    def take(event: gr.EventData) -> Iterator[Filled]:
        yield {"question": str(event._data.get("text", ""))[:QUESTION_CHARACTERS]}

    def check(facts: list[str], direction: str | None, event: gr.SelectData) -> Iterator[Filled]:
        held = update_facts(facts, event.value, event.selected)
        values: Filled = {"framed": in_frame(held, direction)}
        # Boxes that stand as they should are left alone: others may be checked meanwhile.
        yield values if set(held) == set(facts) else values | {"frame": held}

    (chosen,) = on(parts, [parts["chips"].click], take, (), ["question"], queue=False)
    running = ask(parts["ask"].click, parts["question"].submit, chosen.then)
    running += on(parts, [chat.retry], talking.again, beside, answered, **options)
    ending = {"cancels": running, **QUIET}
    # All that is filled with an answer is emptied, but for what is typed.
    forgotten = [name for name in (*answered, "shown") if name in parts]
    on(parts, [chat.clear], talking.forget, beside, forgotten, **ending)
    on(parts, [chat.stop], talking.shown_again, beside, ["chat"], **ending)
    # Lengths are in mm, or in pixels again, as soon as the field of the pixel's size is left.
    resized = (about, "mm_per_px")
    on(parts, (size.submit, size.blur), talking.resize, resized, answered, **QUIET, **MODEL)
    on(parts, [parts["frame"].select], check, ("frame", "last"), ("frame", "framed"))
