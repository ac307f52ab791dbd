"""What the toolkit's sessions lack: an order for each visitor, little memory, no files left."""

import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from gradio import File, Request
from gradio.state_holder import SessionState, StateHolder

from . import guards
from .clips import LoadedClip
from .toolkit import QUIET

SHOWN_S = 10.0
"""Time in which a browser has long fetched a live picture; ten of them come a second."""

LATE_S = 10.0
"""Time in which a page that was closed may still report an upload; after that it has come back."""

DELETE_CACHE = (600, 86400)
"""Every ten minutes, what is older than a day goes: programs have no visit that ends."""


def keep_order(queue: Any, line: str) -> None:
    """Let a toolkit's queue begin no request of a session that has one running already.

    A question asked while a recording is still being read is about that recording, and of two that
    were opened the one clicked last is shown. The toolkit orders all visitors' requests or none.
    This holds for the requests of one line (`concurrency_id`).
    """
    first_ready: Callable[[], Any] = queue.get_events

    def get_events() -> Any:
        waiting = queue.event_queue_per_concurrency_id.get(line)
        if waiting is None:
            return first_ready()
        running = {
            event.session_hash
            for job in queue.active_jobs
            for event in job or ()
            if event.concurrency_id == line
        }
        everyone = waiting.queue
        waiting.queue = [event for event in everyone if event.session_hash not in running]
        chosen = first_ready()
        begun = chosen[0] if chosen else ()
        waiting.queue = [event for event in everyone if event not in begun]
        return chosen

    queue.get_events = get_events


class LightSessions(StateHolder):
    """Holds the sessions of a page that is served (a `gradio.Blocks`)."""

    def __init__(self, page: Any) -> None:
        super().__init__()
        self.set_blocks(page)
        guards.MEMORY.may_let_go(self)

    def let_go(self) -> bool:
        """Close what the visitor has open who was away longest, and return whether anybody had."""
        for session in list(self.session_data.values()):
            for key, value in list(session.state_data.items()):
                if isinstance(value, LoadedClip):
                    session.state_data.pop(key, None)
                    return True
                if getattr(value, "stream", None) is not None:  # what is watched live
                    value.stream = None
                    return True
        return False

    def __getitem__(self, session_id: str) -> SessionState:
        if session_id not in self.session_data:
            self.session_data[session_id] = LightSession(self.blocks)
        return super().__getitem__(session_id)


class LightSession(SessionState):
    """A session that describes a part of the page only once that part was changed for it.

    The toolkit describes every part anew for every session, and every call of a program is one:
    this took more time than the answer, and a quarter of a MiB for as long as sessions are kept.
    """

    def __init__(self, page: Any) -> None:
        described_at_once: tuple[int, ...] = ()
        super().__init__(
            SimpleNamespace(default_config=page.default_config, blocks=described_at_once)
        )

    @property
    def components(self) -> Iterator[dict[str, Any]]:
        """All parts as this visitor sees them."""
        for key, block in self.blocks_config.blocks.items():
            changed = self.config_values.get(key)
            yield changed or self.blocks_config.config_for_block(key, [], block)


class SessionFiles:
    """Knows which session uploaded what; the same recording of two sessions is one file."""

    def __init__(self) -> None:
        self._held: dict[str, set[str]] = defaultdict(set)
        self._ended_s: dict[str, float] = {}

    def hold(self, paths: list[str] | str | None, request: Request) -> None:
        """Note what a session has uploaded; what arrives just after its end goes at once."""
        session = request.session_hash
        self._held[session].update([paths] if isinstance(paths, str) else paths or [])
        if time.time() - self._ended_s.get(session, -LATE_S) < LATE_S:
            self._release(session)

    def drop(self, request: Request) -> None:
        """Remove the uploads of a session that has ended, unless another holds them as well."""
        session, now = request.session_hash, time.time()
        self._ended_s = {name: at for name, at in self._ended_s.items() if now - at < LATE_S}
        self._ended_s[session] = now
        self._release(session)

    def _release(self, session: str) -> None:
        ended = self._held.pop(session, set())
        for path in ended - set().union(*self._held.values()):
            _remove(path)


def remove_uploads_with_session(page: Any) -> None:
    """Remove what is uploaded to a page's fields with its session; inside the `gradio.Blocks`."""
    files = SessionFiles()
    for field in [block for block in page.blocks.values() if type(block) is File]:
        field.upload(files.hold, field, None, queue=False, **QUIET)
    page.unload(files.drop)


def remove_seen(component: Any) -> None:
    """Remove the files of a component that were shown so long ago that no browser fetches them."""
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
