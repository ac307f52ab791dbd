"""Recordings that are open: read and perceived once, and named as their owner knows them."""

from __future__ import annotations

import hashlib
import re
import shutil
import tempfile
import time
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from threading import Event, Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

import geotlm_lm as lm

from . import guards
from .guards import KEPT_OPEN_BYTES, KEPT_OPEN_S
from .sources import Source, Sources

Image = NDArray[np.uint8]

SUFFIXES = sorted({*lm.CLIP_SUFFIXES, *lm.IMAGE_SUFFIXES})
"""Endings of recordings, and of single frames, several of which are one."""

ADVICE = {
    "pass --layout THW": "save frames[..., None], or use the command line with --layout THW",
    "or, with --layout THW, (T,H,W)": "or, on the command line with --layout THW, (T,H,W)",
    "pass --layout": "use the command line with --layout",
    "pass --square-pixels": "use the command line with --square-pixels",
    "by --topic": "as `topic`, on the page under Details of the Ask tab",
}
"""Advice for a person at the command line, and for one at the page."""


@dataclass(eq=False)
class Reading:
    """A recording that is being read: it can be stopped, and questions wait for it."""

    stop: Event = field(default_factory=Event)
    questions: list[str] = field(default_factory=list)
    is_replaced: bool = False  # by another, or by none: what waits for it is not answered


@dataclass(frozen=True, eq=False)
class LoadedClip:
    """A clip that was read and perceived, ready for questions and pictures.

    `session` is the conversation about it, which remembers its turns and its frame of reference.
    """

    encoded: Any
    seen: lm.Seen
    session: Any
    source: Source
    second: LoadedClip | None = None  # that it is compared with, in the same conversation
    is_paired: bool = False  # whether what is opened next is that second one
    refused: list[str] = field(default_factory=list)  # asked of another, which could not be read

    @cached_property
    def opinions(self) -> dict[str, Any]:
        """What the linear probe and optical flow read, as plain values; only where it is shown."""
        return lm.second_opinions(self.session.answerer, self.encoded).to_dict()


def compared(first: LoadedClip, second: LoadedClip | None) -> LoadedClip:
    """Return a recording that is compared with a second one, or with none; both are asked about."""
    session = first.session
    del session.clips[1:]
    if second is not None:
        session.add_clip(second.encoded)
    return replace(first, second=second)


def by_place(question: str, shown: LoadedClip) -> str:
    """Return a question that names one of two recordings so that it is understood.

    The reader knows them as the first and the second: "When did the key slide?" is "In the first
    recording, when did it slide?". Where both are named, or none, it stays as it is.
    """
    both = () if shown.second is None else (shown, shown.second)
    titles = [Path(each.source.name).stem.lower() for each in both]
    names = [_names(title, place) for title, place in zip(titles, PLACES, strict=False)]
    place_of: dict[str, str] = {}
    for spoken in ([{title} for title in titles], names):  # a whole title before what is like it
        for each, place in zip(spoken, PLACES, strict=False):
            unique = {name for name in each if sum(name in others for others in spoken) == 1}
            place_of = dict.fromkeys(unique, place) | place_of
    either = "|".join(re.escape(name) for name in sorted(place_of, key=len, reverse=True))
    mention = rf"(\b(?:in|of|for|than) )?(?:\bthe )?(?<!\w)({either})(?:\.\w+)?(?!\w)"
    mentions = list(re.finditer(mention, question, re.IGNORECASE)) if place_of else []
    named = {place_of[match[2].lower()] for match in mentions}
    if len(named) != 1:
        return question
    place = f"the {named.pop()} recording"
    if mentions[0][1]:  # "in the key"
        return re.sub(mention, rf"\1{place}", question, flags=re.IGNORECASE)
    rest = re.sub(mention, "it", question, flags=re.IGNORECASE)
    return f"In {place}, {rest[0].lower()}{rest[1:]}"


PLACES = ("first", "second")


def _names(title: str, place: str) -> set[str]:
    """Return what a recording may be called: its words, these but for a number, its place."""
    words = re.sub(r"[\W_]+", " ", title).strip()
    return {words, re.sub(r"\W*\d+$", "", words), f"{place} one"} - {""}


def perceive(
    answerer: lm.Answerer,
    recording: Any,
    *,
    span: tuple[int, int] | None = None,
    track: Any = None,
    depth_mm: NDArray[np.float32] | None = None,
    source: Source | None = None,
    follow: Callable[[lm.Tracker], None] = lambda _: None,
) -> LoadedClip:
    """Perceive or track a clip, or its frames from first to last of `span`, once.

    A track that was made before is used again; the true indentation of a simulated clip is kept.
    Who follows is called with the tracker after each frame.
    """
    encoded = answerer.encode(recording, span=span, track=track, follow=follow)
    geometry = encoded.perception.geometry
    field, mask = (np.asarray(x[0], np.float32) for x in (geometry.shear_change, geometry.mask))
    threshold = answerer.bundle.calibration.contact_threshold
    has_contact = not encoded.is_untouched and encoded.contact_share >= threshold
    frames, idle = encoded.clip.frames, encoded.clip.background
    seen = lm.Seen(frames, idle, field, mask, encoded.view, depth_mm, has_contact=has_contact)
    source, track = source or Source(None, recording.name), encoded.track
    if track is not None and track.is_cut:
        ends = int(track.numbers[0]), int(track.numbers[-1])
        source = replace(source, span=ends, notes=track.notes[-1:])
    return LoadedClip(encoded, seen, answerer.session(encoded), source)


def latest_upload(paths: list[str] | None) -> list[str]:
    """Return the recording that was uploaded last, alone, or the images uploaded after it."""
    given = list(paths or [])
    recordings = [place for place, path in enumerate(given) if not _is_image(path)]
    if not recordings:
        return given
    return given[recordings[-1] + 1 :] or given[-1:]


def span_of(first: float | str | None, last: float | str | None) -> tuple[int, int] | None:
    """Return the first and last frame; None where neither is given."""
    ends = ["" if end is None else str(end).strip() for end in (first, last)]
    if not any(ends):
        return None
    if not all(ends):
        raise lm.GeoTLMError("Only one end of the span was given; give both frame numbers or none.")
    if not all(end.isdecimal() for end in ends):
        raise lm.GeoTLMError(
            f"The span was {ends[0]} to {ends[1]}, expected two whole numbers; "
            f"give the numbers of two frames, counted from 0, or leave both fields empty."
        )
    return int(ends[0]), int(ends[1])


def read_named(path: str | list[str], topic: str | None = None) -> Any:
    """Return the recording in one file, or in several images, named as its owner knows it."""
    paths = [path] if isinstance(path, str) else list(path)
    if len(paths) == 1:
        path = Path(paths[0])
        with without_folder(path.parent):
            read = partial(lm.read_clip, path, topic=topic)
            return _renamed(guards.MEMORY.read(lm.declared_bytes(path), read), path.name)
    if not all(map(_is_image, paths)):
        raise lm.GeoTLMError("Several recordings were given; give one, or the images of one.")
    with tempfile.TemporaryDirectory() as folder, without_folder(folder):
        for image in paths:
            shutil.copy(image, Path(folder) / Path(image).name)
        read = partial(lm.read_clip, folder)
        return _renamed(guards.MEMORY.read(lm.declared_bytes(Path(folder)), read), "the images")


@contextmanager
def without_folder(folder: str | Path) -> Iterator[None]:
    """Leave a recording's folder out of the sentences about it: uploads lie in a temporary one."""
    try:
        yield
    except lm.GeoTLMError as error:
        sentence = str(error).replace(f"{folder}/", "").replace(str(folder), "the images")
        if sentence == str(error):
            raise
        raise type(error)(_advised(sentence)) from error


def _renamed(clip: Any, name: str) -> Any:
    return replace(clip, name=name, notes=tuple(map(_advised, clip.notes)))


def _advised(sentence: str) -> str:
    """Return a sentence with advice that can be followed without the command line."""
    for advice, instead in ADVICE.items():
        sentence = sentence.replace(advice, instead)
    return sentence


def _is_image(path: str) -> bool:
    return Path(path).suffix.lower() in lm.IMAGE_SUFFIXES


@dataclass(eq=False)
class Opened:
    """A recording that tools were asked about: all its frames, perceived, and when that was last.

    Who opens it holds its lock; before that there is none of it.
    """

    recording: Any = None
    shown: LoadedClip | None = None
    last_s: float = field(default_factory=time.monotonic)
    lock: Lock = field(default_factory=Lock)

    @property
    def size_bytes(self) -> int:
        """How much memory its frames take."""
        return 0 if self.recording is None else self.recording.frames.nbytes


class OpenedRecordings:
    """Opens recordings once each, also for requests at the same time, and keeps the last ones."""

    def __init__(self, answerer: lm.Answerer, sources: Sources) -> None:
        self._answerer, self._sources = answerer, sources
        self._kept: OrderedDict[str, Opened] = OrderedDict()
        self._lock = Lock()
        guards.MEMORY.may_let_go(self)

    def open(
        self, given: str, frames: list[int] | None = None, topic: str | None = None
    ) -> LoadedClip:
        """Return a recording (a name, a data URI or an upload), or a span of it, for questions."""
        whole = self.whole(given, topic)
        if frames is None:
            return whole.shown
        track, span = whole.shown.encoded.track, (frames[0], frames[1])
        return perceive(self._answerer, whole.recording, span=span, track=track)

    def whole(self, given: str, topic: str | None = None) -> Opened:
        """Return all of a recording."""
        with self._sources.opened(given) as path:
            key, oldest_s = _key(given, path, topic), time.monotonic() - KEPT_OPEN_S
            with self._lock:
                for old in [old for old, each in self._kept.items() if each.last_s < oldest_s]:
                    del self._kept[old]
                opened = self._kept.setdefault(key, Opened())
            with opened.lock:
                if opened.shown is None:
                    opened.recording, opened.shown = self._read(given, path, topic)
            with self._lock:
                opened.last_s = time.monotonic()
                self._kept[key] = opened
                self._kept.move_to_end(key)
                while sum(each.size_bytes for each in self._kept.values()) > KEPT_OPEN_BYTES:
                    self._kept.popitem(last=False)
            return opened

    def let_go(self) -> bool:
        """Close the recording that was asked about longest ago; return whether one was open."""
        with self._lock:
            return bool(self._kept) and bool(self._kept.popitem(last=False))

    def _read(self, given: str, path: Path, topic: str | None) -> tuple[Any, LoadedClip]:
        recording = read_named(str(path), topic)
        if not (given.startswith("data:") or Path(given).is_absolute() or "://" in given):
            recording = replace(recording, name=given)  # with its folders
        shown = perceive(self._answerer, recording)
        # Once tracked, its idle gel is known: a span need not look for it again.
        return shown.encoded.recording or recording, shown


def _key(given: str, path: Path, topic: str | None) -> str:
    """Return what tells a recording from others, and from itself once it was changed."""
    if given.startswith("data:"):
        content = path.read_bytes()
    else:
        files = sorted(path.iterdir()) if path.is_dir() else [path]
        states = [(str(file), file.stat().st_mtime_ns, file.stat().st_size) for file in files]
        content = repr((str(path), states)).encode()
    return repr((hashlib.sha256(content).hexdigest(), topic))
