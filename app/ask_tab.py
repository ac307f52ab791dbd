"""The Ask tab: the stage and its timeline on the left, the conversation on the right.

Opens recordings, the examples on offer among them, and saves what was made of them.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache, partial
from html import escape
from pathlib import Path
from threading import Lock
from typing import Any
from urllib.parse import urlencode

import cv2
import gradio as gr
import numpy as np

import geotlm_lm as lm
from geotlm_lm.core.errors import TopicNeeded

from . import clips, conversation, stage
from .clips import LoadedClip
from .conversation import Talking, exchanges, in_frame, nothing_asked, offered, suggested
from .guards import QUESTION_CHARACTERS, TOPIC_CHARACTERS
from .sources import FIRST, Source, examples
from .toolkit import MODEL, QUIET, Filled, html, on
from .turns import reported

THUMBNAIL_PX = 104

MIMES = {"csv": "text/csv", "json": "application/json", "png": "image/png", "txt": "text/plain"}

CHOOSING = {"chooses": True}
"""What the second stage shows until a recording is chosen for it."""

CHOOSE_SECOND = (
    "Choose a second recording among the examples, or drop one here: questions are about both."
)

CODE = '<button type="button" hidden>Copy</button><pre tabindex="0" aria-label="Code"></pre>'

SAVING = '<div data-part="bar"></div><p data-part="status" role="status"></p>'

PROGRAMS = '<p class="note"><a href="?view=api">The same for programs: REST, Python, MCP</a></p>'

ANSWERED = (
    *("chat", "evidence", "code", "question", "frame", "mm_per_px", "framed", "chips"),
    *("saving", "stage", "stage_second"),
)
"""What is filled when a question is answered."""

OPENED = (
    *(name for name in ANSWERED if name not in ("question", "frame")),
    *("shown", "source", "reading", "first", "last_frame", "topic", "files"),
)
"""What is filled when a recording is opened or closed."""


def build(answerer: lm.Answerer, page: Any) -> None:
    """Lay the tab out and connect it; an example is opened with the page (a `gradio.Blocks`)."""
    states = ("shown", "source", "reading")
    parts: dict[str, Any] = {name: gr.State() for name in states}
    with gr.Row(elem_classes=["ask"]):
        with gr.Column(elem_classes=["ask-talk"]):
            parts |= conversation.talk()
        with gr.Column(elem_classes=["ask-stage"]):
            parts["stage"] = stage.build(actions=stage.COMPARE)
            parts["stage_second"] = stage.build(CHOOSE_SECOND, stage.CLOSE, "stage-second")
    with gr.Row(elem_classes=["gallery"]):
        parts["files"] = gr.File(
            label="Recording",
            file_types=clips.SUFFIXES,
            file_count="multiple",
            type="filepath",
            height=84,
            elem_classes=["drop"],
        )
        parts["examples"] = html("", _strip_markup(), "examples")
    with conversation.drawer():
        parts |= _details()
    talking = Talking(answerer)
    opens = Opening(answerer, talking)
    _connect(parts, opens, page)
    page.warm = opens.warm
    conversation.connect(parts, talking, "shown", ANSWERED)


def _details() -> dict[str, Any]:
    """Lay out what is in the drawer."""
    parts: dict[str, Any] = {"evidence": html({}, "<div></div>", "evidence")}
    parts |= conversation.frame_of_reference()
    gr.Markdown("#### Part of the recording")
    with gr.Row():
        # Text: of a number field left empty the page makes 0, which is a frame.
        parts["first"] = gr.Textbox(label="First frame", max_length=9, min_width=80)
        parts["last_frame"] = gr.Textbox(label="Last frame", max_length=9, min_width=80)
        parts["topic"] = gr.Textbox(
            label="Topic of a bag", max_length=TOPIC_CHARACTERS, min_width=120
        )
    parts["read"] = gr.Button("Read again with these")
    gr.Markdown("#### Code")
    parts["code"] = html("", CODE, "code")
    gr.Markdown("#### Save and share")
    parts["saving"] = html({}, SAVING, "saving")
    gr.HTML(PROGRAMS, apply_default_css=False)
    return parts


def _connect(parts: dict[str, Any], opens: Opening, page: Any) -> None:
    before = ("frame", "mm_per_px", "shown", "reading")
    at_stage, files = {**QUIET, **MODEL}, parts["files"]
    each = {**at_stage, "trigger_mode": "multiple"}

    def open_example(event: gr.EventData, *now: Any) -> Iterator[Filled]:
        yield from opens.example(str(event._data.get("example")), *now)

    def save(shown: Any, event: gr.EventData) -> Iterator[Filled]:
        yield {"saving": saved(str(event._data.get("kind")), shown)}

    def visit(request: gr.Request) -> Iterator[Filled]:
        yield from opens.visit(request.query_params)

    changed = (files.upload, files.clear, files.delete)
    chosen, closing = parts["examples"].click, parts["stage_second"].collapse
    leave = partial(opens.stop, is_replaced=True)
    on(parts, (*changed, chosen, closing), leave, ["reading"], queue=False, **QUIET)
    on(parts, changed, opens.upload, ("files", *before), OPENED, **each)
    on(parts, [chosen], open_example, before, OPENED, **each)
    spanned = ("source", "first", "last_frame", "topic", *before)
    on(parts, [parts["read"].click], opens.read_again, spanned, OPENED, **at_stage)
    compares = ("stage_second", "shown")
    on(parts, [parts["stage"].expand], opens.compare, ["shown"], compares, queue=False)
    on(parts, [closing], opens.close_second, ["shown"], OPENED, **at_stage)
    on(parts, [page.load], visit, (), (*OPENED, "question", "frame"), **at_stage)
    stopped = (parts["stage"].stop, parts["stage_second"].stop)
    on(parts, stopped, opens.stop, ["reading"], queue=False, **QUIET)
    on(parts, [parts["saving"].click], save, ["shown"], ["saving"])


@cache
def _strip_markup() -> str:
    """Return the examples, each of which is a button that holds its key."""
    recordings, short = [], []
    for key, source in examples().items():
        thumbnail, length = _thumbnail(source.path)
        (recordings if length else short).append(
            f'<button type="button" class="example" data-example="{escape(key)}">'
            f'<img src="{thumbnail}" alt="" width="{THUMBNAIL_PX}">'
            f"<span>{escape(source.name)}{f' <i>{length}</i>' * bool(length)}</span></button>"
        )
    groups = (("Recordings", recordings), ("Clips of four frames", short))
    return "".join(
        f'<div role="group" aria-label="{label}"><h2>{label}</h2><div>{"".join(shown)}</div></div>'
        for label, shown in groups
    )


def _thumbnail(path: str) -> tuple[str, str]:
    """Return a picture of a recording in which it is touched, and how long it is."""
    clip = lm.read_clip(path)
    frame = clip.frames[-1]
    if is_whole := len(clip) > lm.FRAME_COUNT:
        changes = [np.abs(np.subtract(each, frame, dtype=np.int16)).mean() for each in clip.frames]
        frame = clip.frames[int(np.argmax(changes))]
    rows, columns = lm.camera_size(*frame.shape[:2])
    size = (THUMBNAIL_PX, round(THUMBNAIL_PX * rows / columns))
    small = cv2.resize(frame, size, interpolation=cv2.INTER_AREA)
    length = f"{len(clip) / clip.fps:.0f} s" if is_whole and clip.fps else ""
    return stage.jpeg_address(small, THUMBNAIL_PX, 95), length


class Opening:
    """Opens recordings, and yields what the parts of the tab show then.

    Its methods take what the page shows before: the facts that are checked, the size of a pixel (0
    or None where it is not known), and the clip that is open.
    """

    def __init__(self, answerer: lm.Answerer, talking: Any = None) -> None:
        self._answerer, self._talking = answerer, talking
        self._perceived: dict[str, LoadedClip] = {}  # examples: everybody opens the same
        self._lock = Lock()

    def upload(self, paths: list[str] | None, facts: list[str], *before: Any) -> Iterator[Filled]:
        """Open what was uploaded last; close everything where all was taken away."""
        given = clips.latest_upload(paths)
        if not given:
            size, shown, *_ = (*before, None, None)
            yield page_of(None, facts, size if shown is None else None)
            return
        source = Source(given, Path(given[0]).name if len(given) == 1 else "images")
        for values in self._open(source, facts, *before, may_be_second=True):
            if values.get("files") == paths:  # stand there, and would be read to be told apart
                del values["files"]
            yield values

    def example(self, key: str, *before: Any) -> Iterator[Filled]:
        """Open an example, and take away what was uploaded; an unknown key changes nothing."""
        if (source := examples().get(key)) is not None:
            yield from self._open(source, *before, may_be_second=True)

    def compare(self, shown: LoadedClip | None) -> Iterator[Filled]:
        """Let what is opened next be a second recording, compared with the one that is open."""
        if shown is None:
            raise lm.GeoTLMError("No recording is open; open one first.")
        yield {"shown": replace(shown, is_paired=True), "stage_second": CHOOSING}

    def stop(self, reading: clips.Reading | None, *, is_replaced: bool = False) -> Iterator[Filled]:
        """Let a recording that is being read end where it is tracked to, or be left for another."""
        if reading is not None:
            reading.is_replaced |= is_replaced
            reading.stop.set()
        yield {}

    def close_second(self, shown: LoadedClip | None) -> Iterator[Filled]:
        """Go back to one recording; its conversation goes on."""
        values: Filled = {"stage_second": {}, "reading": None}
        if shown is not None:
            shown = replace(clips.compared(shown, None), is_paired=False)
            values |= stage.stages_of(shown) | {"shown": shown}
        yield values | {"chips": suggested(shown)}

    def visit(self, query: Mapping[str, str]) -> Iterator[Filled]:
        """Show and open the example of a link, or the first one; a wrong link opens nothing.

        The question is asked that is in the link; of the page itself the first one.
        """
        key = query.get("example", FIRST)
        if (source := examples().get(key)) is None:
            yield page_of(None, [])
            raise lm.GeoTLMError(
                f"The link names the example {key[:40]!r}, which does not exist; open another."
            )
        for values in self._open(source, []):
            yield values
        question = query.get("q", "" if query.get("example") else conversation.STORY)
        if question and (shown := values.get("shown")) is not None:  # it may have been left
            for values in self._talking.ask(question[:QUESTION_CHARACTERS], shown, [], None):
                # What is being typed meanwhile stays.
                yield {name: value for name, value in values.items() if value != ""}

    def warm(self) -> None:
        """Look at what is opened with the page, before anybody comes."""
        source = examples()[FIRST]
        self._perceive(source, clips.read_named(source.path))

    def read_again(
        self, source: Source | None, first: str, last: str, topic: str | None, *before: Any
    ) -> Iterator[Filled]:
        """Read what is open anew, a span of it, or another topic."""
        if source is None:
            return
        # The toolkit's field that was never filled holds None.
        part = {
            "topic": (topic or "").strip() or None,
            "span": clips.span_of(first, last),
            "notes": (),
        }
        yield from self._open(replace(source, **part), *before)

    def _open(
        self,
        source: Source,
        facts: list[str],
        mm_per_px: float | None = None,
        before: LoadedClip | None = None,
        left: clips.Reading | None = None,
        *,
        may_be_second: bool = False,
    ) -> Iterator[Filled]:
        """Show a recording before the model has looked at it, the progress, and the result.

        What was open before is closed first: it must not answer for this one. It is open again
        where this one cannot be read, unless only the topic of a bag is missing. What was asked of
        a recording that was left for this one stays, as not answered.
        """
        is_second = may_be_second and before is not None and before.is_paired
        size = mm_per_px if before is None else None  # it goes with the clip that it was of
        lost = conversation.unanswered(before.session if is_second else None, left)
        closed = ({} if is_second else page_of(None, facts, size, source)) | lost
        name, reading = "stage_second" if is_second else "stage", clips.Reading()
        try:
            recording = clips.read_named(source.path, source.topic)
            unread = stage.opening(recording, source.name)
            yield closed | {name: unread, "reading": reading}
            growing = stage.GrowingTimeline(unread["unit"], recording.frames.shape[1:3])

            def show(what: str, done: int, total: int) -> Filled:
                progress = {"progress": f"{what}, {done / max(total, 1):.0%}"}
                return {name: unread | growing.values | progress}

            def follow(tracker: lm.Tracker) -> bool:
                growing.follow(tracker)
                return reading.stop.is_set()

            shown = yield from reported(partial(self._perceive, source, recording, follow), show)
            if reading.is_replaced:
                return
            if is_second:
                both = clips.compared(before, shown)
                values = {"shown": both, "chips": suggested(both), "reading": None}
                values["mm_per_px"] = both.session.frame.mm_per_px or 0
                yield stage.stages_of(both) | values
            else:
                yield _opened(shown, facts, mm_per_px, before) | lost
        except Exception as error:
            is_half_open = isinstance(error, TopicNeeded) and not is_second
            kept = closed if is_half_open else self._kept(facts, mm_per_px, before)
            if reading.questions and kept.get("shown") is not None:
                kept["shown"] = replace(kept["shown"], refused=reading.questions)
            yield kept
            raise

    def _kept(self, facts: list[str], mm_per_px: float | None, shown: LoadedClip | None) -> Filled:
        """Return what the page shows of what was open before, or of nothing."""
        values = page_of(shown, facts, mm_per_px)
        if shown is not None and shown.session.history and self._talking is not None:
            last = shown.session.history[-1].answer
            values |= {"chat": exchanges(shown.session)} | self._talking.beside(last, shown)
        return values

    def _perceive(
        self, source: Source, recording: Any, follow: Callable[[lm.Tracker], Any] = lambda _: None
    ) -> LoadedClip:
        """Return a recording for questions; an example is perceived once, unless it is stopped."""
        options = {"span": source.span, "source": source, "follow": follow}
        if source.example is None or source.span is not None:
            return clips.perceive(self._answerer, recording, **options)
        with self._lock:
            shown = self._perceived.get(source.example)
            shown = shown or clips.perceive(self._answerer, recording, **options)
            if shown.source == source:
                self._perceived[source.example] = shown
        return replace(shown, session=self._answerer.session(shown.encoded))


def page_of(
    shown: LoadedClip | None,
    facts: list[str],
    mm_per_px: float | None = None,
    source: Source | None = None,
) -> Filled:
    """Return all that the page shows of a recording, or of none, before anything was asked.

    Of none it may show the `source` that is being read.
    """
    source, is_paired = (source, False) if shown is None else (shown.source, shown.is_paired)
    part = source or Source(None, "")
    first, last = part.span or ("", "")
    values = nothing_asked(shown) | {
        **{"first": str(first), "last_frame": str(last), "topic": part.topic or ""},
        "files": part.path if isinstance(part.path, list) else None,
        **{"shown": shown, "source": source, "reading": None, "chips": suggested(shown)},
        **{"stage": {}, "stage_second": CHOOSING if is_paired else {}},
        **{"framed": in_frame(facts, None), "mm_per_px": mm_per_px or 0, "saving": offered(shown)},
    }
    return values if shown is None else values | stage.stages_of(shown)


def _opened(
    shown: LoadedClip,
    facts: list[str],
    mm_per_px: float | None,
    before: LoadedClip | None,
) -> Filled:
    size = shown.encoded.clip.frames.shape[1:3]
    if before is not None and before.encoded.clip.frames.shape[1:3] != size:
        mm_per_px = None  # it was stated of other pixels
    shown.session.frame = replace(shown.session.frame, mm_per_px=mm_per_px or None)
    return page_of(shown, facts, mm_per_px)


def saved(kind: str, shown: LoadedClip | None) -> dict[str, Any]:
    """Return a file for the browser to save, or the end of a link."""
    offer = offered(shown)
    if shown is None or kind not in offer["kinds"]:
        raise lm.GeoTLMError(
            "There is nothing of this kind to save; open a recording and ask first."
        )
    turns, source = shown.session.history, shown.source
    if kind == "link":
        query = {"example": source.example} | ({"q": turns[-1].question} if turns else {})
        return offer | {"link": f"?{urlencode(query)}"}
    what, ending = kind.split(".")
    if what == "track":
        content = _track(shown, ending)
    elif ending == "json":
        content = (json.dumps(shown.session.to_dict(), indent=1) + "\n").encode()
    else:
        content = "\n\n".join(f"{turn.question}\n{turn.answer.text}" for turn in turns).encode()
        content += b"\n"
    stem = "".join(letter if letter.isalnum() else "_" for letter in Path(source.name).stem)
    return offer | {
        "name": f"{stem}_{'track' if what == 'track' else 'conversation'}.{ending}",
        "mime": MIMES[ending],
        "content": base64.b64encode(content).decode(),
    }


def _track(shown: LoadedClip, ending: str) -> bytes:
    exported = lm.Exported(shown.encoded.track, shown.session.frame.mm_per_px)
    clip = shown.encoded.recording
    if ending == "png":
        return lm.plot_png(exported, in_frames=not clip.is_timed)
    made_by = {"program": f"geotlm-lm {lm.__version__}", "recording": shown.source.name}
    made_by["fps"] = clip.fps
    return exported.content(f".{ending}", made_by)
