"""Recordings on the Ask tab: the examples on offer, what opening one fills, what is saved."""

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
import numpy as np

import geotlm_lm as lm
from geotlm_lm.core.errors import TopicNeeded

from . import stage
from .clips import (
    LoadedClip,
    Reading,
    Source,
    compared,
    latest_upload,
    perceive,
    read_named,
    span_of,
)
from .conversation import exchanges, in_frame, suggested
from .guards import QUESTION_CHARACTERS
from .pictures import jpeg_address
from .sources import EXAMPLES, RECORDING_FOLDER
from .toolkit import Filled, html
from .turns import reported

FIRST = "recording_key"
"""Opened with the page: a touch, a turn there and back, a slip and a release."""

FIRST_QUESTION = "What happens first and what then?"

THUMBNAIL_PX = 104

MIMES = {"csv": "text/csv", "json": "application/json", "png": "image/png", "txt": "text/plain"}


@cache
def examples() -> dict[str, Source]:
    """Return what is on offer by keys, whole recordings before clips, the first opened first.

    They are named after what is touched: how it moves is for the model to tell.
    """
    offer: dict[str, Source] = {}
    for path in sorted(RECORDING_FOLDER.glob("*.mov")):
        key = f"recording_{path.stem}"
        offer[key] = Source(str(path), path.stem.replace("_", " "), key)
    offer = dict(sorted(offer.items(), key=lambda item: item[0] != FIRST))
    for path in EXAMPLES.values():
        if path.parent == RECORDING_FOLDER:
            continue
        touched = path.stem
        for motion in sorted(lm.Motion, key=lambda motion: -len(motion)):
            touched = touched.removesuffix(f"_{motion.value}")
        count = 1 + sum(key.rstrip("_23456789") == touched for key in offer)
        key = touched if count == 1 else f"{touched}_{count}"
        offer[key] = Source(str(path), key.replace("_", " "), key)
    return offer


def strip() -> Any:
    """Return the component that shows the examples; a click on one tells its key."""
    return html("", _strip_markup(), "examples")


@cache
def _strip_markup() -> str:
    recordings, clips = [], []
    for key, source in examples().items():
        thumbnail, length = _thumbnail(source.path)
        (recordings if length else clips).append(
            f'<button type="button" class="example" data-example="{escape(key)}">'
            f'<img src="{thumbnail}" alt="" width="{THUMBNAIL_PX}">'
            f"<span>{escape(source.name)}{f' <i>{length}</i>' * bool(length)}</span></button>"
        )
    groups = (("Recordings", recordings), ("Clips of four frames", clips))
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
    return jpeg_address(small, THUMBNAIL_PX, 95), length


class Opening:
    """Opens recordings, and yields what the parts of the tab show then.

    Its methods take what the page shows before: the facts that are checked, the size of a pixel (0
    or None where it is not known), and the clip that is open.
    """

    def __init__(self, answerer: lm.Answerer, talking: Any = None) -> None:
        self._answerer, self._talking = answerer, talking
        self._perceived: dict[str, LoadedClip] = {}  # examples: everybody opens the same
        self._lock = Lock()

    def upload(self, paths: list[str] | None, *before: Any) -> Iterator[Filled]:
        """Open what was uploaded last; close everything where all was taken away."""
        given = latest_upload(paths)
        if not given:
            yield _closed(*before) | file_fields(None)
            return
        source = Source(given, Path(given[0]).name if len(given) == 1 else "images")
        for values in self._open(source, *before, is_second=_is_paired(*before)):
            if values.get("files") == paths:  # stand there, and would be read to be told apart
                del values["files"]
            yield values

    def example(self, key: str, *before: Any) -> Iterator[Filled]:
        """Open an example, and take away what was uploaded; an unknown key changes nothing."""
        if (source := examples().get(key)) is not None:
            yield from self._open(source, *before, is_second=_is_paired(*before))

    def compare(self, shown: LoadedClip | None) -> Iterator[Filled]:
        """Let what is opened next be a second recording, compared with the one that is open."""
        if shown is None:
            raise lm.GeoTLMError("No recording is open; open one first.")
        yield {"shown": replace(shown, is_paired=True), "stage_second": CHOOSING}

    def stop(self, reading: Reading | None) -> Iterator[Filled]:
        """Let the recording that is being read end where it is tracked to."""
        if reading is not None:
            reading.stop.set()
        yield {}

    def close_second(self, shown: LoadedClip | None) -> Iterator[Filled]:
        """Go back to one recording; its conversation goes on."""
        values: Filled = {"stage_second": {}}
        if shown is not None:
            shown = replace(compared(shown, None), is_paired=False)
            values |= stage.stages_of(shown) | {"shown": shown}
        yield values | {"chips": suggested(shown)}

    def visit(self, query: Mapping[str, str]) -> Iterator[Filled]:
        """Show and open the example of a link, or the first one; a wrong link opens nothing.

        The question is asked that is in the link; of the page itself the first one.
        """
        key = query.get("example", FIRST)
        if (source := examples().get(key)) is None:
            yield _closed([])
            raise lm.GeoTLMError(
                f"The link names the example {key[:40]!r}, which does not exist; open another."
            )
        for values in self._open(source, []):
            yield values
        question = query.get("q", "" if query.get("example") else FIRST_QUESTION)
        if question:
            asked = question[:QUESTION_CHARACTERS], values["shown"], [], None
            for values in self._talking.ask(*asked):
                # What is being typed meanwhile stays.
                yield {name: value for name, value in values.items() if value != ""}

    def warm(self) -> None:
        """Look at what is opened with the page, before anybody comes."""
        source = examples()[FIRST]
        self._perceive(source, read_named(source.path))

    def read_again(
        self, source: Source | None, first: str, last: str, topic: str | None, *before: Any
    ) -> Iterator[Filled]:
        """Read what is open anew, a span of it, or another topic."""
        if source is None:
            return
        # The toolkit's field that was never filled holds None.
        part = {"topic": (topic or "").strip() or None, "span": span_of(first, last), "notes": ()}
        yield from self._open(replace(source, **part), *before)

    def _open(self, source: Source, *before: Any, is_second: bool = False) -> Iterator[Filled]:
        """Show a recording before the model has looked at it, the progress, and the result.

        What was open before is closed first: it must not answer for this one. It is open again
        where this one cannot be read, unless only the topic of a bag is missing.
        """
        closed = {} if is_second else _closed(*before) | file_fields(source) | {"source": source}
        name, reading = "stage_second" if is_second else "stage", Reading()
        try:
            recording = read_named(source.path, source.topic)
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
            yield _paired(shown, *before) if is_second else _opened(shown, *before)
        except Exception as error:
            is_half_open = isinstance(error, TopicNeeded) and not is_second
            kept = closed if is_half_open else self._kept(*before)
            if reading.questions and kept.get("shown") is not None:
                kept["shown"] = replace(kept["shown"], refused=reading.questions)
            yield kept
            raise

    def _kept(
        self, facts: list[str], mm_per_px: float | None = None, shown: LoadedClip | None = None
    ) -> Filled:
        """Return what the page shows of what was open before, or of nothing."""
        if shown is None:
            return _closed(facts, mm_per_px) | file_fields(None)
        values = _shown(shown, facts) | {"mm_per_px": mm_per_px or 0}
        if shown.session.history and self._talking is not None:
            last = shown.session.history[-1].answer
            values |= {"chat": exchanges(shown.session)} | self._talking.beside(last, shown)
        return values

    def _perceive(
        self, source: Source, recording: Any, follow: Callable[[lm.Tracker], Any] = lambda _: None
    ) -> LoadedClip:
        """Return a recording for questions; an example is perceived once, unless it is stopped."""
        options = {"span": source.span, "source": source, "follow": follow}
        if source.example is None or source.span is not None:
            return perceive(self._answerer, recording, **options)
        with self._lock:
            shown = self._perceived.get(source.example)
            shown = shown or perceive(self._answerer, recording, **options)
            if shown.source == source:
                self._perceived[source.example] = shown
        return replace(shown, session=self._answerer.session(shown.encoded))


CHOOSING = {"chooses": True}
"""What the second stage shows until a recording is chosen for it."""


def _is_paired(_: list[str], __: float | None = None, shown: LoadedClip | None = None) -> bool:
    return shown is not None and shown.is_paired


def about_clip(shown: LoadedClip | None) -> dict[str, Any]:
    """Return what is to be known of a recording, whatever is asked."""
    return {"about": [] if shown is None else list(shown.encoded.clip.notes)}


def nothing_asked(shown: LoadedClip | None) -> Filled:
    """Return the conversation and all that stands beside it, before anything was asked."""
    return {"chat": exchanges(None), "evidence": about_clip(shown), "code": "", "last": None}


def file_fields(source: Source | None) -> Filled:
    """Return the file and the part of it that is read, as the fields of the page hold them."""
    source = source or Source(None, "")
    first, last = source.span or ("", "")
    part = {"first": str(first), "last_frame": str(last), "topic": source.topic or ""}
    return part | {"files": source.path if isinstance(source.path, list) else None}


def _shown(shown: LoadedClip, facts: list[str]) -> Filled:
    """Return all that the page shows of a recording, before anything was asked."""
    values = _closed(facts) | nothing_asked(shown) | file_fields(shown.source)
    values |= {"shown": shown, "source": shown.source, "chips": suggested(shown)}
    values |= {"stage_second": CHOOSING if shown.is_paired else {}, "saving": offered(shown)}
    return values | stage.stages_of(shown)


def _opened(
    shown: LoadedClip,
    facts: list[str],
    mm_per_px: float | None = None,
    before: LoadedClip | None = None,
) -> Filled:
    size = shown.encoded.clip.frames.shape[1:3]
    if before is not None and before.encoded.clip.frames.shape[1:3] != size:
        mm_per_px = None  # it was stated of other pixels
    shown.session.frame = replace(shown.session.frame, mm_per_px=mm_per_px or None)
    return _shown(shown, facts) | {"mm_per_px": mm_per_px or 0}


def _paired(
    second: LoadedClip, facts: list[str], mm_per_px: float | None, shown: LoadedClip
) -> Filled:
    shown = compared(shown, second)
    return stage.stages_of(shown) | {
        **{"shown": shown, "chips": suggested(shown), "reading": None},
        "mm_per_px": shown.session.frame.mm_per_px or 0,
    }


def _closed(
    facts: list[str], mm_per_px: float | None = None, before: LoadedClip | None = None
) -> Filled:
    """Return what is shown when no clip is; the size of a pixel goes with the clip it was of."""
    return {
        **nothing_asked(None),
        **{"shown": None, "source": None, "reading": None, "chips": []},
        **{"stage": {}, "stage_second": {}},
        "framed": in_frame(facts, None),
        "mm_per_px": (mm_per_px or 0) if before is None else 0,
        "saving": offered(None),
    }


def saving_bar() -> Any:
    """Return the component that offers to save; a click tells the kind, its value is the file."""
    template = '<div data-part="bar"></div><p data-part="status" role="status"></p>'
    return html({}, template, "saving")


def offered(shown: LoadedClip | None) -> dict[str, Any]:
    """Return what can be saved of the clip that is open; only an example has a link."""
    if shown is None:
        return {"kinds": []}
    tracked = [] if shown.encoded.track is None else ["track.csv", "track.json", "track.png"]
    asked = ["talk.txt", "talk.json"] if shown.session.history else []
    return {"kinds": [*tracked, *asked, *(["link"] if shown.source.example else [])]}


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
