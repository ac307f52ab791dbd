"""Peak memory of one way to answer, for a fresh process; imports only what that way needs."""

from __future__ import annotations

import resource
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from geotlm_lm.core.clip import Clip

MANY = 64

WAYS = ("flow + fit", "probe on z", "LM scored", "LM generated", f"LM generated, batch {MANY}")


def peak_megabytes(way: str, clip_path: Path, model: Path | None = None) -> float:
    """Answer once and return the most memory this process has ever held.

    Args:
        way: One of `WAYS`.
        clip_path: A recording of four frames and a background.
        model: A bundle's folder; None for the one that ships.

    Raises:
        ValueError: If the way is unknown.
    """
    if way not in WAYS:
        raise ValueError(f"found way {way!r}, expected one of {WAYS}")
    from geotlm_lm.recordings.read import read_clip

    clip = read_clip(clip_path)
    if way == "flow + fit":
        from geotlm_lm.probe.rigid_flow import RigidFlow

        RigidFlow().predict(clip)
    else:
        _answer(way, clip, model)
    return _own_most_held_megabytes()


def most_held_megabytes(process: int) -> float | None:
    """Return the most memory that another process has ever held, in MiB.

    Args:
        process: Its number; it has to be running still.

    Returns:
        None where the system does not tell, as all but Linux.
    """
    return _high_water(str(process))


def _high_water(process: str) -> float | None:
    try:
        status = Path(f"/proc/{process}/status").read_text()
    except OSError:
        return None
    held = [line for line in status.splitlines() if line.startswith("VmHWM:")]
    return int(held[0].split()[1]) / 2**10 if held else None


def _own_most_held_megabytes() -> float:
    # Linux hands a process's ru_maxrss on to what it starts; its other figure is its own.
    if (own := _high_water("self")) is not None:
        return own
    held = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return held / (2**20 if sys.platform == "darwin" else 2**10)  # bytes there, KiB elsewhere


def _answer(way: str, clip: Clip, model: Path | None) -> None:
    import torch

    from geotlm_lm.answering import Answerer
    from geotlm_lm.experiments.judging import QUESTION

    torch.set_num_threads(1)
    answerer = Answerer.load(model)
    bundle = answerer.bundle
    if way == "probe on z":
        bundle.model.probe.predict(bundle.model.perceive([clip]).fused_token)
    elif way == "LM scored":
        answerer.score(answerer.encode(clip), QUESTION)
    elif way == "LM generated":
        answerer.ask(answerer.encode(clip), QUESTION)
    else:
        tokens = bundle.model.perceive([clip] * MANY).fused_token
        bundle.speaker.generate(tokens, [QUESTION] * MANY)
