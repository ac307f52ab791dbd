"""A conversation as the page lays it out: messages, questions to try, the facts that hold."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from geotlm_lm import FrameSpec, Motion

from .guards import QUESTION_CHARACTERS
from .toolkit import COMPLAINT, PRIVATE, Filled, complaint, filling, gradio, html, model_at

if TYPE_CHECKING:
    from .clips import LoadedClip

PLACEHOLDER = "Ask how the touched object moves, in plain English, or click a question below."

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
OF_A_RECORDING = (
    "What happens first and what then?",
    "When did it stop?",
    "How far did it turn?",
    "How often did it turn back?",
    "How long did it touch?",
)
IN_MM = "How many mm did it slide?"
OF_AN_ANSWER = ("How sure are you?", "Why do you say so?", "And seen from the object's side?")


def fields_of(facts: list[str]) -> dict[str, Any]:
    """Return the fields of a `FrameSpec` that the checked facts stand for; turns add up."""
    usual = FrameSpec()
    fields = {field: getattr(usual, field) for field, _ in FACTS.values()}
    fields |= FrameSpec.fields_of_turn(sum(TURNS.get(fact, 0) for fact in facts))
    return fields | dict(FACTS[fact] for fact in facts if fact not in TURNS)


def facts_of(frame: FrameSpec) -> list[str]:
    """Return the facts to check for a frame: what the conversation stated shows in the page."""
    return [fact for fact, (field, value) in FACTS.items() if getattr(frame, field) == value]


def in_frame(facts: list[str], direction: str | None) -> str:
    """Return the last direction, if there was one, as the frame of the checked facts tells it."""
    frame = FrameSpec(**fields_of(facts))
    if direction is None:
        return f"Frame: {frame.sentence()}."
    way = frame.edit.of_way(Motion(direction)).value
    return f"In this frame ({frame.sentence()}) that is **{way}**."


def update_facts(facts: list[str], fact: str, is_checked: bool) -> list[str]:
    """Return the facts as they hold once one was checked or not.

    An image is turned by a quarter one way or the other: of both the one checked last holds.
    """
    quarters = (CLOCKWISE, COUNTERCLOCKWISE)
    replaced = quarters if is_checked and fact in quarters else (fact,)
    return [held for held in facts if held not in replaced] + [fact] * is_checked


def suggested(shown: LoadedClip | None) -> list[str]:
    """Return the questions to offer about what is open, those about an answer once there is one.

    None tells how the recording moves.
    """
    if shown is None:
        return []
    session = shown.session
    asked = [turn.question for turn in session.history]
    own: Sequence[str] = OF_A_CLIP if shown.encoded.track is None else OF_A_RECORDING
    if session.frame.mm_per_px is not None:
        own = (*own, IN_MM)
    about_last = OF_AN_ANSWER if session.last is not None else ()
    return [question for question in (*about_last, *own) if question not in asked]


def talk() -> dict[str, Any]:
    """Lay out the conversation."""
    gr, parts = gradio(), {}
    parts["chat"] = gr.Chatbot(
        label="Conversation",
        elem_classes=["chat"],
        height="100%",
        buttons=["copy_all"],
        placeholder=PLACEHOLDER,
        # A question is shown as it was typed: a picture in it would be fetched from its site.
        # Without Markdown the toolkit still takes a message for HTML.
        render_markdown=False,
    )
    group = '<div role="group" aria-label="Questions to try"></div>'
    parts["chips"] = html([], group, "chips")
    with gr.Row(elem_classes=["ask-line"]):
        parts["question"] = gr.Textbox(
            label="Question",
            show_label=False,
            container=False,
            placeholder="Your question",
            max_length=QUESTION_CHARACTERS,
            scale=6,
            min_width=160,
            elem_classes=["question"],
        )
        parts["ask"] = gr.Button("Ask", variant="primary", scale=1, min_width=64)
        parts["retry"] = gr.Button("Retry", scale=1, min_width=56)
    parts[COMPLAINT] = complaint()
    return parts


def frame_of_reference() -> dict[str, Any]:
    """Lay out the facts that directions and lengths are told by."""
    gr, parts = gradio(), {}
    gr.Markdown(
        "Directions are told **as seen in the camera image** (looking out of the sensor at the "
        "object), for the object relative to the sensor. Check what is different about yours."
    )
    with gr.Row():
        parts["frame"] = gr.CheckboxGroup(list(FACTS), label="Tell it for another frame", scale=2)
        parts["mm_per_px"] = gr.Number(
            label="Millimetres per pixel (0: slides are told in pixels)", value=0, step=0.01
        )
    parts["framed"] = gr.Markdown(in_frame([], None))
    return parts


def connect(
    parts: dict[str, Any], talking: Any, context: Sequence[str], answered: Sequence[str]
) -> None:
    """Connect the conversation, which is about the parts of `context`, and the facts beside it.

    `talking.ask` takes question, conversation and context, `again` the last two, `forget` the
    context alone; each yields what the parts show.
    """
    gr = gradio()
    asked = [parts[name] for name in ("question", "chat", *context)]
    outputs = [parts[name] for name in answered]
    options = model_at(parts["chips"])
    asking, again = filling(parts, talking.ask), filling(parts, talking.again)
    running = [
        trigger(asking, asked, outputs, **options)
        for trigger in (parts["ask"].click, parts["question"].submit)
    ]
    running.append(parts["retry"].click(again, asked[1:], outputs, **options))

    def take(event: Any) -> Iterator[Filled]:
        yield {"question": str(event._data.get("text", ""))[:QUESTION_CHARACTERS]}

    chosen = parts["chips"].click(
        filling(parts, take, gr.EventData),
        None,
        [parts["question"], parts[COMPLAINT]],
        queue=False,
        **PRIVATE,
    )
    running.append(chosen.then(asking, asked, outputs, **options))
    # All that is filled with an answer is emptied, but for what is typed.
    forgotten = [parts[name] for name in (*answered, "shown") if name in parts]
    parts["chat"].clear(
        filling(parts, talking.forget),
        asked[2:],
        forgotten,
        cancels=running,
        show_progress="hidden",
        **PRIVATE,
    )

    def check(facts: list[str], direction: str | None, event: Any) -> tuple:
        held = update_facts(facts, event.value, event.selected)
        # Boxes that stand as they should are left alone: others may be checked meanwhile.
        return gr.skip() if set(held) == set(facts) else held, in_frame(held, direction)

    # Postponed annotations are text, and the toolkit looks for the event's type itself.
    check.__annotations__["event"] = gr.SelectData
    checked = [parts["frame"], parts["framed"]]
    parts["frame"].select(check, [parts["frame"], parts["last"]], checked, **PRIVATE)
