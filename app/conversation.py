"""A conversation: how the page lays it out, its answers, and all that stands beside them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import gradio as gr

import geotlm_lm as lm

from . import stage
from .clips import LoadedClip, Reading, by_place, compared
from .guards import QUESTION_CHARACTERS
from .toolkit import COMPLAINT, MODEL, QUIET, Filled, complaint, html, on
from .turns import SessionInTurns

EMPTY = "Ask how the touched object moves, in plain English."

REPLACED = "Not answered: another recording was opened."

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

MOST_OPTIONS = 5

REGION_VALUES = ("shear_change_x", "shear_change_y", "contact_mass")


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


def way_seen(session: Any) -> str | None:
    """Return the last direction as the recorded image shows it; None where there was none."""
    turns = [] if session is None else session.history
    seen = getattr(turns[-1].answer, "in_the_image", None) if turns else None  # not of two
    return None if seen is None else seen.value


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


def unanswered(session: Any, reading: Reading | None) -> Filled:
    """Return the conversation with what waited in vain for a recording; nothing where none did."""
    if reading is None or not (reading.is_replaced and reading.questions):
        return {}
    lost = [{"question": each, "answer": REPLACED} for each in reading.questions]
    chat = exchanges(session)
    return {"chat": chat | {"exchanges": chat["exchanges"] + lost}}


def _sure(answer: Any) -> int | None:
    """Return how sure an answer is, percent; None where its words tell, or nothing is claimed."""
    if answer.abstained or answer.kind in ("talk", "fact"):
        return None
    return round(100 * answer.confidence)


def about_clip(shown: LoadedClip | None) -> dict[str, Any]:
    """Return what is to be known of a recording, whatever is asked."""
    return {"about": [] if shown is None else list(shown.encoded.clip.notes)}


def nothing_asked(shown: LoadedClip | None) -> Filled:
    """Return the conversation and all that stands beside it, before anything was asked."""
    return {"chat": exchanges(None), "evidence": about_clip(shown), "code": ""}


def offered(shown: LoadedClip | None) -> dict[str, Any]:
    """Return what can be saved of the clip that is open; only an example has a link."""
    if shown is None:
        return {"kinds": []}
    tracked = [] if shown.encoded.track is None else ["track.csv", "track.json", "track.png"]
    asked = ["talk.txt", "talk.json"] if shown.session.history else []
    return {"kinds": [*tracked, *asked, *(["link"] if shown.source.example else [])]}


@dataclass
class Talking:
    """Answers questions about a clip."""

    answerer: lm.Answerer

    def ask(
        self,
        question: str,
        shown: LoadedClip | None,
        facts: list[str],
        mm_per_px: float | None,
        reading: Reading | None = None,
    ) -> Iterator[Filled]:
        """Answer the next question of the conversation, or take a fact about the recording."""
        is_lost = reading is not None and reading.is_replaced and question in reading.questions
        if not question or is_lost:  # the second of two clicks, or of a recording that was left
            return
        if shown is None:
            raise lm.GeoTLMError("No recording is open; open one first.")
        if question in shown.refused:
            shown.refused.remove(question)
            raise lm.GeoTLMError(
                "This was asked of a recording that failed; ask again of this one."
            )
        session, size_before = shown.session, shown.session.frame.mm_per_px
        session.frame = replace(session.frame, **fields_of(facts), mm_per_px=mm_per_px or None)
        yield {"chat": exchanges(session, question), "question": ""}
        try:
            answer = session.ask(understood := by_place(question, shown))
        except lm.GeoTLMError:
            yield {"chat": exchanges(session), "question": question}
            raise
        if shown.second is not None and hasattr(answer, "naming"):
            answer = answer.naming(shown.source.name, shown.second.source.name)
            session.history[-1] = replace(session.history[-1], answer=answer)
        if understood != question:  # shown is what was typed
            session.history[-1] = replace(session.history[-1], question=question.strip())
        frame, stated = session.frame, facts_of(session.frame)
        redrawn = frame.mm_per_px != size_before
        # A field that the question did not fill may have been filled meanwhile.
        is_sized = (frame.mm_per_px or 0) != (mm_per_px or 0)
        yield {
            "chat": exchanges(session),
            "frame": stated,
            **({"mm_per_px": frame.mm_per_px or 0} if is_sized else {}),
            "framed": in_frame(stated, way_seen(session)),
            "chips": suggested(shown),
            **(self.redraw(shown) if redrawn else {}),
            **self.beside(answer, shown),
        }

    def wait(self, question: str, reading: Reading | None, about: Any) -> Iterator[Filled]:
        """Show that a question waits for the recording that is being read, if one is."""
        values: Filled = {}
        if question and reading is not None:
            reading.questions.append(question)
            pending = f"{question} (waiting until the recording is read)"
            values = {"chat": exchanges(self.session_of(about), pending)}
        yield values

    def again(self, about: Any, *others: Any) -> Iterator[Filled]:
        """Ask the last question of the conversation again, in its old place."""
        session = self.session_of(about)
        if session is None or not session.history:
            return
        question = session.history[-1].question
        session.take_back(question)
        for values in self.ask(question, about, *others):
            yield {name: value for name, value in values.items() if name != "question"}

    def resize(self, shown: LoadedClip | None, mm_per_px: float | None) -> Iterator[Filled]:
        """Tell lengths by another size of a pixel, in the picture as well; 0, None: in pixels."""
        size = mm_per_px or None
        if shown is None or size == shown.session.frame.mm_per_px:
            return
        shown.session.frame = replace(shown.session.frame, mm_per_px=size)
        yield self.redraw(shown) | {"chips": suggested(shown)}

    def shown_again(self, about: Any, *_: Any) -> Iterator[Filled]:
        """Show the conversation without the question that was being answered."""
        session = self.session_of(about)
        if isinstance(session, SessionInTurns):
            session.stop()
        yield {"chat": exchanges(session)}

    def session_of(self, shown: LoadedClip | None) -> Any:
        """Return the conversation; None where there is none."""
        return None if shown is None else shown.session

    def redraw(self, shown: LoadedClip) -> Filled:
        """Return what the stage shows once the size of a pixel is another."""
        return stage.stages_of(shown)

    def beside(self, answer: Any, shown: LoadedClip) -> Filled:
        """Return what an answer rests on, and the conversation as a program."""
        beside = {"code": code_of(shown), "saving": offered(shown)}
        if hasattr(answer, "relation"):  # of two recordings
            verdicts = [
                [name, _way(each.direction), each.text]
                for name, each in (("first", answer.first), ("second", answer.second))
            ]
            return beside | {"evidence": about_clip(shown) | {"verdicts": verdicts}}
        if shown.second is not None and answer.places[0]:
            shown = shown.second
        details = answer.to_dict()
        timing_ms = details.get("timing_ms", {}) | shown.opinions["timing_ms"]
        # What is to be known of the answer; the clip's own notes stand beside the clip.
        notes = [note for note in answer.notes if note not in shown.encoded.clip.notes]
        likeliest = sorted(answer.options.items(), key=lambda option: -option[1])
        evidence = about_clip(shown) | {
            "notes": notes,
            "probabilities": likeliest[:MOST_OPTIONS],
            "band": _band(self.answerer, details),
            "verdicts": _verdicts(answer, shown),
            "regions": [
                [name.replace("_", " "), *(round(values[key], 3) for key in REGION_VALUES)]
                for name, values in details.get("evidence", {}).get("regions", {}).items()
            ],
            "timing": " · ".join(f"{name} {value:.1f} ms" for name, value in timing_ms.items()),
        }
        return beside | {"evidence": evidence}

    def forget(self, shown: LoadedClip | None, facts: list[str], *_: Any) -> Iterator[Filled]:
        """Begin the conversation about the clip anew; the frame that the page shows still holds."""
        anew = None
        if shown is not None:
            anew = replace(shown, session=self.answerer.session(shown.encoded))
            anew = compared(anew, shown.second)
        yield nothing_asked(anew) | {
            "shown": anew,
            "framed": in_frame(facts, None),
            "chips": suggested(anew),
            "saving": offered(anew),
        }


def _verdicts(answer: Any, shown: LoadedClip) -> list[list[Any]]:
    """Return the motion that each method reads, all told from the answer's point of view.

    Of an answer that is no motion it is the motion that the picture shows.
    """
    probe, flow = shown.opinions["probe"], shown.opinions["optical_flow"]
    motion = answer.direction
    if motion is None:
        moved = stage.motion_of(shown, answer.frame)
        motion = moved[0].way if moved else None
    fitted = (flow["rotation_deg"], flow["slide_x_px"], flow["slide_y_px"], 0.0)
    turn, right, down, _ = answer.edit.matrix @ fitted + 0.0  # 0.0 has no sign of its own
    far = lm.flow_phrase(turn, right, down)
    sure = f"{100 * probe['probability']:.0f} % (not calibrated)"
    return [
        ["answer", _way(motion), answer.text],
        ["linear probe", answer.edit.of_way(lm.Motion(probe["motion"])).value, sure],
        ["optical flow", answer.edit.of_way(lm.Motion(flow["motion"])).value, far],
    ]


def _way(direction: lm.Motion | None) -> str:
    return "-" if direction is None else direction.value


def _band(answerer: lm.Answerer, details: dict[str, Any]) -> str:
    """Return from where on an answer is told, and where this one stands."""
    threshold = answerer.bundle.calibration.contact_threshold
    share = details.get("evidence", {}).get("contact_share", 0.0)
    side = "withheld" if details.get("abstained") else "told"
    return (
        f"Contact share {share:.3f}; below {threshold:.3f} no direction is claimed, nor that "
        f"nothing touches a gel that has changed. What is less than {lm.LEAST_SURE:.0%} sure is a "
        f"guess: this answer is {side}."
    )


def code_of(shown: LoadedClip) -> str:
    """Return the program that asks the questions of a conversation about its recording.

    The files of an upload are named as their owner knows them, several images by their folder.
    """
    source = shown.source
    questions = [by_place(turn.question, shown) for turn in shown.session.history]
    name = Path(source.path).name if isinstance(source.path, str) else source.name
    path = name if source.example is None else f"app/{Path(source.path).parent.name}/{name}"
    frame, usual = shown.session.frame, lm.FrameSpec()
    stated = {field.name: getattr(frame, field.name) for field in fields(frame)}
    stated = {field: value for field, value in stated.items() if value != getattr(usual, field)}
    span = "" if source.span is None else f", span={source.span}"
    second = [] if shown.second is None else [shown.second.encoded.clip.name]
    return "\n".join(
        [
            "from geotlm_lm import Answerer, FrameSpec, read_clip",
            "",
            "answerer = Answerer.load()",
            f"clip = read_clip({_arguments(path, topic=source.topic)})",
            f"frame = FrameSpec({_arguments(**stated)})",
            f"talk = answerer.session(answerer.encode(clip{span}), frame=frame)",
            *(f"talk.add_clip(answerer.encode(read_clip({name!r})))" for name in second),
            f"for question in {questions!r}:",
            "    print(talk.ask(question).text)",
        ]
    )


def _arguments(*given: Any, **named: Any) -> str:
    named = {name: value for name, value in named.items() if value is not None}
    return ", ".join([*map(repr, given), *(f"{name}={value!r}" for name, value in named.items())])


TALK = (
    '<div class="talk-head"><span>Conversation</span>'
    '<button type="button" data-part="clear" aria-label="Clear the conversation" hidden>Clear'
    "</button>"
    '<button type="button" data-part="details" aria-expanded="false">Details</button></div>'
    '<div data-part="list" class="talk-list" role="log" aria-label="Conversation" tabindex="0">'
    "</div>"
)


def line_of_words(
    label: str, placeholder: str, word: str, variant: Any = "secondary", **shown: Any
) -> tuple[Any, Any]:
    """Lay out a field for a question or a condition, and the button that sends it."""
    bounds = {"max_length": QUESTION_CHARACTERS, "scale": 6, "min_width": 160}
    with gr.Row(elem_classes=["ask-line"]):
        box = gr.Textbox(label=label, placeholder=placeholder, **bounds, **shown)
        return box, gr.Button(word, variant=variant, scale=1, min_width=64)


def talk(empty: str = EMPTY) -> dict[str, Any]:
    """Lay out the conversation; the question comes first for the keyboard."""
    shown = {"show_label": False, "container": False, "max_lines": 3, "elem_classes": ["question"]}
    box, button = line_of_words("Question", "Ask how it moves", "Ask", "primary", **shown)
    parts = {"question": box, "ask": button}
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
        html("", head, "drawer-head")
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
    asked = ("question", *beside, *(["reading"] if "reading" in parts else []))
    options = {"show_progress_on": [parts["chips"]], **MODEL}

    def ask(*triggers: Any) -> list[Any]:
        if "reading" in parts:
            waited = ("question", "reading", about)
            on(parts, triggers, talking.wait, waited, ["chat"], queue=False)
        return on(parts, triggers, talking.ask, asked, answered, **options)

    def take(event: gr.EventData) -> Iterator[Filled]:
        yield {"question": str(event._data.get("text", ""))[:QUESTION_CHARACTERS]}

    def check(facts: list[str], shown: Any, event: gr.SelectData) -> Iterator[Filled]:
        held = update_facts(facts, event.value, event.selected)
        values: Filled = {"framed": in_frame(held, way_seen(talking.session_of(shown)))}
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
    on(parts, [parts["frame"].select], check, ("frame", about), ("frame", "framed"))
