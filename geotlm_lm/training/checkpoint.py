"""Checkpoints of a run that may be interrupted: written atomically, read back exactly."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import torch

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.files import replacing


def save_checkpoint(path: Path, state: dict[str, Any]) -> None:
    """Write `state` (tensors and plain values) so that a kill leaves the old file or the new."""
    with replacing(path) as stream:
        torch.save(state, stream)


def load_checkpoint(path: Path) -> dict[str, Any] | None:
    """Return the state saved at `path`, or None where there is none.

    Raises:
        UsageError: If the file cannot be read.
    """
    if not path.exists():
        return None
    try:
        return torch.load(path, weights_only=True, map_location="cpu")
    except Exception as error:
        raise UsageError(
            f"{path}: the checkpoint cannot be read ({type(error).__name__}); delete it to start "
            f"this stage again."
        ) from error
