"""A track as a picture: turn, travel and contact over time, its events coloured."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from geotlm_lm.core.files import replacing
from geotlm_lm.track.amounts import SPAN_DEVIATIONS
from geotlm_lm.track.events import EventKind
from geotlm_lm.track.export import Exported, require_packages

COLOURS = {
    EventKind.TOUCH: "black",
    EventKind.PRESS: "tab:green",
    EventKind.TURN: "tab:blue",
    EventKind.SLIDE: "tab:orange",
    EventKind.STICK: "tab:gray",
    EventKind.SLIP: "tab:red",
    EventKind.RELEASE: "tab:purple",
}

LANES = tuple(kind for kind in EventKind if kind is not EventKind.TOUCH)
"""Kinds of events that have a bar each, one below the other; a touch is a line through all."""


def write_plot(path: Path, exported: Exported, *, in_frames: bool) -> None:
    """Draw a track to a PNG file, as `plot_png` does.

    Args:
        path: Of the picture.
        exported: The track.
        in_frames: Whether to draw over frame numbers, as of recordings without a frame rate.

    Raises:
        MissingDependency: If matplotlib is not installed.
    """
    require_packages(path)
    drawn = plot_png(exported, in_frames=in_frames)
    with replacing(path) as stream:
        stream.write(drawn)


def plot_png(exported: Exported, *, in_frames: bool) -> bytes:
    """Return turn, travel and contact of each frame, with bands that hold nine tenths, as a PNG.

    Args:
        exported: The track.
        in_frames: Whether to draw over frame numbers, as of recordings without a frame rate.

    Raises:
        MissingDependency: If matplotlib is not installed.
    """
    require_packages(Path("timeline.png"))
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 7.5), layout="constrained")
    panels = figure.subplots(4, sharex=True, height_ratios=(3, 3, 1.5, 1.8))
    turn, travel, contact, events = panels
    times = exported.track.numbers if in_frames else exported.track.times_s
    _draw_ways(turn, travel, exported, times)
    contact.plot(times, exported.track.contact, color="black")
    contact.set(ylabel="contact\n(probability)", ylim=(-0.05, 1.05))
    _draw_events(panels, events, exported, in_frames)
    events.set_xlabel("frame" if in_frames else "time (s)")
    for axes in panels:
        axes.grid(alpha=0.3)
    figure.legend(loc="outside upper center", ncols=5, fontsize="small")
    stream = BytesIO()
    figure.savefig(stream, dpi=120, format="png")
    return stream.getvalue()


def _draw_ways(turn: Any, travel: Any, exported: Exported, times: np.ndarray) -> None:
    path, spread = exported.track.path_from_start, exported.track.path_deviations
    parts = [exported.units.travelled(one[:, 1], one[:, 2]) for one in (path, spread)]
    curves = (
        (turn, path[:, 0], spread[:, 0], "tab:blue", "turn (clockwise positive)"),
        (travel, parts[0][0], parts[1][0], "tab:orange", "travel to the right"),
        (travel, parts[0][1], parts[1][1], "tab:brown", "travel down the image"),
    )
    for axes, mean, deviation, colour, name in curves:
        far = SPAN_DEVIATIONS * deviation
        axes.plot(times, mean, color=colour, label=name)
        axes.fill_between(times, mean - far, mean + far, color=colour, alpha=0.2, linewidth=0)
    turn.set_ylabel("turn (degrees)")
    travel.set_ylabel(f"travel ({exported.units.name})")


def _draw_events(panels: Any, lanes: Any, exported: Exported, in_frames: bool) -> None:
    """Draw each event as a bar in its lane, and a line through all panels where contact begins."""
    named: set[EventKind] = set()
    for event in exported.track.events:
        begin, end = (event.begin_s, event.end_s)
        if in_frames:
            begin, end = event.begin, event.end
        label = None if event.kind in named else event.kind.value
        named.add(event.kind)
        colour = COLOURS[event.kind]
        if event.kind is EventKind.TOUCH:
            for axes in panels:
                axes.axvline(begin, color=colour, linestyle=":", linewidth=1)
            lanes.axvline(begin, color=colour, linestyle=":", linewidth=1, label=label)
            continue
        lane = LANES.index(event.kind)
        lanes.barh(lane, end - begin, left=begin, height=0.7, color=colour, label=label,
                   edgecolor="white" if end > begin else colour)  # fmt: skip
        if event.kind in (EventKind.TURN, EventKind.SLIDE):
            axes = panels[0 if event.kind is EventKind.TURN else 1]
            axes.axvspan(begin, end, color=colour, alpha=0.07, linewidth=0)
    lanes.set_yticks(range(len(LANES)), [kind.value for kind in LANES], fontsize="small")
    lanes.set_ylim(len(LANES) - 0.5, -0.5)
