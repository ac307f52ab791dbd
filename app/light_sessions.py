"""A visitor's session describes a part of the page only once that part was changed for it.

The toolkit describes every part anew for every session, and every call of a program is one: this
took more time than the answer, and a quarter of a MiB for as long as sessions are kept.
"""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

from gradio.state_holder import SessionState, StateHolder

from .budget import WORKING
from .clip_loading import LoadedClip
from .live_session import LiveSession


class LightSessions(StateHolder):
    """Holds the sessions of a page.

    Args:
        page: Whose they are (a `gradio.Blocks` that is served).
    """

    def __init__(self, page: Any) -> None:
        super().__init__()
        self.set_blocks(page)
        WORKING.may_let_go(self)

    def let_go(self) -> bool:
        """Close what the visitor has open who was away longest; tell whether anybody had."""
        for session in list(self.session_data.values()):
            for key, value in list(session.state_data.items()):
                if isinstance(value, LoadedClip):
                    session.state_data.pop(key, None)
                    return True
                if isinstance(value, LiveSession) and value.stream is not None:
                    value.stream = None
                    return True
        return False

    def __getitem__(self, session_id: str) -> SessionState:
        """Return a session; one that is not known yet is begun."""
        if session_id not in self.session_data:
            self.session_data[session_id] = LightSession(self.blocks)
        return super().__getitem__(session_id)


class LightSession(SessionState):
    """One session; the descriptions it holds are of parts that were changed for it.

    Args:
        page: That is visited.
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
