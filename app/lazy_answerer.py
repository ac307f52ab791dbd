"""Load the model in the background while the page is already served; first use waits."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from geotlm_lm import Answerer


class LazyAnswerer:
    """Stands for an `Answerer` and becomes it at its first use: a page need not wait for it.

    Args:
        load: Loads the model; called once, by whichever thread comes first.
    """

    def __init__(self, load: Callable[[], Answerer]) -> None:
        self._load, self._lock = load, Lock()
        self._loaded: Answerer | None = None

    def load(self) -> Answerer:
        """Return the model; everybody else waits while one thread loads it.

        Raises:
            GeoTLMError: If it cannot be loaded; the next call tries again.
        """
        with self._lock:
            if self._loaded is None:
                self._loaded = self._load()
            return self._loaded

    def __getattr__(self, name: str) -> Any:
        return getattr(self.load(), name)
