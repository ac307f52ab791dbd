"""`geotlm-lm track`: what happens in a whole recording, as a table, files, a plot, a video."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geotlm_lm.cli.grouped import Answering, Reading, grouped
from geotlm_lm.cli.options import Force, FrameSpan, path_of, span_of
from geotlm_lm.cli.progress import progress_on_stderr
from geotlm_lm.cli.recording import CameraName, EpisodeNumber, read_recording
from geotlm_lm.cli.tracked import (
    HEAD,
    INTERRUPTED,
    NO_EVENTS,
    OutFile,
    PlotFile,
    RerunFile,
    Targets,
    VideoFile,
    aligned,
    event_line,
    totals_lines,
)
from geotlm_lm.cli.viewer import write_or_serve
from geotlm_lm.core.process import uninterrupted_step

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer
    from geotlm_lm.core.clip import Clip
    from geotlm_lm.track.export import Exported
    from geotlm_lm.track.track import Track


@grouped
def track(
    *,
    recording: Annotated[
        Path,
        typer.Argument(parser=path_of, metavar="RECORDING", help="As for `geotlm-lm answer`."),
    ],
    as_json: Annotated[
        bool, typer.Option("--json", help="Print events and totals as one JSON object.")
    ] = False,
    out: OutFile = None,
    plot: PlotFile = None,
    video: VideoFile = None,
    rerun: RerunFile = None,
    force: Force = False,
    frames: FrameSpan = None,
    reading: Reading,
    answering: Answering,
    episode: EpisodeNumber = None,
    camera: CameraName = None,
) -> None:
    """Track a whole recording: what touches when, how it moves, how far.

    Directions are told as seen in the camera image, for the object relative to the sensor. Ctrl-C
    ends the recording there.

    Example: geotlm-lm track recording.mov --out track.csv --plot track.png
    """
    targets = Targets(out, plot, video, rerun)
    inputs = [one for one in (recording, reading.background) if one is not None]
    targets.require(inputs, is_forced=force)
    from geotlm_lm.recordings.legible import require_any_legible
    from geotlm_lm.recordings.read import frames_inside

    span, scale = span_of(frames), answering.frame.mm_per_px
    clip = read_recording(recording, episode, camera, reading)
    require_any_legible(clip if span is None else frames_inside(clip, span))

    from geotlm_lm.track.export import Exported

    answerer = answering.load()
    # As it was read with: what does not fit into memory is decoded anew, frame by frame.
    again = {"square_pixels": bool(reading.square_pixels), "topic": reading.topic}
    tracked, is_stopped = _tracked(answerer, clip, span, again)
    exported = Exported(tracked, scale)
    in_frames = not clip.is_timed
    targets.write(exported, clip.name, clip.fps, in_frames=in_frames)
    if video is not None:
        _film(video, exported, clip, again)
    for note in (*clip.notes, *tracked.notes):
        print(f"note: {note}", file=sys.stderr)
    if as_json:
        print(json.dumps(exported.to_dict()))
    else:
        print("\n".join(table(exported, in_frames=in_frames)))
    if rerun is not None:
        write_or_serve(rerun, lambda path: _log(path, exported, clip, again))
    if is_stopped:
        print(f"note: Tracked as far as frame {tracked.numbers[-1]}.", file=sys.stderr)
        raise typer.Exit(INTERRUPTED)


def _tracked(
    answerer: Answerer, clip: Clip, span: tuple[int, int] | None, reading: dict[str, Any]
) -> tuple[Track, bool]:
    """Return the track of a recording, or of a span, and whether Ctrl-C ended it early.

    Raises:
        KeyboardInterrupt: If no two frames were tracked by then.
    """
    from geotlm_lm.recordings.read import each_frame
    from geotlm_lm.track.tracker import ASSUMED_FPS

    tracker, show, is_stopped = answerer.tracker(clip), progress_on_stderr("frames"), False
    last = span[1] if span else clip.frame_numbers[-1]
    total, done = last + 1, 0
    try:
        for number, frame in each_frame(clip, **reading):
            if span is not None and number > last:
                break
            with uninterrupted_step():
                tracker.feed(frame, clip.second_of(number, ASSUMED_FPS), number)
                done = number + 1
            if done < total:
                show("tracking", done, total)
    except KeyboardInterrupt:
        is_stopped = True
        if done < 2 or (span is not None and done <= span[0] + 1):
            raise
    show("tracking", done, done if is_stopped else total)
    found = tracker.finish()
    if span is None:
        return found, is_stopped
    return found.between(span[0], min(span[1], int(found.numbers[-1]))), is_stopped


def _film(path: Path, exported: Exported, clip: Clip, reading: dict[str, Any]) -> None:
    from geotlm_lm.recordings.read import each_frame
    from geotlm_lm.track.film import write_film
    from geotlm_lm.track.tracker import ASSUMED_FPS

    first, second = exported.track.numbers[:2]
    rate = (clip.fps or ASSUMED_FPS) / int(second - first)
    write_film(path, exported, each_frame(clip, **reading), rate)


def _log(path: Path, exported: Exported, clip: Clip, reading: dict[str, Any]) -> None:
    from geotlm_lm.track.rerun_log import log_track, rerun_recording

    with rerun_recording(path) as stream:
        log_track(stream, exported, clip, **reading)


def table(exported: Exported, *, in_frames: bool) -> list[str]:
    """Return the events of a track as lines of a table, and what they come to.

    Args:
        exported: The track.
        in_frames: Whether to tell frame numbers instead of seconds.
    """
    events = exported.track.events
    if not events:
        return [NO_EVENTS]
    lines = [event_line(one, exported.units, in_frames=in_frames) for one in events]
    return [aligned(HEAD), *lines, "", *totals_lines(exported)]
