"""What a visitor uploaded goes when the visitor leaves, and a live picture once it was seen."""

from __future__ import annotations

import time
from collections import defaultdict
from contextlib import suppress
from pathlib import Path
from typing import Any

from .error_display import gradio

SHOWN_S = 10.0
"""Time in which a browser has long fetched a live picture; ten of them come a second."""

LATE_S = 10.0
"""Time in which a page that was closed may still tell of an upload; after that it has come back."""

DELETE_CACHE = (600, 86400)
"""Every ten minutes, what is older than a day goes: programs have no visit that ends."""


class SessionFiles:
    """Knows which session uploaded what; the same recording of two sessions is one file."""

    def __init__(self) -> None:
        self._held: dict[str, set[str]] = defaultdict(set)
        self._ended_s: dict[str, float] = {}

    def hold(self, session: str, paths: list[str] | str | None) -> None:
        """Note what a session has uploaded; what arrives just after its end goes at once."""
        given = [paths] if isinstance(paths, str) else paths or []
        self._held[session].update(given)
        if time.time() - self._ended_s.get(session, -LATE_S) < LATE_S:
            self._release(session)

    def drop(self, session: str) -> None:
        """Remove the uploads of a session that has ended, unless another holds them as well."""
        now = time.time()
        self._ended_s = {one: at for one, at in self._ended_s.items() if now - at < LATE_S}
        self._ended_s[session] = now
        self._release(session)

    def _release(self, session: str) -> None:
        ended = self._held.pop(session, set())
        for path in ended - set().union(*self._held.values()):
            _remove(path)


def connect(page: Any, files: list[Any]) -> None:
    """Have what is uploaded to these fields removed with its session; inside the `gradio.Blocks`.

    Args:
        page: The `gradio.Blocks`.
        files: Its upload fields.
    """
    gr = gradio()
    kept = SessionFiles()

    def hold(paths: Any, request: Any) -> None:
        kept.hold(request.session_hash, paths)

    def drop(request: Any) -> None:
        kept.drop(request.session_hash)

    # Postponed annotations are text, and the toolkit looks for the request's type itself.
    hold.__annotations__["request"] = drop.__annotations__["request"] = gr.Request
    for file in files:
        file.upload(hold, file, None, api_visibility="private", queue=False, show_progress="hidden")
    page.unload(drop)


def remove_seen(component: Any) -> None:
    """Remove the files of a component that were shown so long ago that nobody fetches them."""
    for path in set(component.temp_files):
        try:
            is_seen = time.time() - Path(path).stat().st_ctime > SHOWN_S
        except FileNotFoundError:
            is_seen = True
        if is_seen:
            _remove(path)
            component.temp_files.discard(path)


def _remove(path: str) -> None:
    """Remove a file of the toolkit's folder, and its own folder in there."""
    Path(path).unlink(missing_ok=True)
    with suppress(OSError):  # something else lies there
        Path(path).parent.rmdir()
