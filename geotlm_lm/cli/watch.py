"""`geotlm-lm watch`: what happens at a sensor, or in a recording played, as it happens."""

from __future__ import annotations

import sys
from typing import Annotated, Any

import typer

from geotlm_lm.cli.grouped import Answering, grouped
from geotlm_lm.cli.options import (
    Force,
    FramesPerSecond,
    LayoutName,
    SquarePixels,
    TopicName,
    path_of,
)
from geotlm_lm.cli.tracked import INTERRUPTED, OutFile, PlotFile, Targets, VideoFile
from geotlm_lm.core.errors import GeoTLMError, UsageError, check_question


@grouped
def watch(
    *,
    source: Annotated[
        str, typer.Option(help="A camera's number, its device file, or a recording.")
    ],
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON object a line, the account last.")
    ] = False,
    out: OutFile = None,
    plot: PlotFile = None,
    video: VideoFile = None,
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
    topic: TopicName = None,
    fps: FramesPerSecond = None,
    stalled_after: Annotated[
        float,
        typer.Option(
            help="Seconds without a frame of a camera after which it ends, with exit code 8."
        ),
    ] = 10.0,
    answering: Answering,
) -> None:
    """Print what touches when and how it moves, until the recording ends or Ctrl-C.

    A camera that gives no frames any more is told after 2 seconds, and ends it after 10.

    The gel must be untouched at the start, or for half a second later on. Directions are told as
    seen in the camera image, for the object relative to the sensor.

    Example: geotlm-lm watch --source recording.avi --json
    """
    if question is not None:
        check_question(question)
    targets = Targets(out, plot, video)
    targets.require([path_of(source)], is_forced=force)
    if not stalled_after > 0:
        raise UsageError(
            f"--stalled-after {stalled_after:g} was given, expected more than 0 seconds; leave it "
            f"out for 10, or give inf to wait without end."
        )
    from geotlm_lm.recordings.streams import Patience, open_source

    def silent(seconds: float) -> None:
        print(f"note: No frame of {source} for {seconds:g} s.", file=sys.stderr, flush=True)

    scale = answering.frame.mm_per_px
    reading = {"fps": fps, "layout": layout, "square_pixels": square_pixels, "topic": topic}
    patience = Patience(stalled_after, silent)
    stream = open_source(source, at_its_rate=at_its_rate, patience=patience, **reading)

    # Imported only now: a camera that does not open must not wait for the model's libraries.
    from geotlm_lm.cli.watching import Watching
    from geotlm_lm.track.export import Exported

    answerer = answering.load()
    _tell_source(source, stream)
    watching = Watching(answerer, stream, question, scale, as_json=as_json)
    ended = watching.follow(video, is_square=bool(square_pixels))
    exported = Exported(watching.tracker.finish(), scale)
    watching.conclude(exported)
    if len(exported.track):
        targets.write(exported, stream.name, stream.fps, in_frames=False)
    if isinstance(ended, GeoTLMError):
        raise ended
    if ended is not None:
        raise typer.Exit(INTERRUPTED)


def _tell_source(source: str, stream: Any) -> None:
    assumed = ", as is assumed; give the rate by --fps" if stream.is_rate_assumed else ""
    rate = f"{source} at {stream.fps:g} frames per second{assumed}."
    for note in (rate, *stream.notes):
        print(f"note: {note}", file=sys.stderr)
