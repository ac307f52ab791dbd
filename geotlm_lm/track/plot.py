"""A track as a picture: turn, travel and contact over time, its events coloured."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

from geotlm_lm.core.files import replacing
from geotlm_lm.track.drawing import Drawing, drawing_of
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

STYLES = {
    "turn": ("tab:blue", "turn (clockwise positive)"),
    "right": ("tab:orange", "travel to the right"),
    "down": ("tab:brown", "travel down the image"),
    "contact": ("black", None),
}


def write_plot(path: Path, exported: Exported, *, in_frames: bool) -> None:
    """Draw a track to a PNG file; arguments and errors as of `plot_png`."""
    require_packages(path)
    png = plot_png(exported, in_frames=in_frames)
    with replacing(path) as stream:
        stream.write(png)


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

    drawing = drawing_of(exported.track, exported.units)
    figure = Figure(figsize=(9.0, 7.5), layout="constrained")
    axes = figure.subplots(4, sharex=True, height_ratios=(3, 3, 1.5, 1.8))
    panels = dict(zip(("turn", "travel", "contact", "events"), axes, strict=True))
    _draw_curves(panels, drawing, drawing.numbers if in_frames else drawing.times_s)
    panels["turn"].set_ylabel("turn (degrees)")
    panels["travel"].set_ylabel(f"travel ({drawing.units.name})")
    panels["contact"].set(ylabel="contact\n(probability)", ylim=(-0.05, 1.05))
    _draw_bands(panels, drawing, in_frames)
    panels["events"].set_xlabel("frame" if in_frames else "time (s)")
    for panel in axes:
        panel.grid(alpha=0.3)
    figure.legend(loc="outside upper center", ncols=5, fontsize="small")
    stream = BytesIO()
    figure.savefig(stream, dpi=120, format="png")
    return stream.getvalue()


def _draw_curves(panels: dict[str, Any], drawing: Drawing, times: Any) -> None:
    for curve in drawing.curves:
        if curve.name not in STYLES:
            continue
        axes, (colour, label) = panels[curve.panel], STYLES[curve.name]
        axes.plot(times, curve.mean, color=colour, label=label)
        if curve.spread is not None:
            low, high = curve.mean - curve.spread, curve.mean + curve.spread
            axes.fill_between(times, low, high, color=colour, alpha=0.2, linewidth=0)


def _draw_bands(panels: dict[str, Any], drawing: Drawing, in_frames: bool) -> None:
    """Draw each event as a bar in its lane, and a line through all panels where contact begins."""
    lanes, labelled = panels["events"], set()
    for event in (band.event for band in drawing.bands):
        begin, end = (event.begin, event.end) if in_frames else (event.begin_s, event.end_s)
        label = None if event.kind in labelled else event.kind.value
        labelled.add(event.kind)
        colour = COLOURS[event.kind]
        if event.kind is EventKind.TOUCH:
            for axes in (*panels.values(), lanes):
                axes.axvline(begin, color=colour, linestyle=":", linewidth=1)
            lanes.lines[-1].set_label(label)
            continue
        lane = LANES.index(event.kind)
        lanes.barh(lane, end - begin, left=begin, height=0.7, color=colour, label=label,
                   edgecolor="white" if end > begin else colour)  # fmt: skip
        panel = {EventKind.TURN: "turn", EventKind.SLIDE: "travel"}.get(event.kind)
        if panel is not None:
            panels[panel].axvspan(begin, end, color=colour, alpha=0.07, linewidth=0)
    lanes.set_yticks(range(len(LANES)), [kind.value for kind in LANES], fontsize="small")
    lanes.set_ylim(len(LANES) - 0.5, -0.5)
