"""A track as a figure for print: a row for each kind of motion that occurs, a column (89 mm) wide.

Colours are those of Okabe and Ito, and lines differ in their dashes too: a grey copy is readable.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.figures import figure_of
from geotlm_lm.core.files import replacing
from geotlm_lm.core.twist import Component
from geotlm_lm.track.drawing import Band, Drawing, drawing_of
from geotlm_lm.track.events import Event, EventKind
from geotlm_lm.track.export import Exported, require_packages

ENDINGS = (".png", ".svg", ".pdf")

WIDTH_IN = 89 / 25.4
DPI = 300
TEXT_PT, LABEL_PT = 7.0, 6.0
TITLE_CHARACTERS = 56

MOST_LINES = 3
"""Lines of labels above a row; the smallest events of a full row stay without one."""

GAP_PX = 6.0
"""Between two labels of a line, at `DPI`."""

LINE_IN = 0.115
"""Height of a line of labels."""

BLUE, VERMILLION, GREEN, PURPLE, BLACK = "#0072B2", "#D55E00", "#007A5A", "#AA4499", "#222222"
UNDETECTED, HELD, SLIPPING = "#DDDDDD", "#BBBBBB", "#555555"

LINES = {
    "turn": (BLUE, "-"),
    "right": (VERMILLION, "-"),
    "down": (GREEN, (0, (4, 1.5))),
    "depth": (PURPLE, "-"),
    "contact": (BLACK, "-"),
}
"""Colour and dashes of each curve."""

ARROWS = {
    "clockwise": "↻",
    "counterclockwise": "↺",
    "right": "→",
    "left": "←",
    "up": "↑",
    "down": "↓",
}

_LOCK = Lock()
"""Matplotlib's settings and Python's warnings are those of the whole process."""


@dataclass(frozen=True)
class Row:
    """A row of the figure: its curves are those of the panel of the same name."""

    name: str
    kinds: tuple[EventKind, ...]  # that make it occur
    height_in: float
    component: Component | None = None  # whose detection limit is drawn


ROWS = (
    Row("turn", (EventKind.TURN,), 0.8, Component.TURN),
    Row("travel", (EventKind.SLIDE,), 0.8, Component.SLIDE),
    Row("depth", (EventKind.PRESS, EventKind.RELEASE), 0.6, Component.PRESS),
    Row("contact", (EventKind.TOUCH,), 0.35),
    Row("grip", (EventKind.STICK, EventKind.SLIP), 0.12),
)


def write_plot(path: Path, exported: Exported, *, in_frames: bool, title: str = "") -> None:
    """Draw a track to a .png, .svg or .pdf file; arguments and errors as of `plot`."""
    require_packages(path)
    content = plot(exported, path.suffix, in_frames=in_frames, title=title)
    with replacing(path) as stream:
        stream.write(content)


def plot_png(exported: Exported, *, in_frames: bool, title: str = "") -> bytes:
    """Return the figure of a track as a PNG; arguments and errors as of `plot`."""
    return plot(exported, ".png", in_frames=in_frames, title=title)


def plot(exported: Exported, ending: str, *, in_frames: bool, title: str = "") -> bytes:
    """Return turn, travel, depth, contact and grip over time, as far as they occur.

    Coloured bands hold nine tenths of the probability; the grey one about zero is the detection
    limit of a motion as slow as the recording is long, quicker ones are seen from less on.
    Words stay words in .svg and .pdf files.

    Args:
        exported: The track.
        ending: ".png", ".svg" or ".pdf".
        in_frames: Whether to draw over frame numbers, as of recordings without a frame rate.
        title: The recording's name.

    Raises:
        UsageError: If it ends otherwise.
        MissingDependency: If matplotlib is not installed.
    """
    if ending not in ENDINGS:
        raise UsageError(
            f"A plot was to end in {ending}, expected {' or '.join(ENDINGS)}; give one of these "
            f"endings."
        )
    require_packages(Path(f"plot{ending}"))
    stream = BytesIO()
    with _settings():
        figure = _figure(exported, in_frames=in_frames, title=title)
        undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
        figure.savefig(stream, dpi=DPI, format=ending[1:], metadata=undated.get(ending))
    return stream.getvalue()


@contextmanager
def _settings() -> Iterator[None]:
    import matplotlib

    words = {"svg.fonttype": "none", "pdf.fonttype": 42, "svg.hashsalt": "geotlm-lm"}
    lines = {"axes.linewidth": 0.5, "xtick.major.width": 0.5, "ytick.major.width": 0.5}
    sizes = {"xtick.major.size": 2.0, "ytick.major.size": 2.0, "font.size": TEXT_PT}
    with _LOCK, matplotlib.rc_context(words | lines | sizes), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph")  # of names in scripts the font lacks
        yield


def _figure(exported: Exported, *, in_frames: bool, title: str) -> Any:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    drawing = drawing_of(exported.track, exported.units)
    rows = _occurring(exported, drawing)
    lines = [MOST_LINES * LINE_IN if _labels(row, drawing) else 0.0 for row in rows]
    heights = [row.height_in + 0.6 * above for row, above in zip(rows, lines, strict=True)]
    figure = Figure(figsize=(WIDTH_IN, sum(heights) + 1.0), layout="constrained", dpi=DPI)
    FigureCanvasAgg(figure)  # measures the labels
    figure.get_layout_engine().set(w_pad=0.02, h_pad=0.02, hspace=0.02)
    axes = np.atleast_1d(figure.subplots(len(rows), sharex=True, height_ratios=heights))
    times = drawing.numbers if in_frames else drawing.times_s
    limits = exported.limits()
    for row, panel in zip(rows, axes, strict=True):
        _draw_row(panel, row, drawing, times, limits.get(row.component), in_frames)
    axes[-1].set_xlabel("frame" if in_frames else "time (s)", labelpad=2)
    axes[-1].set_xlim(*_ends(times))
    figure.align_ylabels(list(axes))
    figure.suptitle(_title(exported, title, in_frames), fontsize=TEXT_PT, parse_math=False)
    _draw_legend(figure, axes)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for row, panel in zip(rows, axes, strict=True):
        _draw_labels(panel, _labels(row, drawing), in_frames)
    return figure


def _occurring(exported: Exported, drawing: Drawing) -> list[Row]:
    """Return the rows in which something happens; at least that of contact, or of the turn."""
    kinds = {
        band.event.kind for band in drawing.bands if band.event.kind not in _PLAIN or band.unit
    }
    track = exported.track
    if track.is_contact_known:
        kinds |= {EventKind.TOUCH} if track.is_touched.any() or not kinds else set()
    else:
        kinds -= {EventKind.TOUCH}
    return [row for row in ROWS if kinds.intersection(row.kinds)] or [ROWS[0]]


_PLAIN = (EventKind.PRESS, EventKind.RELEASE)
"""Kinds that need not have an amount, and then have no row."""


def _title(exported: Exported, name: str, in_frames: bool) -> str:
    track = exported.track
    name = name.encode("utf-8", "replace").decode() or "Tracked motion"
    long = f"{len(track)} frames" if in_frames else f"{track.seconds:.1f} s, {len(track)} frames"
    room = TITLE_CHARACTERS - len(long)
    name = name if len(name) <= room else f"…{name[1 - room :]}"
    return f"{name} ({long})"


def _ends(times: Any) -> tuple[float, float]:
    if not len(times):
        return 0.0, 1.0
    first, last = float(times[0]), float(times[-1])
    margin = 0.01 * (last - first) or 0.5
    return first - margin, last + margin


def _draw_row(
    panel: Any, row: Row, drawing: Drawing, times: Any, limit: float | None, in_frames: bool
) -> None:
    """Draw the limit, the spans of the events and the curves of a row, from back to front."""
    if limit:
        panel.axhspan(-limit, limit, color=UNDETECTED, linewidth=0, zorder=0,
                      label="detection limit")  # fmt: skip
        for edge in (-limit, limit):
            panel.axhline(edge, color="#999999", linewidth=0.4, linestyle=(0, (1, 1)), zorder=0.5)
    for band in drawing.bands:
        if band.event.kind in row.kinds:
            _draw_span(panel, row, band.event, in_frames)
    for curve in drawing.curves:
        if curve.panel != row.name:
            continue
        colour, dashes = LINES[curve.name]
        label = curve.name if row.name == "travel" else None
        panel.plot(times, curve.mean, color=colour, linestyle=dashes, linewidth=0.9, label=label)
        if curve.spread is not None:
            low, high = curve.mean - curve.spread, curve.mean + curve.spread
            panel.fill_between(times, low, high, color=colour, alpha=0.25, linewidth=0,
                               label="90 % span" if row.name == "turn" else None)  # fmt: skip
    unit = {"turn": "turn (°)\nclockwise +", "travel": f"slide\n({drawing.units.name})",
            "depth": "depth\n(mm)", "contact": "contact\n(prob.)", "grip": "grip"}  # fmt: skip
    panel.set_ylabel(unit[row.name], fontsize=LABEL_PT, labelpad=2)
    panel.tick_params(labelsize=LABEL_PT, pad=1.5)
    panel.spines[["top", "right"]].set_visible(False)
    panel.locator_params(axis="y", nbins=4)
    if row.name in ("contact", "grip"):
        panel.set_ylim(0.0, 1.05)
        panel.set_yticks([0, 1] if row.name == "contact" else [])


def _draw_span(panel: Any, row: Row, event: Event, in_frames: bool) -> None:
    begin, end = _span(event, in_frames)
    if event.kind is EventKind.TOUCH:
        panel.vlines(begin, 0, 1, color=BLACK, linewidth=0.6, linestyle=(0, (1, 1)))
        return
    if row.name == "grip":
        is_held = event.kind is EventKind.STICK
        panel.barh(0.5, end - begin, left=begin, height=1.0, linewidth=0.5,
                   color=HELD if is_held else SLIPPING, edgecolor="white")  # fmt: skip
        return
    colour = LINES["right" if row.name == "travel" else row.name][0]
    panel.axvspan(begin, end, color=colour, alpha=0.1, linewidth=0, zorder=0.7)


def _span(event: Event, in_frames: bool) -> tuple[float, float]:
    return (event.begin, event.end) if in_frames else (event.begin_s, event.end_s)


def _draw_legend(figure: Any, axes: Any) -> None:
    entries: dict[str, Any] = {}
    for panel in axes:
        handles, labels = panel.get_legend_handles_labels()
        entries |= dict(zip(labels, handles, strict=True))
    if entries:
        figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=4,
                      fontsize=LABEL_PT, frameon=False, handlelength=1.8, columnspacing=1.2,
                      borderpad=0)  # fmt: skip


def _labels(row: Row, drawing: Drawing) -> list[tuple[Event, str]]:
    """Return what is written above the events of a row, the largest first."""
    bands = [band for band in drawing.bands if band.event.kind in row.kinds]
    bands.sort(key=lambda band: (-band.amount, -(band.event.end - band.event.begin)))
    return [(band.event, _label(band)) for band in bands]


def _label(band: Band) -> str:
    kind, way = band.event.kind, band.name.removeprefix(band.event.kind.value).strip()
    if kind is EventKind.STICK:
        return "rest"
    if kind is EventKind.SLIP or not band.unit:
        return kind.value
    far = figure_of(band.amount) + ("°" if band.unit == "deg" else f" {band.unit}")
    return f"{ARROWS[way]} {far}" if way in ARROWS else f"{kind.value} {far}"


def _draw_labels(panel: Any, labels: list[tuple[Event, str]], in_frames: bool) -> None:
    """Write labels above their events, in as many lines as keep them apart, over the curves."""
    figure = panel.figure
    renderer = figure.canvas.get_renderer()
    frame, lines = panel.get_window_extent(renderer), [[] for _ in range(MOST_LINES)]
    placed = []
    for event, words in labels:
        text = figure.text(0, 0, words, fontsize=LABEL_PT, ha="center", va="center", color=BLACK)
        half = text.get_window_extent(renderer).width / 2 + GAP_PX / 2
        middle = panel.transData.transform((np.mean(_span(event, in_frames)), 0))[0]
        left, right = frame.x0 + half + GAP_PX, frame.x1 - half
        middle = float(np.clip(middle, left, max(left, right)))
        free = (
            line
            for line, taken in enumerate(lines)
            if all(middle + half <= low or high <= middle - half for low, high in taken)
        )
        line = next(free, None)
        if line is None:
            text.remove()
            continue
        lines[line].append((middle - half, middle + half))
        placed.append((text, middle, line))
    used = sum(bool(taken) for taken in lines)
    share = used * LINE_IN * figure.dpi / frame.height
    low, high = panel.get_ylim()
    # Other ticks would be wider than those that the figure is laid out for.
    panel.set_yticks([tick for tick in panel.get_yticks() if low <= tick <= high])
    panel.set_ylim(low, high + (high - low) * share / max(1 - share, 0.2))
    for text, middle, line in placed:
        across, up = figure.transFigure.inverted().transform(
            (middle, frame.y1 - (used - line - 0.5) * LINE_IN * figure.dpi)
        )
        text.set_position((across, up))
