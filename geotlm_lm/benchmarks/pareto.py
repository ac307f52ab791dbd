"""The Pareto bench: what an answer, a command and a simulated clip cost, against their errors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from statistics import mean

from geotlm_lm.benchmarks import pareto_answers as answers
from geotlm_lm.benchmarks.pareto_processes import command_rows
from geotlm_lm.benchmarks.pareto_simulator import simulator_rows
from geotlm_lm.benchmarks.rendering import markdown, number, save_figure
from geotlm_lm.benchmarks.rows import Bench, Listing, Pivot, Row, Section, every

LOOP_MS = 40.0
"""A frame of a camera of 25 frames a second."""

NEARLY = 0.01
"""Errors this far apart count as the same."""


def picks(rows: Sequence[Row]) -> Iterator[tuple[str, str, Row | None]]:
    """Yield (use, rule, what to take) for a robot's loop and for a chat; None for nothing.

    Over the sources of four frames, a method has its mean error and median, and its slowest p95.
    """
    four = [row for row in rows if row.case.endswith(answers.FOUR)]
    methods = []
    for name in dict.fromkeys(row.variant for row in four):
        own = [row for row in four if row.variant == name]
        error, ms = mean(row.error for row in own), mean(row.ms_p50 for row in own)
        slowest = max(row.ms_p95 for row in own)
        methods.append(Row("every source", name, len(own), error, ms_p50=ms, ms_p95=slowest))
    near = f"the fastest within {NEARLY:g} of the least error"
    in_time = [row for row in methods if row.ms_p95 < LOOP_MS]
    speaking = [row for row in methods if row.variant.startswith(answers.WORDS)]
    for use, rule, able in (
        ("a robot's loop", f"{near} and a p95 below {LOOP_MS:g} ms", in_time),
        ("a chat", f"{near} that answers in words", speaking),
    ):
        least = min((row.error for row in able), default=0.0)
        good = [row for row in able if row.error <= least + NEARLY]
        yield use, rule, min(good, key=lambda row: row.ms_p50, default=None)


def picks_headline(rows: Sequence[Row]) -> str:
    """Return what to take for a robot's loop and for a chat, and what it costs."""
    lines = []
    for use, rule, taken in picks(rows):
        if taken is None:
            lines.append([use, rule, "none", "-", "-"])
        else:
            times = f"{taken.ms_p50:.1f} / {taken.ms_p95:.1f}"
            lines.append([use, rule, taken.variant, f"{taken.error:.3f}", times])
    return markdown(["for", "rule", "take", "mean error", "ms, median / p95"], lines)


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
SIZES = Listing(
    TIMED
    | {
        "parameters": lambda row: f"{row.detail['parameters']:,}",
        "error": lambda row: number(row.error),
    }
)
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
    about="What a smaller error costs in time and memory, and what to take for which use.",
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
            headline=picks_headline,
        ),
        Section(
            name="stages",
            title="Stages of an answer",
            about="Each stage alone on one clip, one thread; one prompt serves all ten scores.",
            run=answers.stage_rows,
            views={"": (Listing(TIMED), every)},
        ),
        Section(
            name="batches",
            title="Batches and threads",
            about="Median milliseconds per clip; words are perceived and written token by token.",
            run=answers.batch_rows,
            views={"": (Pivot(lambda row: number(row.ms_p50, ".2f"), "at once", False), every)},
        ),
        Section(
            name="commands",
            title="Cold starts of the commands",
            about="Fresh processes on one thread, files cached; MiB is the most they ever held.",
            run=command_rows,
            views={"": (COMMANDS, every)},
        ),
        Section(
            name="sizes",
            title="Sizes of the language model",
            about="""\
Each is trained for the same few steps on one frozen perception: rows compare with each other only.
Errors are means over the types of questions about everyday objects; times leave out perception.""",
            run=answers.size_rows,
            views={"": (SIZES, every)},
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
