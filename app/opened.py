"""Recordings that tools were asked about stay open for the next question: read and tracked once."""

from __future__ import annotations

import hashlib
import time
from collections import OrderedDict
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any

from .budget import WORKING
from .clip_loading import LoadedClip, perceive, read_named
from .limits import KEPT_OPEN_BYTES, KEPT_OPEN_S
from .sources import Sources

if TYPE_CHECKING:
    from geotlm_lm import Answerer


@dataclass(frozen=True, eq=False)
class Opened:
    """A recording that was read.

    Args:
        recording: All frames that are kept.
        shown: As it was perceived whole.
        last_s: When it was last asked for.
    """

    recording: Any
    shown: LoadedClip
    last_s: float

    @property
    def size_bytes(self) -> int:
        """What its frames take."""
        return self.recording.frames.nbytes


class OpenedRecordings:
    """Opens recordings once each, whoever asks at the same time, and keeps the last ones.

    Args:
        answerer: The model.
        sources: Find what is given.
    """

    def __init__(self, answerer: Answerer, sources: Sources) -> None:
        self._answerer, self._sources = answerer, sources
        self._kept: OrderedDict[str, Opened] = OrderedDict()
        self._opening: dict[str, Lock] = {}
        self._lock = Lock()
        WORKING.may_let_go(self)

    def open(
        self, given: str, frames: list[int] | None = None, topic: str | None = None
    ) -> LoadedClip:
        """Return a recording, or a span of it, ready for questions.

        Args:
            given: A name, a data URI or an upload.
            frames: First and last frame; None for all.
            topic: Of a bag's images; None where it has images on one topic only.

        Raises:
            GeoTLMError: If there is none, or it cannot be read.
        """
        whole = self.whole(given, topic)
        if frames is None:
            return whole.shown
        track = whole.shown.encoded.track
        span = (frames[0], frames[1])
        return perceive(self._answerer, whole.recording, span=span, track=track)

    def whole(self, given: str, topic: str | None = None) -> Opened:
        """Return all of a recording; parameters as of `open`.

        Raises:
            GeoTLMError: If there is none, or it cannot be read.
        """
        with self._sources.opened(given) as path:
            key = _key(given, path, topic)
            with self._lock:
                opening = self._opening.setdefault(key, Lock())
            try:
                with opening:
                    found = self._found(key)
                    if found is None:
                        found = self._read(given, path, topic)
                        self._keep(key, found)
                    return found
            finally:
                with self._lock:
                    if not opening.locked():
                        self._opening.pop(key, None)

    def let_go(self) -> bool:
        """Close the recording that was asked about longest ago; tell whether one was open."""
        with self._lock:
            return bool(self._kept) and bool(self._kept.popitem(last=False))

    def _read(self, given: str, path: Path, topic: str | None) -> Opened:
        recording = read_named(str(path), topic)
        if not given.startswith("data:") and path.name != given:
            recording = replace(recording, name=_shown_name(given, path))
        shown = perceive(self._answerer, recording)
        # Once tracked, its idle gel is known: a span need not look for it again.
        if shown.encoded.recording is not None:
            recording = shown.encoded.recording
        return Opened(recording, shown, time.monotonic())

    def _found(self, key: str) -> Opened | None:
        with self._lock:
            self._forget(lambda one: time.monotonic() - one.last_s > KEPT_OPEN_S)
            found = self._kept.pop(key, None)
            if found is not None:
                found = replace(found, last_s=time.monotonic())
                self._kept[key] = found
            return found

    def _keep(self, key: str, opened: Opened) -> None:
        with self._lock:
            self._kept[key] = opened
            while sum(one.size_bytes for one in self._kept.values()) > KEPT_OPEN_BYTES:
                self._kept.popitem(last=False)

    def _forget(self, is_old: Any) -> None:
        for key in [key for key, one in self._kept.items() if is_old(one)]:
            del self._kept[key]


def _key(given: str, path: Path, topic: str | None) -> str:
    """Return what tells a recording from others, and from itself once it was changed."""
    if given.startswith("data:"):
        told: Any = path.read_bytes()
    else:
        files = sorted(path.iterdir()) if path.is_dir() else [path]
        states = [(str(one), one.stat().st_mtime_ns, one.stat().st_size) for one in files]
        told = repr((str(path), states)).encode()
    return repr((hashlib.sha256(told).hexdigest(), topic))


def _shown_name(given: str, path: Path) -> str:
    """Return what a recording is called: as it was given, but for the folder of an upload."""
    return path.name if Path(given).is_absolute() or "://" in given else given
