"""The record of language models of several sizes as one table."""

from __future__ import annotations

from typing import Any

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.tables import markdown, provenance

COLUMNS = (
    "language model",
    "parameters",
    "turns",
    "slides",
    "all types",
    "unseen wordings",
    "weigh, ms",
    "p95",
    "write, ms",
    "p95",
)


def sizes_page(record: RunRecord) -> str:
    """Return the page: what was trained how, and the rows."""
    config = record.config
    return (
        "# How large a language model has to be\n\n"
        f"Every row was trained for {config['steps']:,} steps of {config['batch']} questions on "
        f"the same {config['clips']:,} simulated clips, as one frozen perception sees them, and "
        f"asked about {config['test_clips']:,} clips of everyday objects. The shipped model is "
        "trained longer and on more clips: rows compare with each other, not with its tables. "
        "*Turns* and *slides* are the open question in words, any answer may come; *all types* is "
        "the mean over the types of questions, *unseen wordings* the same in words no training "
        "held. *Weigh* is one pass that finds the answer among all of its kind, *write* the answer "
        "token by token, both on one thread without perception. `*` marks the size that ships.\n\n"
        f"{sizes_table(record)}\n\n{provenance(record)}\n"
    )


def sizes_table(record: RunRecord) -> str:
    """Return one row per size."""
    return markdown(COLUMNS, [_row(row) for row in record.numbers["rows"]])


def _row(row: dict[str, Any]) -> list[str]:
    shares = [f"{row[name]:.3f}" for name in ("rotation", "sliding", "seen", "held_out")]
    times = [
        f"{row[f'{name}_ms_{kind}']:.1f}"
        for name in ("weigh", "write")
        for kind in ("median", "p95")
    ]
    mark = " *" if row["is_shipped_size"] else ""
    return [row["name"] + mark, f"{row['parameters']:,}", *shares, *times]
