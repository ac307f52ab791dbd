"""The model that a process answers with, whatever it is given to do: loaded once."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from geotlm_lm.answering.answerer import Answerer


@lru_cache(maxsize=1)
def loaded(model: Path | None) -> Answerer:
    """Return the answerer of a bundle; arguments and errors are those of `Answerer.load`."""
    return Answerer.load(model)
