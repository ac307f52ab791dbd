"""A track, and what was asked about it, as a Rerun recording: frames, arrows, curves, events."""

from __future__ import annotations

import math
import os
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.files import replacing
from geotlm_lm.core.geometry import filled_size
from geotlm_lm.recordings.read import each_frame
from geotlm_lm.track.amounts import SPAN_DEVIATIONS, Floats
from geotlm_lm.track.events import Event
from geotlm_lm.track.export import Exported, Units, event_name, require_packages
from geotlm_lm.track.tracker import ASSUMED_FPS

APPLICATION = "geotlm_lm"

JPEG_QUALITY = 95
"""Of the frames: a recording of a minute then takes 20 MB instead of 300."""

DESCRIPTORS = Path("/dev/fd")
"""Where a pipe has a name; on Windows, which has none, a recording is kept in memory."""

PIPE_BYTES = 2**20

HAND_SHARE = 0.2
"""Length of the hand that shows the turn, of the image's height."""

COLOURS = {"travel": (255, 140, 0), "turn": (70, 150, 255)}


@contextmanager
def rerun_recording(path: Path) -> Iterator[Any]:
    """Yield a stream of Rerun's, which takes the place of `path` once the block ends without error.

    Args:
        path: Of the .rrd file; its folder is made if missing.

    Raises:
        MissingDependency: If Rerun is not installed.
        Unwritten: If the file cannot be written.
    """
    require_packages(path)
    import rerun

    stream = rerun.RecordingStream(APPLICATION)
    with replacing(path) as file:
        if not DESCRIPTORS.is_dir():
            memory = stream.memory_recording()
            stream.send_blueprint(_views())
            yield stream
            file.write(memory.drain_as_bytes())
            return
        with _drained_into(file) as name:
            stream.save(name, default_blueprint=_views())
            try:
                yield stream
            finally:
                stream.disconnect()


@contextmanager
def _drained_into(file: IO[bytes]) -> Iterator[str]:
    """Yield the name of a pipe whose content goes into a file; it takes all, whatever that takes.

    Rerun's own thread, once its file cannot be written, has whoever flushes it wait for ever.
    """
    reads, writes = os.pipe()
    failures: list[OSError] = []

    def drain() -> None:
        while content := os.read(reads, PIPE_BYTES):
            if failures:
                continue
            try:
                file.write(content)
            except OSError as error:
                failures.append(error)

    draining = threading.Thread(target=drain, daemon=True)
    draining.start()
    try:
        yield str(DESCRIPTORS / str(writes))
    finally:
        os.close(writes)  # Rerun has opened its own end, and closed it
        draining.join()
        os.close(reads)
    if failures:
        raise failures[0]


def log_clip(stream: Any, clip: Clip) -> None:
    """Log frames that were not tracked, each at its time."""
    for number, frame in zip(clip.frame_numbers, clip.frames, strict=True):
        _at(stream, number, clip.second_of(number, ASSUMED_FPS))
        _log_frame(stream, frame)


def log_track(stream: Any, exported: Exported, clip: Clip, **reading: Any) -> None:
    """Log the frames of a track with an arrow and a hand, its curves with spans, and its events.

    Args:
        stream: Of `rerun_recording`.
        exported: The track in its units.
        clip: The recording it is of.
        reading: Options of `each_frame`: as it was read with.
    """
    track = exported.track
    places = {int(number): place for place, number in enumerate(track.numbers)}
    for number, frame in each_frame(clip, **reading):
        if number in places:
            place = places[number]
            _at(stream, number, float(track.times_s[place]))
            _log_frame(stream, frame)
            _log_arrows(stream, frame, exported.path[place], exported.units)
        if number >= max(places, default=-1):
            break
    _log_curves(stream, exported)
    for event in track.events:
        _log_event(stream, event, exported.units)


def log_answer(stream: Any, question: str, answer: str, notes: Iterable[str] = ()) -> None:
    """Log what was asked and answered as one document."""
    import rerun

    told = [f"**{question}**", answer, *(f"*{note}*" for note in notes)]
    text = "\n\n".join(told)
    document = rerun.TextDocument(text, media_type=rerun.MediaType.MARKDOWN)
    stream.log("answer", document, static=True)


def _views() -> Any:
    from rerun import blueprint

    curves = [
        blueprint.TimeSeriesView(origin=name, name=name)
        for name in ("turn", "travel", "depth", "contact")
    ]
    told = blueprint.Horizontal(
        blueprint.TextDocumentView(origin="answer", name="answer"),
        blueprint.TextLogView(origin="events", name="events"),
    )
    left = blueprint.Vertical(blueprint.Spatial2DView(origin="camera", name="camera"), told)
    return blueprint.Blueprint(blueprint.Horizontal(left, blueprint.Vertical(*curves)))


def _at(stream: Any, number: int, time_s: float) -> None:
    stream.set_time("frame", sequence=number)
    stream.set_time("time", duration=time_s)


def _log_frame(stream: Any, frame: Frames) -> None:
    import rerun

    image = rerun.Image(np.ascontiguousarray(frame)).compress(jpeg_quality=JPEG_QUALITY)
    stream.log("camera/image", image)


def _log_arrows(stream: Any, frame: Frames, way: Floats, units: Units) -> None:
    """Log how far it travelled since the first frame, in pixels of the frame, and its turn."""
    import rerun

    rows, columns = frame.shape[:2]
    filled = filled_size(*units.frame_size)
    middle = (columns / 2, rows / 2)
    hand = HAND_SHARE * rows
    angle = math.radians(way[0])
    vectors = {
        "travel": (way[1] * columns / filled[1], way[2] * rows / filled[0]),
        "turn": (hand * math.sin(angle), -hand * math.cos(angle)),
    }
    for name, vector in vectors.items():
        arrow = rerun.Arrows2D(origins=[middle], vectors=[vector], colors=[COLOURS[name]])
        stream.log(f"camera/{name}", arrow)


def _log_curves(stream: Any, exported: Exported) -> None:
    """Log each curve with the ends of the span that holds nine tenths."""
    import rerun

    track, units = exported.track, exported.units
    path, spread = exported.path, SPAN_DEVIATIONS * track.path_deviations
    travelled = [units.travelled(one[:, 1], one[:, 2]) for one in (path, spread)]
    curves = {
        "turn/deg": (path[:, 0], spread[:, 0]),
        f"travel/right_{units.name}": (travelled[0][0], travelled[1][0]),
        f"travel/down_{units.name}": (travelled[0][1], travelled[1][1]),
        "depth/mm": (path[:, 3], spread[:, 3]),
    }
    times = [
        rerun.TimeColumn("frame", sequence=track.numbers),
        rerun.TimeColumn("time", duration=track.times_s),
    ]
    for name, (mean, off) in curves.items():
        lines = rerun.SeriesLines(names=["likely", "low", "high"], widths=[2, 1, 1])
        stream.log(name, lines, static=True)
        values = np.stack([mean, mean - off, mean + off], axis=1)
        stream.send_columns(name, times, rerun.Scalars.columns(scalars=values))
    stream.send_columns("contact", times, rerun.Scalars.columns(scalars=track.contact))


def _log_event(stream: Any, event: Event, units: Units) -> None:
    import rerun

    _at(stream, event.begin, event.begin_s)
    found = units.amount(event)
    far = ""
    if found is not None:
        span, unit = found
        low, high = sorted((abs(span.low), abs(span.high)))
        low = 0.0 if span.low < 0 < span.high else low
        far = f" {abs(span.mean):.3g} {unit} ({low:.3g} to {high:.3g})"
    text = f"{event_name(event)}{far}, until {event.end_s:.2f} s, sure {event.probability:.2f}"
    stream.log("events", rerun.TextLog(text, level=rerun.TextLogLevel.INFO))
