"""The record of language models of several sizes as one table."""

from __future__ import annotations

from statistics import mean
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
    "verdicts, choices",
    "all others",
    "weigh, ms",
    "p95",
    "write, ms",
    "p95",
)

VERDICTS = ("T2", "T3", "T4", "T18")
"""Types in which a claim is confirmed, denied or chosen: what is asked has to be compared with what
is felt, and that is learnt last."""


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
        "held. *Verdicts, choices* are the types in which a claim is confirmed, denied or chosen "
        f"({', '.join(VERDICTS)}), which are learnt last: there rows differ in how far they had "
        "come; *all others* is the mean of the rest. *Weigh* is one pass that finds the answer "
        "among all of its kind, *write* the answer token by token, both on one thread without "
        "perception. `*` marks the size that ships.\n\n"
        f"{sizes_table(record)}\n\n{provenance(record)}\n"
    )


def sizes_table(record: RunRecord) -> str:
    """Return one row per size."""
    return markdown(COLUMNS, [_row(row) for row in record.numbers["rows"]])


def _row(row: dict[str, Any]) -> list[str]:
    seen = {name.split()[0]: share for name, share in row["by_type"].items() if "seen" in name}
    verdicts = [share for name, share in seen.items() if name in VERDICTS]
    others = [share for name, share in seen.items() if name not in VERDICTS]
    shares = [f"{row[name]:.3f}" for name in ("rotation", "sliding", "seen", "held_out")]
    shares += [f"{mean(part):.3f}" for part in (verdicts, others)]
    times = [
        f"{row[f'{name}_ms_{kind}']:.1f}"
        for name in ("weigh", "write")
        for kind in ("median", "p95")
    ]
    mark = " *" if row["is_shipped_size"] else ""
    return [row["name"] + mark, f"{row['parameters']:,}", *shares, *times]
