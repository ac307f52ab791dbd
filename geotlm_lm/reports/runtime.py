"""The record of error against run time -> what to pick, its tables, and the figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

from geotlm_lm.core.atomic import replacing
from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.pareto import is_on_front, picks
from geotlm_lm.reports.tables import markdown, provenance

TITLE = "# Error against run time"

INTRO = """\
Every method is put to every clip in turn, repeat by repeat, on one thread; times are from the clip
in memory to the motion, the model's rows with the perception they share counted in full. Error is 1
- accuracy. The probes, the scored answers and the flow choose among the task's motions; generated
words may be any of ten, and are found in the pass that weighs these (in the table of batches they
are written token by token). Curl + LR is fitted on simulated turns and tells turns alone. `*` marks
what no other method beats in both error and median time. Degrees and pixels are median errors of
the turn and the travel measured, from the first frame to the last: by the flow's rigid fit, or by
one fitted to the model's learned shear, the same for all its rows."""

PICK_NOTE = """\
Other number formats than float32 are chosen by `--precision`."""

STAGE_NOTE = "Each stage alone on one clip, one thread; the prompt is read once for all ten scores."

BATCH_NOTE = """\
Milliseconds per clip, median of the repeats; each work perceives its clips first. `gain` is how
many times the clips per second of its smallest batch."""

COMMAND_NOTE = """\
Wall time of fresh processes on one thread each, interpreter start and exit included, files cached;
import seconds are the interpreter's own account, which itself slows a start by about a tenth."""

OMISSION_NOTE = "Both ways run in turn; medians, saving with its range over the repeats."

SHOWN_PACKAGES = 4


def runtime_page(record: RunRecord) -> str:
    """Return the whole report as a page."""
    numbers = record.numbers
    parts = [TITLE, "## What to pick", pick_table(record), "## Methods", INTRO]
    for source, frames in _shares(numbers["methods"]):
        rows = [r for r in numbers["methods"] if (r["source"], r["frames"]) == (source, frames)]
        parts += [f"### {source}, {frames} frames, {rows[0]['clips']} clips", method_table(rows)]
    if record.config.get("left_out"):
        parts.append(f"This machine cannot run: {', '.join(record.config['left_out'])}.")
    parts += ["## Stages of an answer", _stage_table(numbers["stages"]), STAGE_NOTE]
    parts += ["## Batches and threads", _batch_table(numbers["batches"]), BATCH_NOTE]
    parts += ["## Peak memory of a fresh process", _memory_table(numbers["memory"])]
    parts += ["## Cold start of every command", _command_table(numbers["commands"]), COMMAND_NOTE]
    parts += ["## What each omission saves", omission_table(numbers["omissions"]), OMISSION_NOTE]
    return "\n\n".join([*parts, provenance(record)]) + "\n"


def pick_table(record: RunRecord) -> str:
    """Return what to take for a robot's loop, a batch job and a chat, picked from the numbers."""
    rows = [
        [
            pick.use,
            pick.rule,
            pick.method or "none",
            "-" if pick.error is None else f"{pick.error:.3f}",
            pick.cost,
        ]
        for pick in picks(record.numbers)
    ]
    return f"{markdown(['for', 'the rule', 'take', 'mean error', 'cost'], rows)}\n\n{PICK_NOTE}"


def runtime_headline(record: RunRecord) -> str:
    """Return what to pick, and how long each stage of an answer takes, for the README."""
    stages = _stage_table(record.numbers["stages"])
    return "\n\n".join([pick_table(record), stages, STAGE_NOTE, provenance(record)])


def method_table(rows: Sequence[dict[str, Any]]) -> str:
    """Return one row per method of one source and frame count, those on the Pareto front marked."""
    cells = [
        [
            f"{row['method']}{' *' if is_on_front(row, rows) else ''}",
            f"{row['error']:.3f}",
            "{:.3f}-{:.3f}".format(*row["error_interval"]),
            _number(row["turn_error_deg"], ".1f"),
            _number(row["slide_error_px"], ".1f"),
            f"{row['ms_median']:.1f}",
            f"{row['ms_p95']:.1f}",
            f"{row['ms_q25']:.1f}-{row['ms_q75']:.1f}",
        ]
        for row in rows
    ]
    header = ["method", "error", "95 %", "degrees off", "px off", "ms, median", "p95", "quartiles"]
    return markdown(header, cells)


def omission_table(rows: Sequence[dict[str, Any]]) -> str:
    """Return one row per thing left out, with what doing it would take."""
    cells = []
    for row in rows:
        saved = [full - lean for full, lean in zip(row["full_ms"], row["lean_ms"], strict=True)]
        cells.append(
            [
                row["omission"],
                row["when"],
                f"{median(row['full_ms']):.1f}",
                f"{median(row['lean_ms']):.1f}",
                f"{median(saved):.1f} ({min(saved):.1f} to {max(saved):.1f})",
            ]
        )
    return markdown(["left out", "when", "ms with it", "ms without", "ms saved"], cells)


def draw_runtime(record: RunRecord, path: Path) -> None:
    """Draw error over median time, one panel per source and frame count, the front as a line.

    Args:
        record: From `runtime`.
        path: The .png or .svg to write.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

    methods = record.numbers["methods"]
    shares = _shares(methods)
    names = list(dict.fromkeys(row["method"] for row in methods))
    columns = min(len(shares), 2)
    lines = -(-len(shares) // columns)
    figure = Figure(figsize=(5.2 * columns, 3.4 * lines + 1.2), layout="constrained")
    panels = figure.subplots(lines, columns, squeeze=False).ravel()
    for axes in panels[len(shares) :]:
        axes.remove()
    panels = panels[: len(shares)]
    for axes, (source, frames) in zip(panels, shares, strict=True):
        rows = [row for row in methods if (row["source"], row["frames"]) == (source, frames)]
        for row in rows:
            number = names.index(row["method"])
            times = [[row["ms_median"] - row["ms_q25"]], [row["ms_p95"] - row["ms_median"]]]
            axes.errorbar(
                row["ms_median"],
                row["error"],
                xerr=times,
                fmt="os^D"[number // 10 % 4],
                color=f"C{number % 10}",
                label=row["method"],
            )
        front = sorted((row["ms_median"], row["error"]) for row in rows if is_on_front(row, rows))
        axes.step(*zip(*front, strict=True), where="post", color="grey", linewidth=1)
        axes.set(xscale="log", title=f"{source}, {frames} frames", xlabel="ms per clip")
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.xaxis.set_major_formatter(ScalarFormatter())
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.grid(alpha=0.3)
    for axes in panels[::columns]:
        axes.set_ylabel("error (1 - accuracy)")
    marks = {}
    for axes in panels:
        handles, labels = axes.get_legend_handles_labels()
        marks |= dict(zip(labels, handles, strict=True))
    figure.legend(
        marks.values(), marks.keys(), fontsize="x-small", loc="outside lower center", ncols=4
    )
    with replacing(path) as stream:
        figure.savefig(stream, dpi=120, format=path.suffix.removeprefix("."))


def _shares(rows: Sequence[dict[str, Any]]) -> list[tuple[str, int]]:
    return sorted({(row["source"], row["frames"]) for row in rows}, key=lambda x: (x[0], -x[1]))


def _stage_table(rows: Sequence[dict[str, Any]]) -> str:
    keys = ("ms_median", "ms_p95", "ms_q25", "ms_q75")
    cells = [[row["stage"], *(f"{row[key]:.2f}" for key in keys)] for row in rows]
    return markdown(["stage", "ms, median", "p95", "lower quartile", "upper quartile"], cells)


def _batch_table(rows: Sequence[dict[str, Any]]) -> str:
    sizes = sorted({row["batch"] for row in rows})
    lines: dict[tuple[str, str, int], dict[int, float]] = {}
    for row in rows:
        key = (row["work"], row["precision"], row["threads"])
        lines.setdefault(key, {})[row["batch"]] = row["ms_median"]
    cells = [
        [
            f"{work}, {precision}, {threads} thread{'s' * (threads > 1)}",
            *(_number(own.get(size), ".2f") for size in sizes),
            f"{own[min(own)] / min(own.values()):.1f}",
        ]
        for (work, precision, threads), own in lines.items()
    ]
    return markdown(["work", *(f"batch {size}" for size in sizes), "gain"], cells)


def _memory_table(rows: Sequence[dict[str, Any]]) -> str:
    cells = [[row["way"], f"{row['megabytes']:.0f}"] for row in rows]
    return markdown(["way", "MiB"], cells)


def _command_table(rows: Sequence[dict[str, Any]]) -> str:
    cells = []
    for row in rows:
        seconds = row["seconds"]
        largest = sorted(row["packages_s"].items(), key=lambda item: -item[1])[:SHOWN_PACKAGES]
        cells.append(
            [
                row["command"],
                f"{median(seconds):.2f} ({min(seconds):.2f}-{max(seconds):.2f})",
                f"{row['import_s']:.2f}",
                ", ".join(f"{name} {value:.2f}" for name, value in largest),
            ]
        )
    return markdown(["command", "s, median (range)", "imports, s", "of which"], cells)


def _number(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)
