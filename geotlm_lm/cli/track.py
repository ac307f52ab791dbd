"""`geotlm-lm track`: what happens in a whole recording, as a table, files, a plot, a video."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geotlm_lm.cli.options import (
    Background,
    BundleFolder,
    Force,
    FrameSpan,
    FramesPerSecond,
    LayoutName,
    MmPerPixel,
    Precision,
    SquarePixels,
    path_of,
    path_option,
    require_new_file,
    span_of,
)
from geotlm_lm.cli.progress import progress_on_stderr
from geotlm_lm.cli.recorded import command_line
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.interrupts import uninterrupted_step

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer
    from geotlm_lm.core.clip import Clip
    from geotlm_lm.track.export import Exported
    from geotlm_lm.track.track import Track

INTERRUPTED = 130
"""Exit code of a command stopped by Ctrl-C; what was tracked by then is written."""

ENDINGS = {"--out": (".csv", ".parquet", ".json"), "--plot": (".png",), "--video": (".mp4",)}


def track(
    recording: Annotated[
        Path,
        typer.Argument(parser=path_of, metavar="RECORDING", help="As for `geotlm-lm answer`."),
    ],
    as_json: Annotated[
        bool, typer.Option("--json", help="Print events and totals as one JSON object.")
    ] = False,
    out: Annotated[
        Path | None,
        path_option(help="Write a row for every frame to this .csv, .parquet or .json file."),
    ] = None,
    plot: Annotated[
        Path | None, path_option(help="Draw turn, travel and contact over time to this .png.")
    ] = None,
    video: Annotated[
        Path | None, path_option(help="Write the frames, with what was tracked, to this .mp4.")
    ] = None,
    force: Force = False,
    frames: FrameSpan = None,
    layout: LayoutName = None,
    background: Background = None,
    fps: FramesPerSecond = None,
    square_pixels: SquarePixels = None,
    mm_per_px: MmPerPixel = None,
    model: BundleFolder = None,
    precision: Precision = "float32",
) -> None:
    """Track a whole recording: what touches when, how it moves, how far.

    Directions are told as seen in the camera image, for the object relative to the sensor. Ctrl-C
    ends the recording there.

    Example: geotlm-lm track recording.mov --out track.csv --plot track.png
    """
    targets = {"--out": out, "--plot": plot, "--video": video}
    inputs = [one for one in (recording, background) if one is not None]
    _require_targets(targets, inputs, is_forced=force)
    from geotlm_lm.core.frame_spec import FrameSpec
    from geotlm_lm.recordings.read import read_clip
    from geotlm_lm.recordings.span import frames_inside

    span, scale = span_of(frames), FrameSpec(mm_per_px=mm_per_px).mm_per_px
    clip = read_clip(
        recording, layout=layout, fps=fps, background=background, square_pixels=square_pixels
    )
    if span is not None:
        frames_inside(clip, span)

    # Imported only now: a wrong path must not wait for the model's libraries.
    from geotlm_lm.answering import Answerer
    from geotlm_lm.track.export import Exported

    answerer = Answerer.load(model, precision=precision)
    tracked, is_stopped = _tracked(answerer, clip, span, is_square=bool(square_pixels))
    exported = Exported(tracked, scale)
    made_by = {"command": command_line(), "recording": clip.name, "fps": clip.fps}
    _write(exported, clip, targets, made_by, is_square=bool(square_pixels))
    for note in (*clip.notes, *tracked.notes):
        print(f"note: {note}", file=sys.stderr)
    if as_json:
        print(json.dumps(exported.to_dict()))
    else:
        print("\n".join(table(exported, in_frames=clip.fps is None)))
    if is_stopped:
        print(f"note: Tracked as far as frame {tracked.numbers[-1]}.", file=sys.stderr)
        raise typer.Exit(INTERRUPTED)


def _require_targets(
    targets: dict[str, Path | None], inputs: Sequence[Path], *, is_forced: bool
) -> None:
    """Refuse files that cannot be written, before anything is tracked for them.

    Raises:
        UsageError: If a name ends otherwise than it must, or is there already or given twice.
        MissingDependency: If a package that writes one is not installed.
    """
    given = {option: path for option, path in targets.items() if path is not None}
    if is_forced and not given:
        raise UsageError(
            "--force lets --out, --plot and --video replace files; give one of them, or leave it "
            "out."
        )
    from geotlm_lm.track.export import require_packages

    for option, path in given.items():
        endings = ENDINGS[option]
        if path.suffix not in endings:
            raise UsageError(
                f"{option} {path} was given, expected a name that ends in {' or '.join(endings)}."
            )
        require_packages(path)
        require_new_file(path, option, is_forced=is_forced, inputs=inputs)


def _tracked(
    answerer: Answerer, clip: Clip, span: tuple[int, int] | None, *, is_square: bool
) -> tuple[Track, bool]:
    """Return the track of a recording, or of a span, and whether Ctrl-C ended it early.

    Raises:
        KeyboardInterrupt: If no two frames were tracked by then.
    """
    from geotlm_lm.recordings.video import each_frame
    from geotlm_lm.track.tracker import ASSUMED_FPS

    tracker, show, is_stopped = answerer.tracker(clip), progress_on_stderr("frames"), False
    rate, last = clip.fps or ASSUMED_FPS, span[1] if span else clip.frame_numbers[-1]
    total, done = last + 1, 0
    try:
        for number, frame in each_frame(clip, square_pixels=is_square):
            if span is not None and number > last:
                break
            with uninterrupted_step():
                tracker.feed(frame, number / rate, number)
                done = number + 1
            if done < total:
                show("tracking", done, total)
    except KeyboardInterrupt:
        is_stopped = True
        if done < 2 or (span is not None and done <= span[0] + 1):
            raise
    show("tracking", done, done if is_stopped else total)
    found = tracker.finish()
    return found if span is None else found.between(*span), is_stopped


def _write(
    exported: Exported,
    clip: Clip,
    targets: dict[str, Path | None],
    made_by: dict[str, Any],
    *,
    is_square: bool,
) -> None:
    if targets["--out"] is not None:
        exported.save(targets["--out"], made_by)
    if targets["--plot"] is not None:
        from geotlm_lm.track.plot import write_plot

        write_plot(targets["--plot"], exported, in_frames=clip.fps is None)
    if targets["--video"] is not None:
        from geotlm_lm.recordings.video import each_frame
        from geotlm_lm.track.film import write_film
        from geotlm_lm.track.tracker import ASSUMED_FPS

        shown = each_frame(clip, square_pixels=is_square)
        first, second = exported.track.numbers[:2]
        rate = (clip.fps or ASSUMED_FPS) / int(second - first)
        write_film(targets["--video"], exported, shown, rate)


def table(exported: Exported, *, in_frames: bool) -> list[str]:
    """Return the events of a track as lines of a table, and what they come to.

    Args:
        exported: The track.
        in_frames: Whether to tell frame numbers instead of seconds.
    """
    from geotlm_lm.track.export import event_name

    events = exported.track.events
    if not events:
        return ["Nothing touches in the recording."]
    rows = [("begin", "end", "what", "how far", "likely", "sure")]
    for event in events:
        ends = (event.begin, event.end) if in_frames else (event.begin_s, event.end_s)
        begin, end = (f"{one}" if in_frames else f"{one:.2f} s" for one in ends)
        far, likely = _told(exported.amount(event))
        rows.append((begin, end, event_name(event), far, likely, f"{event.probability:.2f}"))
    return [*_aligned(rows), "", *_totals(exported)]


def _told(amount: tuple[Any, str] | None) -> tuple[str, str]:
    if amount is None:
        return "", ""
    span, unit = amount
    decimals = 1 if unit == "px" else 2 if unit == "mm" else 0
    low, high = sorted((abs(span.low), abs(span.high)))
    low = 0.0 if span.low < 0 < span.high else low
    far = f"{abs(span.mean):.{decimals}f} {unit}"
    return far, f"{low:.{decimals}f} to {high:.{decimals}f}"


def _aligned(rows: Iterable[tuple[str, ...]]) -> list[str]:
    rows = list(rows)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]


def _totals(exported: Exported) -> list[str]:
    totals, unit = exported.totals(), exported.unit
    turn, way = totals["turn_net"], totals["turn_in_all"]
    slide, far = totals["slide_net"], totals["slide_in_all"]
    sense = "clockwise" if turn["amount"] >= 0 else "counterclockwise"
    return [
        f"Turned by {abs(turn['amount']):.0f} degrees {sense} from first to last, "
        f"{way['amount']:.0f} there and back.",
        f"Slid by {slide['amount']:.3g} {unit} from first to last, {far['amount']:.3g} there and "
        f"back; touched for {totals['touched_s']:.2f} s.",
    ]
