"""`geotlm-lm info` and `doctor`: what a recording holds, and what is wrong with it; no answers."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geotlm_lm.cli.options import (
    AsJson,
    BundleFolder,
    Encoder,
    Reading,
    Recording,
    argument,
    grouped,
    path_of,
)
from geotlm_lm.core.errors import UsageError

if TYPE_CHECKING:
    from geotlm_lm.core.clip import Clip
    from geotlm_lm.doctor.examine import Finding

ESTIMATED = "estimated from the frames"

CAMERA_FRAMES = 75
"""Frames of a camera that are looked at: three seconds of most."""

INSTALLATION = "the installation"


@grouped
def info(*, recording: Recording, as_json: AsJson = False, encoder: Encoder) -> None:
    """Describe a recording: size, frame rate, idle gel, from when to when it is touched, warnings.

    With --weights, describe a released encoder's file: what was recognised, parameters, tokens.

    Example: geotlm-lm info recording.mov
    """
    if (recording.file is None) == (encoder.weights is None):
        raise UsageError("give a recording, or --weights with the file of a released encoder.")
    if encoder.weights is not None:
        from geotlm_lm.backbone.released import load_encoder

        facts = load_encoder(encoder.weights, encoder.encoder, heads=encoder.heads).describe()
    else:
        span = recording.span
        facts = describe(recording.read(), span)
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


@grouped
def doctor(
    *,
    source: str | None = argument(
        "SOURCE", "A recording, a camera's number or its device file. [default: the installation]"
    ),
    as_json: AsJson = False,
    reading: Reading,
    model: BundleFolder = None,
) -> None:
    """Examine a recording: rate, dropped and repeated frames, colours, light, idle gel, markers.

    Each finding says what was measured, what it means for the answers, and what to set. Without a
    source the installation is examined: versions, extras, cameras, and one answer of the model.

    Example: geotlm-lm doctor recording.mov
    """
    if source is None:
        from geotlm_lm.doctor.installation import examine_installation

        _print_findings(INSTALLATION, examine_installation(model), (), as_json=as_json)
        return
    from geotlm_lm.doctor.examine import examine
    from geotlm_lm.recordings.read import each_frame, read_clip

    if source.isdecimal() or source.startswith("/dev/"):
        clip, frames = _from_camera(source, reading.fps), None
    else:
        clip = read_clip(path_of(source), **vars(reading))
        is_square = bool(reading.square_pixels)
        frames = each_frame(clip, square_pixels=is_square, topic=reading.topic)
    _print_findings(source, examine(clip, frames), clip.notes, as_json=as_json)


def _from_camera(source: str, fps: float | None) -> Clip:
    """Return the first frames of a camera as a clip, with their times."""
    from contextlib import closing
    from itertools import islice

    import numpy as np

    from geotlm_lm.core.clip import Clip
    from geotlm_lm.recordings.streams import open_source

    stream = open_source(source, fps=fps)
    with closing(iter(stream)) as frames:
        taken = list(islice(frames, CAMERA_FRAMES))
    times_s = tuple(frame.time_s - taken[0].time_s for frame in taken)
    return Clip(np.stack([frame.image for frame in taken]), fps=fps, name=source, times_s=times_s)


def _print_findings(
    source: str, findings: list[Finding], notes: tuple[str, ...], *, as_json: bool
) -> None:
    faults = [finding.subject for finding in findings if finding.verdict == "fault"]
    if as_json:
        plain = [finding.to_dict() for finding in findings]
        print(json.dumps({"source": source, "faults": faults, "findings": plain,
                          "notes": list(notes)}))  # fmt: skip
        return
    for finding in findings:
        print("\n".join(finding.lines()))
    for note in notes:
        print(f"{'note':<8}{note}")
    verdict = f"{len(faults)} to repair: {', '.join(faults)}." if faults else "Nothing to repair."
    print(f"\n{Path(source).name or source}: {verdict}")
