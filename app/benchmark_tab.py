"""The Benchmark tab: recorded results as tables and figures; runs nothing."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from .error_display import gradio

RECORDED = Path(__file__).resolve().parent.parent / "docs" / "results" / "records"
COLUMNS = ("clips", "n", "method", "accuracy", "low", "high", "error", "ms, median", "ms, p95")
ABSENT = (
    "The recorded results lie in a checkout's `docs/results`; this installation has none. "
    "`geotlm-lm bench accuracy` measures them anew."
)


WORDS, FLOW = "words", "optical flow, of the task"
"""What is compared."""

LEFT_OUT = (
    *("simulated", "semi-real", ", tune"),
    *("untouched", "no visible contact", "pressed in", " fps,"),
)
"""Marks of sets that are not real, that something was chosen by, that are no turns or slides, or
that are parts of others."""


def clip_rows(folder: Path = RECORDED) -> list[dict[str, Any]]:
    """Return what was recorded of single clips, a row per set and method; none where nothing is."""
    path = folder / "accuracy.json"
    if not path.exists():
        return []
    return json.loads(path.read_text())["numbers"]["sections"]["clips"]["rows"]


def introduction(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return in two sentences what the tab shows, and when plain optical flow is the better choice.

    Args:
        rows: As of `clip_rows`.
    """
    shows = (
        "This tab shows how often the recorded runs were right, and how long an answer took, for "
        "the model's words and for plainer methods on the same clips."
    )
    told = [row for row in rows if not any(mark in row["case"] for mark in LEFT_OUT)]
    words = {row["case"]: row for row in told if row["variant"] == WORDS}
    flow = {row["case"]: row for row in told if row["variant"] == FLOW and row["case"] in words}
    level = [case for case in flow if flow[case]["error"] <= words[case]["error"]]
    where = (
        "where you only need to know which of two ways something turns, or which of four it slides"
    )
    if not flow:
        return shows
    if 2 * len(level) > len(flow):
        advice = f"Plain optical flow is the better choice {where}"
    else:
        advice = f"Plain optical flow is mostly behind even {where}"
    return (
        f"{shows} {advice}: it was right at least as often on {len(level)} of {len(flow)} sets of "
        f"real turns and slides that nothing was chosen by, and took {_middle_ms(flow):.0f} ms a "
        f"clip against {_middle_ms({case: words[case] for case in flow}):.0f} ms."
    )


def _middle_ms(rows: Mapping[str, Mapping[str, Any]]) -> float:
    return median(row["ms_p50"] for row in rows.values())


def accuracy_rows(folder: Path = RECORDED) -> list[list[Any]]:
    """Return one row per set of clips and method as recorded; none where nothing is recorded."""
    rows = []
    for row in clip_rows(folder):
        low, high = (1 - end for end in reversed(row["interval"]))
        numbers = [1 - row["error"], low, high, row["error"], row["ms_p50"], row["ms_p95"]]
        told = (round(value, 4) for value in numbers)
        rows.append([row["case"], row["count"], row["variant"], *told])
    return rows


def record_rows(folder: Path = RECORDED) -> list[list[Any]]:
    """Return name, command, commit, minutes and date of every recorded run."""
    rows = []
    for path in sorted(folder.glob("*.json")):
        record = json.loads(path.read_text())
        minutes = round(record["seconds"] / 60, 1)
        rows.append(
            [record["name"], record["command"], record["commit"], minutes, record["made_utc"]]
        )
    return rows


def build() -> None:
    """Lay the tab out; call it inside a `gradio.Tab`."""
    gr = gradio()
    rows = accuracy_rows()
    if not rows:
        gr.Markdown(ABSENT)
        return
    names = sorted({row[0] for row in rows})
    gr.Markdown(introduction(clip_rows()))
    gr.Markdown(
        'Errors with their run time, as recorded. Methods "of the task" choose among its motions '
        "only; the words are free."
    )
    chosen = gr.Dropdown(names, value=names[0], label="Clips")
    plot = gr.ScatterPlot(
        _frame(rows, names[0]),
        x="ms, median",
        y="error",
        color="method",
        title="Error against run time per clip",
        height=320,
    )
    table = gr.Dataframe(_frame(rows, names[0]), interactive=False, label="Accuracy")
    headers = ["run", "command", "commit", "minutes", "made (UTC)"]
    gr.Dataframe(record_rows(), headers=headers, interactive=False, label="Recorded runs")
    chosen.change(
        lambda name: (_frame(rows, name), _frame(rows, name)),
        chosen,
        [plot, table],
        api_visibility="private",
    )


def _frame(rows: list[list[Any]], clips: str) -> Any:
    import pandas as pd

    return pd.DataFrame([row for row in rows if row[0] == clips], columns=list(COLUMNS))
