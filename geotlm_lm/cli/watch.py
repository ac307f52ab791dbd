"""`geotlm-lm watch`: motion events of a camera or a recording, one line each."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geotlm_lm.cli.options import (
    BundleFolder,
    Force,
    FramesPerSecond,
    LayoutName,
    Precision,
    SquarePixels,
    path_of,
    path_option,
    require_new_file,
    require_question,
)
from geotlm_lm.core.errors import UnreadableClip, UsageError

if TYPE_CHECKING:
    from geotlm_lm.live.events import MotionEvent
    from geotlm_lm.live.film import Film


def watch(
    source: Annotated[
        str, typer.Option(help="A camera's number, its device file, or a recording.")
    ],
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON object a line, the account last.")
    ] = False,
    draw: Annotated[
        Path | None, path_option(help="Write what was seen to this .mp4, as a drawing.")
    ] = None,
    force: Force = False,
    question: Annotated[
        str | None,
        typer.Option("--q", help="Ask the language model this about every motion that ends."),
    ] = None,
    at_its_rate: Annotated[
        bool,
        typer.Option("--at-its-rate", help="Play a recording as a camera would, dropping frames."),
    ] = False,
    layout: LayoutName = None,
    square_pixels: SquarePixels = None,
    fps: FramesPerSecond = None,
    model: BundleFolder = None,
    precision: Precision = "float32",
) -> None:
    """Print what moves how, as it begins and ends, until the recording ends or Ctrl-C.

    The gel must be untouched at the start, or for half a second later on. Directions are told as
    seen in the camera image, for the object relative to the sensor.

    Example: geotlm-lm watch --source recording.avi --json
    """
    if question is not None:
        require_question(question)
    _require_paths(source, draw, is_forced=force)
    from geotlm_lm.live.sources import open_source

    stream = open_source(
        source, at_its_rate=at_its_rate, fps=fps, layout=layout, square_pixels=square_pixels
    )

    # Imported only now: a camera that does not open must not wait for the model's libraries.
    from geotlm_lm.answering import Answerer
    from geotlm_lm.live.watcher import Watcher, model_reader

    answerer = Answerer.load(model, precision=precision)
    watcher = Watcher(model_reader(answerer))
    film = None if draw is None else _film(draw, stream.fps)
    _tell_source(source, stream)
    try:
        # Closed even where nobody reads on: a camera's thread must not outlive the command.
        with closing(_events(stream, watcher, film, square_pixels)) as events:
            for event in events:
                _tell(event, as_json, _words(answerer, watcher, event, question))
    finally:
        if film is not None:
            film.close()
        if watcher.warning is not None:
            print(f"note: {watcher.warning}", file=sys.stderr)
        _account(watcher.account.to_dict() | {"dropped": stream.dropped}, as_json)


def _require_paths(source: str, drawing: Path | None, *, is_forced: bool) -> None:
    read = path_of(source)
    if drawing is None:
        if is_forced:
            raise UsageError("--force lets --draw replace a file; give --draw, or leave it out.")
        return
    if drawing.suffix != ".mp4":
        raise UsageError(f"--draw {drawing} was given, expected a name that ends in .mp4.")
    require_new_file(drawing, "--draw", is_forced=is_forced, inputs=[read])


def _tell_source(source: str, stream: Any) -> None:
    assumed = ", as is assumed; give the rate by --fps" if stream.is_rate_assumed else ""
    rate = f"{source} at {stream.fps:g} frames per second{assumed}."
    for note in (rate, *stream.notes):
        print(f"note: {note}", file=sys.stderr)


def _film(path: Path, fps: float) -> Film:
    from geotlm_lm.live.film import Film

    return Film(path, fps)


def _events(
    stream: Any, watcher: Any, film: Any, square_pixels: bool | None
) -> Iterator[MotionEvent]:
    """Yield the events of a stream as they come, and draw each frame if there is a film."""
    from geotlm_lm.recordings.pixel_shape import with_square_pixels

    for frame in stream:
        image = with_square_pixels(frame.image) if square_pixels else frame.image
        events = watcher.push(image, frame.time_s)
        if film is not None:
            film.add(image, events, watcher.perceived)
        yield from events
    yield from watcher.finish()


def _words(answerer: Any, watcher: Any, event: MotionEvent, question: str | None) -> str | None:
    if question is None or event.phase == "start":
        return None
    clip = watcher.clip_of(event)
    if clip is None:
        return None
    try:
        answer = answerer.ask(answerer.encode(clip), question)
    except UnreadableClip as error:
        return f"I cannot read this motion's frames: {error}"
    return answer.text


def _tell(event: MotionEvent, as_json: bool, words: str | None) -> None:
    if as_json:
        told = event.to_dict() | ({} if words is None else {"answer": words})
        print(json.dumps(told), flush=True)
    else:
        print(event.sentence() + (f".  {words}" if words else ""), flush=True)


def _account(facts: dict[str, Any], as_json: bool) -> None:
    if as_json:
        print(json.dumps({"type": "account"} | facts), flush=True)
        return
    dropped = f"{facts['dropped']} dropped" if facts["dropped"] else "none dropped"
    print(
        f"note: {facts['frames']} frames, {dropped}; {facts['windows']} windows perceived in "
        f"{facts['window_ms_median']:.1f} ms each (median), each frame followed in "
        f"{facts['frame_ms_median']:.2f} ms.",
        file=sys.stderr,
    )
