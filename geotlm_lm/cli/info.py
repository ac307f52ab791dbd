"""`geotlm-lm info`: what a recording holds, or a released encoder's file; answers nothing."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from geotlm_lm.cli.grouped import Reading, grouped
from geotlm_lm.cli.options import (
    AsJson,
    EncoderHeads,
    EncoderName,
    EncoderWeights,
    FrameSpan,
    path_option,
    span_of,
)

if TYPE_CHECKING:
    from geotlm_lm.core.clip import Clip

ESTIMATED = "estimated from the frames"


@grouped
def info(
    *,
    clip: Annotated[Path | None, path_option(help="Recording, as for `geotlm-lm answer`.")] = None,
    as_json: AsJson = False,
    frames: FrameSpan = None,
    reading: Reading,
    encoder: EncoderName = None,
    weights: EncoderWeights = None,
    heads: EncoderHeads = None,
) -> None:
    """Describe a recording: size, frame rate, idle gel, from when to when it is touched, warnings.

    With --weights, describe a released encoder's file: what was recognised, parameters, tokens.

    Example: geotlm-lm info --clip recording.mov
    """
    from geotlm_lm.core.errors import UsageError

    if (clip is None) == (weights is None):
        raise UsageError(
            "give --clip with a recording, or --weights with the file of a released encoder."
        )
    if weights is not None:
        from geotlm_lm.backbone.released import load_encoder

        facts = load_encoder(weights, encoder, heads=heads).describe()
    else:
        from geotlm_lm.recordings.read import read_clip

        span = span_of(frames)
        facts = describe(read_clip(clip, **vars(reading)), span)
    if as_json:
        print(json.dumps(facts))
        return
    for name, value in facts.items():
        lines = value if isinstance(value, list) and name == "notes" else [value]
        for line in lines:
            print(f"{name.replace('_', ' ')}: {_words(line)}")


def describe(recording: Clip, span: tuple[int, int] | None = None) -> dict[str, Any]:
    """Return what is known about a recording, or about a span of it, without any model."""
    import numpy as np

    from geotlm_lm.recordings.idle import (
        FAINT_IMPRINT,
        estimate_background,
        find_idle,
        imprint_strength,
    )
    from geotlm_lm.recordings.read import frames_inside

    origin = "given" if recording.background is not None else "found in the recording"
    idle = recording.background if origin == "given" else find_idle(recording)
    inside = recording if span is None else frames_inside(recording, span)
    if idle is None:
        origin, idle = ESTIMATED, estimate_background(inside.frames)
    inside = replace(inside, background=idle)
    strength = imprint_strength(inside)
    contact = _contact(origin, inside, int(np.argmax(strength)))
    touched = [inside.frame_numbers[place] for place in np.flatnonzero(strength >= FAINT_IMPRINT)]
    return {
        "clip": recording.name,
        "frames": len(recording),
        "size_px": [recording.frames.shape[2], recording.frames.shape[1]],
        "dtype": str(recording.frames.dtype),
        "value_range": [int(recording.frames.min()), int(recording.frames.max())],
        "fps": recording.fps,
        "background": origin,
        "contact": contact,
        "touched_frames": [touched[0], touched[-1]] if touched and contact == "likely" else None,
        "strongest_imprint_grey_levels": round(float(strength.max()), 2),
        "notes": list(recording.notes),
    }


def _contact(origin: str, inside: Clip, strongest: int) -> str:
    """Return whether something touches around the frame with the strongest imprint."""
    if origin == ESTIMATED:
        return "unknown without an idle frame"
    from geotlm_lm.recordings.touch import UNTOUCHED_GREY, change_from_idle

    around = range(max(strongest - 1, 0), min(strongest + 2, len(inside)))
    change = change_from_idle(inside.select(list(around)))
    return "likely" if change.grey >= UNTOUCHED_GREY or change.is_beyond_noise else "none seen"


def _words(value: Any) -> str:
    if value is None:
        return "unknown"
    if isinstance(value, list):
        return " ".join(str(part) for part in value)
    return str(value)
