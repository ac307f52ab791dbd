"""The Benchmark tab: recorded results as tables and figures; runs nothing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from .error_display import gradio

RECORDED = Path(__file__).resolve().parent.parent / "docs" / "results" / "records"
COLUMNS = ("clips", "n", "method", "accuracy", "low", "high", "error", "ms, median", "ms, p95")
ABSENT = (
    "The recorded results lie in a checkout's `docs/results`; this installation has none. "
    "`geotlm-lm bench accuracy` measures them anew."
)


def accuracy_rows(folder: Path = RECORDED) -> list[list[Any]]:
    """Return one row per set of clips and method as recorded; none where nothing is recorded."""
    path = folder / "accuracy.json"
    if not path.exists():
        return []
    rows = []
    for row in json.loads(path.read_text())["numbers"]["sections"]["clips"]["rows"]:
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
