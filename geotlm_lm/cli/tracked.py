"""What `track` and `watch` share: the files they write and the lines they print."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from geotlm_lm.cli.options import path_option, require_new_file
from geotlm_lm.cli.recorded import command_line
from geotlm_lm.cli.viewer import SERVE
from geotlm_lm.core.errors import UsageError

if TYPE_CHECKING:
    from geotlm_lm.track.events import Event
    from geotlm_lm.track.export import Exported, Units

INTERRUPTED = 130
"""Exit code of a command stopped by Ctrl-C; what was tracked by then is written."""

OutFile = Annotated[
    Path | None,
    path_option(help="Write a row for every frame to this .csv, .parquet or .json file."),
]
PlotFile = Annotated[
    Path | None, path_option(help="Draw turn, travel and contact over time to this .png.")
]
VideoFile = Annotated[
    Path | None, path_option(help="Write the frames, with what was tracked, to this .mp4.")
]

RerunFile = Annotated[
    Path | None,
    path_option(
        help="Write frames, arrows, curves and events for the Rerun viewer to this .rrd; `serve` "
        "shows them in a browser instead."
    ),
]

ENDINGS = {
    "--out": (".csv", ".parquet", ".json"),
    "--plot": (".png",),
    "--video": (".mp4",),
    "--rerun": (".rrd",),
}

NO_EVENTS = "Nothing touches in the recording."

HEAD = ("begin", "end", "what", "how far", "likely", "sure")


@dataclass(frozen=True)
class Targets:
    """The files that are asked for.

    Args:
        out: Table of the frames.
        plot: Picture of them over time.
        video: The frames, drawn.
        rerun: All of it for a viewer.
    """

    out: Path | None
    plot: Path | None
    video: Path | None
    rerun: Path | None = None

    def require(self, inputs: Sequence[Path], *, is_forced: bool) -> None:
        """Refuse files that cannot be written, before anything is tracked for them.

        Raises:
            UsageError: If a name ends otherwise than it must, or is there already.
            MissingDependency: If a package that writes one is not installed.
        """
        paths = (self.out, self.plot, self.video, self.rerun)
        options = zip(ENDINGS, paths, strict=True)
        given = {option: path for option, path in options if path is not None}
        if is_forced and not given:
            raise UsageError(
                "--force lets --out and other options replace files; give one of them, or leave it "
                "out."
            )
        if not given:
            return
        from geotlm_lm.track.export import require_packages

        for option, path in given.items():
            if option == "--rerun" and path == SERVE:
                require_packages(path.with_suffix(".rrd"))
                continue
            endings = ENDINGS[option]
            if path.suffix not in endings:
                raise UsageError(
                    f"{option} {path} was given, expected a name that ends in "
                    f"{' or '.join(endings)}."
                )
            require_packages(path)
            require_new_file(path, option, is_forced=is_forced, inputs=inputs)

    def write(
        self, exported: Exported, recording: str, fps: float | None, *, in_frames: bool
    ) -> None:
        """Write the table and the plot.

        Args:
            exported: The track.
            recording: Name of what was tracked.
            fps: Its frames per second.
            in_frames: Whether the plot is over frame numbers instead of seconds.
        """
        if self.out is not None:
            made_by = {"command": command_line(), "recording": recording, "fps": fps}
            exported.save(self.out, made_by)
        if self.plot is not None:
            from geotlm_lm.track.plot import write_plot

            write_plot(self.plot, exported, in_frames=in_frames)


def event_line(event: Event, units: Units, *, in_frames: bool = False) -> str:
    """Return an event as a line of a table whose first is `aligned(HEAD)`.

    Args:
        event: What happened.
        units: Of the recording.
        in_frames: Whether to tell frame numbers instead of seconds.
    """
    from geotlm_lm.track.export import event_name

    ends = (event.begin, event.end) if in_frames else (event.begin_s, event.end_s)
    begin, end = (f"{one}" if in_frames else f"{one:.2f} s" for one in ends)
    far, likely = _told(units.amount(event))
    return aligned((begin, end, event_name(event), far, likely, f"{event.probability:.2f}"))


def aligned(cells: tuple[str, ...]) -> str:
    """Return one line of the table; its columns are as wide wherever it is printed."""
    begin, end, *others = cells
    columns = (f"{begin:>9}", f"{end:>9}", *map(str.ljust, others, WIDTHS))
    return "  ".join(columns).rstrip()


WIDTHS = (21, 8, 14, 4)


def totals_lines(exported: Exported) -> list[str]:
    """Return what a whole track comes to, in two sentences."""
    totals, unit = exported.totals(), exported.units.name
    turn, way = totals["turn_net"], totals["turn_in_all"]
    slide, far = totals["slide_net"], totals["slide_in_all"]
    sense = "clockwise" if turn["amount"] >= 0 else "counterclockwise"
    return [
        f"Turned by {abs(turn['amount']):.0f} degrees {sense} from first to last, "
        f"{way['amount']:.0f} there and back.",
        f"Slid by {slide['amount']:.3g} {unit} from first to last, {far['amount']:.3g} there and "
        f"back; touched for {totals['touched_s']:.2f} s.",
    ]


def _told(amount: tuple[Any, str] | None) -> tuple[str, str]:
    if amount is None:
        return "", ""
    span, unit = amount
    decimals = 1 if unit == "px" else 2 if unit == "mm" else 0
    low, high = sorted((abs(span.low), abs(span.high)))
    low = 0.0 if span.low < 0 < span.high else low
    far = f"{abs(span.mean):.{decimals}f} {unit}"
    return far, f"{low:.{decimals}f} to {high:.{decimals}f}"
