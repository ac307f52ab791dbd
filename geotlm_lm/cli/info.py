"""`geotlm-lm info`: what a recording holds, or a released encoder's file; answers nothing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from geotlm_lm.cli.options import (
    AsJson,
    Background,
    EncoderHeads,
    EncoderName,
    EncoderWeights,
    FrameSpan,
    FramesPerSecond,
    LayoutName,
    SquarePixels,
    path_option,
    span_of,
)

if TYPE_CHECKING:
    from geotlm_lm.core.clip import Clip

ESTIMATED = "estimated from the frames"


def info(
    clip: Annotated[Path | None, path_option(help="Recording, as for `geotlm-lm answer`.")] = None,
    as_json: AsJson = False,
    frames: FrameSpan = None,
    layout: LayoutName = None,
    background: Background = None,
    fps: FramesPerSecond = None,
    square_pixels: SquarePixels = None,
    encoder: EncoderName = None,
    weights: EncoderWeights = None,
    heads: EncoderHeads = None,
) -> None:
    """Describe a recording: size, frame rate, frames that would be used, contact, warnings.

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
        recording = read_clip(
            clip, layout=layout, fps=fps, background=background, square_pixels=square_pixels
        )
        facts = describe(recording, span)
    if as_json:
        print(json.dumps(facts))
        return
    for name, value in facts.items():
        lines = value if isinstance(value, list) and name == "notes" else [value]
        for line in lines:
            print(f"{name.replace('_', ' ')}: {_words(line)}")


def describe(recording: Clip, span: tuple[int, int] | None = None) -> dict[str, Any]:
    """Return what is known about a recording and the frames chosen from it, or from `span`."""
    from dataclasses import replace

    from geotlm_lm.recordings.choose import choose_frames
    from geotlm_lm.recordings.idle import estimate_background
    from geotlm_lm.recordings.imprints import imprint_strength

    chosen = choose_frames(recording, span=span)
    origin = "given" if recording.background is not None else "found in the recording"
    if chosen.background is None:
        origin = ESTIMATED
        chosen = replace(chosen, background=estimate_background(chosen.frames))
    strength = [round(float(value), 2) for value in imprint_strength(chosen)]
    return {
        "clip": recording.name,
        "frames": len(recording),
        "size_px": [recording.frames.shape[2], recording.frames.shape[1]],
        "dtype": str(recording.frames.dtype),
        "value_range": [int(recording.frames.min()), int(recording.frames.max())],
        "fps": recording.fps,
        "frames_used": list(chosen.frame_numbers),
        "background": origin,
        "imprint_grey_levels": strength,
        "contact": _contact(origin, chosen),
        "notes": list(chosen.notes),
    }


def _contact(origin: str, chosen: Clip) -> str:
    if origin == ESTIMATED:
        return "unknown without an idle frame"
    from geotlm_lm.recordings.touch import UNTOUCHED_GREY, change_from_idle

    change = change_from_idle(chosen)
    return "likely" if change.grey >= UNTOUCHED_GREY or change.is_beyond_noise else "none seen"


def _words(value: Any) -> str:
    if value is None:
        return "unknown"
    if isinstance(value, list):
        return " ".join(str(part) for part in value)
    return str(value)
