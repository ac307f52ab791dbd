"""Replies that tell no motion, as prompts/replies.toml words them."""

from __future__ import annotations

import tomllib
from functools import lru_cache
from typing import Any

from geotlm_lm.core.files import resource_dir


@lru_cache(maxsize=1)
def replies() -> dict[str, Any]:
    """Return the replies: `help`, and by reason or topic `missing`, `untold` and `talk`."""
    return tomllib.loads((resource_dir("prompts") / "replies.toml").read_text("utf-8"))
