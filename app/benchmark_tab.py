"""The Benchmark tab: recorded results as tables and figures; runs nothing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from .told import gradio

RECORDED = Path(__file__).resolve().parent.parent / "reports" / "recorded"
COLUMNS = ("clips", "n", "method", "accuracy", "low", "high", "error", "ms, median", "ms, p95")
ABSENT = (
    "The recorded results lie in a checkout's `reports/recorded`; this installation has none. "
    "`geotlm-lm evaluate` measures them anew."
)


def accuracy_rows(folder: Path = RECORDED) -> list[list[Any]]:
    """Return one row per table and method of the recorded evaluation; none where there is none."""
    path = folder / "evaluate.json"
    if not path.exists():
        return []
    tables = json.loads(path.read_text())["numbers"]["tables"]
    rows = []
    for clips, table in tables.items():
        for method, scores in table["methods"].items():
            low, high = scores["interval"]
            accuracy = scores["accuracy"]
            numbers = [accuracy, low, high, 1 - accuracy, scores["ms_median"], scores["ms_p95"]]
            rows.append([clips, table["clips"], method, *(round(v, 4) for v in numbers)])
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
        "Errors with their run time, as recorded; the probes and optical flow choose among the "
        "motions of the task, the words are free."
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
