"""The Pareto bench: what an answer, a command and a simulated clip cost, against their errors."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from geotlm_lm.benchmarks import pareto_answers as answers
from geotlm_lm.benchmarks.pareto_processes import command_rows
from geotlm_lm.benchmarks.pareto_simulator import simulator_rows
from geotlm_lm.benchmarks.rendering import number, save_figure
from geotlm_lm.benchmarks.rows import Bench, Listing, Row, Section, every


def draw_fronts(cases: str, scale: str, rows: Sequence[Row], path: Path) -> None:
    """Draw error over median time by case, the front as a line; a "log" scale shows no 0."""
    from matplotlib.figure import Figure

    shown = [row for row in rows if row.case.endswith(cases) and (row.error or scale == "linear")]
    titles = list(dict.fromkeys(row.case for row in shown))
    names = list(dict.fromkeys(row.variant for row in shown))
    lines = -(-len(titles) // 2)
    figure = Figure(figsize=(8, 2.6 * lines + 1.2), layout="constrained")
    for place, title in enumerate(titles, start=1):
        axes = figure.add_subplot(lines, 2, place)
        own = [row for row in shown if row.case == title]
        for row in own:
            at = names.index(row.variant)
            axes.plot(row.ms_p50, row.error, "os^D"[at // 10], c=f"C{at}", label=row.variant)
        front = sorted((row.ms_p50, row.error) for row in own if row.detail["is_on_front"])
        if front:
            axes.step(*zip(*front, strict=True), where="post", color="black", zorder=0)
        axes.set(xscale="log", yscale=scale, title=title, xlabel="ms per clip", ylabel="error")
        axes.grid(alpha=0.3)
    legend = figure.axes[0].get_legend_handles_labels()
    figure.legend(*legend, loc="outside lower center", ncols=3, fontsize="small")
    save_figure(figure, rows, path)


TIMED = {
    "what": lambda row: row.variant + " *" * row.detail.get("is_on_front", False),
    "ms, median": lambda row: number(row.ms_p50, ".1f"),
    "p95": lambda row: number(row.ms_p95, ".1f"),
}
METHODS = Listing(
    {"clips": lambda row: row.case, "n": lambda row: str(row.count)}
    | TIMED
    | {
        "error": lambda row: number(row.error),
        "95 %": lambda row: "{:.3f}-{:.3f}".format(*row.interval),
    }
)
COMMANDS = Listing(TIMED | {"MiB": lambda row: number(row.memory_mib, ".0f")})
PRESETS = Listing(
    {
        "compared": lambda row: row.case,
        "what": TIMED["what"],
        "ms": TIMED["ms, median"],
        "error": lambda row: f"{row.error:.3g}",
        "range": lambda row: "{:.2g} to {:.2g}".format(*row.detail["range"]),
    }
)

PARETO = Bench(
    name="pareto",
    title="Error against run time and memory",
    about="What a smaller error costs in time and memory. Times compare within a table alone.",
    sections=(
        Section(
            name="methods",
            title="Ways to name a motion",
            about="""\
Every method is put to every clip in turn, on one thread, from the clip in memory to the motion.
Words may name any of ten motions, the others choose among the task's. `*` marks what nothing beats
in both error and median time.""",
            run=answers.method_rows,
            views={
                "Simulated clips": (METHODS, lambda row: row.case.startswith("simulated")),
                "Real recordings": (METHODS, lambda row: row.case.startswith("real")),
            },
            figure=partial(draw_fronts, answers.FOUR, "linear"),
        ),
        Section(
            name="stages",
            title="Stages of an answer",
            about="Each stage alone on one clip, one thread; one prompt serves all ten scores.",
            run=answers.stage_rows,
            views={"": (Listing(TIMED), every)},
        ),
        Section(
            name="commands",
            title="Cold starts of the commands",
            about="Fresh processes on one thread, files cached; MiB is the most they ever held.",
            run=command_rows,
            views={"": (COMMANDS, every)},
        ),
        Section(
            name="simulator",
            title="Simulator",
            about="""\
Presets and two shortcuts against the reference preset on a ball, a key and a nut that are twisted,
slid or pressed: medians and ranges over nine scenes, one thread, surfaces alone.""",
            run=simulator_rows,
            views={"": (PRESETS, every)},
            figure=partial(draw_fronts, "", "log"),
        ),
    ),
)
