"""The record of backbones of several sizes as one table."""

from __future__ import annotations

from typing import Any

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.tables import markdown, provenance

COLUMNS = ("backbone", "parameters", "kind", "amount", "motion missed", "ms, median", "p95")


def backbones_page(record: RunRecord) -> str:
    """Return the page: what was pretrained how, and the rows."""
    config = record.config
    return (
        "# How large a backbone has to be\n\n"
        f"Every row was pretrained for {config['steps']:,} steps of {config['batch']} clips on the "
        f"same {config['clips']:,} simulated clips, and judged by its own linear read-outs on "
        f"{config['test_clips']:,} clips of everyday objects. The shipped backbone is pretrained "
        "longer and on more clips: rows compare with each other, not with its tables. *Kind* is "
        "the share of clips whose kind of motion is told, *amount* that of turns and slides whose "
        "degrees or millimetres are told to within 2 degrees, 0.2 mm or a fifth, *motion missed* "
        "the median error of the displacement in contact over the displacement. Times are of the "
        "transformer alone, a clip at a time on one thread. `*` marks the size that ships.\n\n"
        f"{backbones_table(record)}\n\n{provenance(record)}\n"
    )


def backbones_table(record: RunRecord) -> str:
    """Return one row per size."""
    return markdown(COLUMNS, [_row(row) for row in record.numbers["rows"]])


def _row(row: dict[str, Any]) -> list[str]:
    shares = [f"{row[name]:.3f}" for name in ("kind", "amount", "missed")]
    times = [f"{row[name]:.1f}" for name in ("ms_median", "ms_p95")]
    mark = " *" if row["is_shipped_size"] else ""
    return [row["name"] + mark, f"{row['parameters']:,}", *shares, *times]
