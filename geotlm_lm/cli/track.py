"""`geotlm-lm track`: what happens in a whole recording, as a table, files, a plot, a video.

What `watch` prints and writes of a track is here as well.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from geotlm_lm.cli.options import (
    AllOutputs,
    Answering,
    Recording,
    TrackOutputs,
    command_line,
    grouped,
    option,
)
from geotlm_lm.cli.progress import print_notes, progress_on_stderr
from geotlm_lm.core.figures import figure_of
from geotlm_lm.core.process import uninterrupted_step

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer
    from geotlm_lm.core.clip import Clip
    from geotlm_lm.track.events import Event
    from geotlm_lm.track.export import Exported, Units
    from geotlm_lm.track.track import Track

INTERRUPTED = 130
"""Exit code of a command stopped by Ctrl-C; what was tracked by then is written."""

NO_EVENTS = "Nothing touches in the recording."
NO_MOTION = "Nothing turns or slides in the recording."

UNREADABLE = "{}; the pictures do not tell how far"

HEAD = ("begin", "end", "what", "how far", "likely", "sure")
WIDTHS = (21, 8, 14, 4)


@grouped
def track(
    *,
    recording: Recording,
    as_json: bool = option("Print events and totals as one JSON object.", "--json", default=False),
    outputs: AllOutputs,
    answering: Answering,
) -> None:
    """Track a whole recording: what touches when, how it moves, how far.

    Directions are told as seen in the camera image, for the object relative to the sensor. Ctrl-C
    ends the recording there.

    Example: geotlm-lm track recording.mov --out track.csv --plot track.png
    """
    inputs = [path for path in (recording.path, recording.background) if path is not None]
    outputs.require(inputs)
    from geotlm_lm.recordings.legible import require_any_legible
    from geotlm_lm.recordings.read import frames_inside

    span, scale = recording.span, answering.frame.mm_per_px
    clip = recording.read()
    require_any_legible(clip if span is None else frames_inside(clip, span))

    from geotlm_lm.track.export import Exported

    answerer = answering.load()
    # As it was read with: what does not fit into memory is decoded anew, frame by frame.
    again = {"square_pixels": bool(recording.square_pixels), "topic": recording.topic}
    tracked, is_stopped = _tracked(answerer, clip, span, again)
    exported, in_frames = Exported(tracked, scale), not clip.is_timed
    write_table_and_plot(outputs, exported, clip.name, clip.fps, in_frames=in_frames)
    if outputs.video is not None:
        _write_film(outputs.video, exported, clip, again)
    print_notes(*clip.notes, *tracked.notes)
    if as_json:
        print(json.dumps(exported.to_dict()))
    elif not tracked.events:
        print(NO_EVENTS if tracked.is_contact_known else NO_MOTION)
    else:
        lines = [event_line(event, exported.units, in_frames=in_frames) for event in tracked.events]
        sums = totals_lines(exported, in_frames=in_frames)
        print("\n".join([aligned(HEAD), *lines, "", *sums]))
    if outputs.rerun is not None:
        from geotlm_lm.track.rerun_log import write_or_serve

        write_or_serve(outputs.rerun, lambda path: _log(path, exported, clip, again))
    if is_stopped:
        print_notes(f"Tracked as far as frame {tracked.numbers[-1]}.")
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
    whole = answerer.seen_closely(clip, tracker.finish())
    if span is None:
        return whole, is_stopped
    return whole.between(span[0], min(span[1], int(whole.numbers[-1]))), is_stopped


def write_table_and_plot(
    outputs: TrackOutputs, exported: Exported, name: str, fps: float | None, *, in_frames: bool
) -> None:
    """Write the table and the plot of the track of a recording, where they are asked for."""
    if outputs.out is not None:
        made_by = {"command": command_line(), "recording": name, "fps": fps}
        exported.save(outputs.out, made_by)
    if outputs.plot is not None:
        from geotlm_lm.track.plot import write_plot

        write_plot(outputs.plot, exported, in_frames=in_frames, title=Path(name).name)


def _write_film(path: Path, exported: Exported, clip: Clip, reading: dict[str, Any]) -> None:
    from geotlm_lm.recordings.read import each_frame
    from geotlm_lm.track.drawing import write_film
    from geotlm_lm.track.tracker import ASSUMED_FPS

    first, second = exported.track.numbers[:2]
    rate = (clip.fps or ASSUMED_FPS) / int(second - first)
    write_film(path, exported, each_frame(clip, **reading), rate)


def _log(path: Path, exported: Exported, clip: Clip, reading: dict[str, Any]) -> None:
    from geotlm_lm.track.rerun_log import log_track, rerun_recording

    with rerun_recording(path) as stream:
        log_track(stream, exported, clip, **reading)


def event_line(event: Event, units: Units, *, in_frames: bool = False) -> str:
    """Return an event as a line of a table whose first is `aligned(HEAD)`."""
    from geotlm_lm.track.drawing import band_of

    ends = (event.begin, event.end) if in_frames else (event.begin_s, event.end_s)
    begin, end = (f"{number}" if in_frames else f"{number:.2f} s" for number in ends)
    band, far, likely = band_of(event, units), "" if event.is_readable else "not seen", ""
    if band.unit:
        far = f"{figure_of(band.amount)} {band.unit}"
        likely = f"{figure_of(band.low)} to {figure_of(band.high)}"
    return aligned((begin, end, band.name, far, likely, f"{event.probability:.2f}"))


def aligned(cells: tuple[str, ...]) -> str:
    """Return one line of the table; its columns are as wide wherever it is printed."""
    begin, end, *others = cells
    columns = (f"{begin:>9}", f"{end:>9}", *map(str.ljust, others, WIDTHS))
    return "  ".join(columns).rstrip()


def _touched_phrase(track: Track, touched_s: float | None, *, in_frames: bool) -> str:
    if touched_s is None:
        return "whether it is touched is not known"
    if not in_frames:
        return f"touched for {touched_s:.2f} s"
    ends = (track.numbers[track.times_s.searchsorted(each)] for each in track.contacts())
    frames = sum(int(last - first) for first, last in ends)
    return f"touched for {frames} frame{'s' * (frames != 1)}"


def totals_lines(exported: Exported, *, in_frames: bool = False) -> list[str]:
    """Return what a whole track comes to, in two sentences."""
    totals, unit = exported.totals(), exported.units.name
    turn, way = totals["turn_net"], totals["turn_in_all"]
    slide, far = totals["slide_net"], totals["slide_in_all"]
    touched = _touched_phrase(exported.track, totals["touched_s"], in_frames=in_frames)
    turned, slid = UNREADABLE.format("Turned"), UNREADABLE.format("Slid")
    if turn["amount"] is not None:
        sense = "clockwise" if turn["amount"] >= 0 else "counterclockwise"
        turned = (
            f"Turned by {figure_of(abs(turn['amount']))} degrees {sense} from first to last, "
            f"{figure_of(way['amount'])} there and back"
        )
    if slide["amount"] is not None:
        slid = (
            f"Slid by {figure_of(slide['amount'])} {unit} from first to last, "
            f"{figure_of(far['amount'])} there and back"
        )
    limits = [totals["turn_limit"], totals["slide_limit"]]
    turn_beyond, slide_beyond = (
        "" if x is None else f" by more than {figure_of(x)}" for x in limits
    )
    if way["amount"] == 0:
        turned = f"Does not turn{turn_beyond}{' degrees' * bool(turn_beyond)}"
    if far["amount"] == 0:
        slid = f"Does not slide{slide_beyond}{f' {unit}' * bool(slide_beyond)}"
    return [f"{turned}.", f"{slid}; {touched}."]
