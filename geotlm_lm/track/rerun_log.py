"""A track, and a question about it, as a Rerun recording: frames, arrows, curves, events."""

from __future__ import annotations

import math
import socket
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import quote

import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.files import replacing
from geotlm_lm.recordings.read import each_frame
from geotlm_lm.track.drawing import Band, Drawing, Mark, drawing_of
from geotlm_lm.track.export import SERVE, Exported, require_packages
from geotlm_lm.track.tracker import ASSUMED_FPS

APPLICATION, HOST = "geotlm_lm", "127.0.0.1"

JPEG_QUALITY = 95
"""Of the frames: a recording of a minute then takes 20 MB instead of 300."""

HAND_SHARE = 0.2
"""Length of the hand that shows the turn, of the image's height."""

COLOURS = {"travel": (255, 140, 0), "turn": (70, 150, 255)}


@contextmanager
def rerun_recording(path: Path) -> Iterator[Any]:
    """Yield a stream of Rerun's, which takes the place of `path` once the block ends without error.

    Raises:
        MissingDependency: If Rerun is not installed.
        Unwritten: If the file cannot be written.
    """
    require_packages(path)
    import rerun

    stream = rerun.RecordingStream(APPLICATION)
    with replacing(path) as file:
        # Rerun's own file sink waits for ever on a full disk.
        memory = stream.memory_recording()
        stream.send_blueprint(_views())
        yield stream
        file.write(memory.drain_as_bytes())


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
    drawing = drawing_of(exported.track, exported.units)
    places = {int(number): place for place, number in enumerate(drawing.numbers)}
    for number, frame in each_frame(clip, **reading):
        if number in places:
            place = places[number]
            _at(stream, number, float(drawing.times_s[place]))
            _log_frame(stream, frame)
            _log_mark(stream, frame, drawing.mark(place))
        if number >= max(places, default=-1):
            break
    _log_curves(stream, drawing)
    for band in drawing.bands:
        _log_band(stream, band)


def log_answer(stream: Any, question: str, answer: str, notes: Iterable[str] = ()) -> None:
    """Log what was asked and answered as one document."""
    import rerun

    text = "\n\n".join([f"**{question}**", answer, *(f"*{note}*" for note in notes)])
    document = rerun.TextDocument(text, media_type=rerun.MediaType.MARKDOWN)
    stream.log("answer", document, static=True)


def _views() -> Any:
    from rerun import blueprint

    curves = [
        blueprint.TimeSeriesView(origin=name, name=name)
        for name in ("turn", "travel", "depth", "contact")
    ]
    texts = blueprint.Horizontal(
        blueprint.TextDocumentView(origin="answer", name="answer"),
        blueprint.TextLogView(origin="events", name="events"),
    )
    left = blueprint.Vertical(blueprint.Spatial2DView(origin="camera", name="camera"), texts)
    return blueprint.Blueprint(blueprint.Horizontal(left, blueprint.Vertical(*curves)))


def _at(stream: Any, number: int, time_s: float) -> None:
    stream.set_time("frame", sequence=number)
    stream.set_time("time", duration=time_s)


def _log_frame(stream: Any, frame: Frames) -> None:
    import rerun

    image = rerun.Image(np.ascontiguousarray(frame)).compress(jpeg_quality=JPEG_QUALITY)
    stream.log("camera/image", image)


def _log_mark(stream: Any, frame: Frames, mark: Mark) -> None:
    """Log the travel and the turn since the first frame as vectors in pixels of the frame."""
    import rerun

    rows, columns = frame.shape[:2]
    hand, angle = HAND_SHARE * rows, math.radians(mark.hand_deg)
    vectors = {
        "travel": mark.arrow * (columns, rows),
        "turn": (hand * math.sin(angle), -hand * math.cos(angle)),
    }
    for name, vector in vectors.items():
        middle, colour = (columns / 2, rows / 2), COLOURS[name]
        arrow = rerun.Arrows2D(origins=[middle], vectors=[vector], colors=[colour])
        stream.log(f"camera/{name}", arrow)


def _log_curves(stream: Any, drawing: Drawing) -> None:
    """Log each curve with the ends of the span that holds nine tenths."""
    import rerun

    times = [
        rerun.TimeColumn("frame", sequence=drawing.numbers),
        rerun.TimeColumn("time", duration=drawing.times_s),
    ]
    for curve in drawing.curves:
        if curve.spread is None:
            values = rerun.Scalars.columns(scalars=curve.mean)
            stream.send_columns(curve.panel, times, values)
            continue
        part = "" if curve.name == curve.panel else f"{curve.name}_"
        entity = f"{curve.panel}/{part}{curve.unit}"
        lines = rerun.SeriesLines(names=["likely", "low", "high"], widths=[2, 1, 1])
        stream.log(entity, lines, static=True)
        ends = (curve.mean, curve.mean - curve.spread, curve.mean + curve.spread)
        stream.send_columns(entity, times, rerun.Scalars.columns(scalars=np.stack(ends, axis=1)))


def _log_band(stream: Any, band: Band) -> None:
    import rerun

    event, far = band.event, ""
    _at(stream, event.begin, event.begin_s)
    if band.unit:
        far = f" {band.amount:.3g} {band.unit} ({band.low:.3g} to {band.high:.3g})"
    text = f"{band.name}{far}, until {event.end_s:.2f} s, sure {event.probability:.2f}"
    stream.log("events", rerun.TextLog(text, level=rerun.TextLogLevel.INFO))


def write_or_serve(target: Path, write: Callable[[Path], None]) -> None:
    """Write a Rerun recording to a file; of `SERVE` show it in a browser until Ctrl-C."""
    if target != SERVE:
        write(target)
        return
    with TemporaryDirectory() as folder:
        path = Path(folder) / "seen.rrd"
        write(path)
        sys.stdout.flush()  # what was answered is read while the viewer runs
        with suppress(KeyboardInterrupt), viewer(path) as (address, running):
            print(f"Rerun's viewer is at {address} until Ctrl-C.", file=sys.stderr)
            running.wait()


@contextmanager
def viewer(path: Path) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """Yield the address of a viewer of an .rrd file, for this machine alone, and its process."""
    data_port, page_port = _free_ports()
    command = [str(_program()), str(path), "--serve-web", "--bind", HOST]
    command += ["--port", str(data_port), "--web-viewer-port", str(page_port)]
    running = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        source = quote(f"rerun+http://{HOST}:{data_port}/proxy", safe="")
        yield f"http://{HOST}:{page_port}/?url={source}", running
    finally:
        running.terminate()
        running.wait()


def _program() -> Path:
    """Return the viewer's own program: the wrapper that Python runs would leave it behind."""
    folder = Path(find_spec("rerun_cli").origin).parent
    names = ("Rerun.app/Contents/MacOS/Rerun", "rerun.exe", "rerun")  # macOS, Windows, others
    return next(folder / name for name in names if (folder / name).is_file())


def _free_ports() -> list[int]:
    with socket.socket() as first, socket.socket() as second:
        for free in (first, second):
            free.bind((HOST, 0))
        return [free.getsockname()[1] for free in (first, second)]
