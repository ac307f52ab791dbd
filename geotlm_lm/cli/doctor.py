"""`geotlm-lm doctor`: what is wrong with a recording, a camera or the installation."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from geotlm_lm.cli.grouped import Reading, grouped
from geotlm_lm.cli.options import AsJson, BundleFolder, path_of

if TYPE_CHECKING:
    from geotlm_lm.core.clip import Clip
    from geotlm_lm.doctor.examine import Finding

CAMERA_FRAMES = 75
"""Frames of a camera that are looked at: three seconds of most."""

INSTALLATION = "the installation"


@grouped
def doctor(
    *,
    source: Annotated[
        str | None,
        typer.Argument(
            metavar="[SOURCE]",
            help="A recording, a camera's number or its device file. [default: the installation]",
        ),
    ] = None,
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

        _tell(INSTALLATION, examine_installation(model), (), as_json=as_json)
        return
    from geotlm_lm.doctor.examine import examine
    from geotlm_lm.recordings.read import each_frame, read_clip

    if source.isdecimal() or source.startswith("/dev/"):
        clip, frames = _from_camera(source, reading.fps), None
    else:
        clip = read_clip(path_of(source), **vars(reading))
        is_square = bool(reading.square_pixels)
        frames = each_frame(clip, square_pixels=is_square, topic=reading.topic)
    _tell(source, examine(clip, frames), clip.notes, as_json=as_json)


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
    first_s = taken[0].time_s
    return Clip(
        np.stack([one.image for one in taken]),
        fps=fps,
        name=source,
        times_s=tuple(one.time_s - first_s for one in taken),
    )


def _tell(source: str, findings: list[Finding], notes: tuple[str, ...], *, as_json: bool) -> None:
    faults = [one.subject for one in findings if one.verdict == "fault"]
    if as_json:
        told = {"source": source, "faults": faults, "findings": [one.to_dict() for one in findings]}
        print(json.dumps(told | {"notes": list(notes)}))
        return
    for one in findings:
        print("\n".join(one.lines()))
    for note in notes:
        print(f"{'note':<8}{note}")
    told = f"{len(faults)} to repair: {', '.join(faults)}." if faults else "Nothing to repair."
    print(f"\n{Path(source).name or source}: {told}")
