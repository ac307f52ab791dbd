"""The record of real turns as other cameras would show them, as one table a set and a sentence."""

from __future__ import annotations

from typing import Any

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.tables import markdown, provenance

AS_RECORDED = "as recorded"

METHODS = {
    "language model, words": "words",
    "language model, words or lean": "words or lean",
    "linear probe on z": "probe on z*",
    "optical flow + rigid fit": "optical flow*",
}
"""Row of the comparison -> column; with a star it chooses between the two turns only."""

LEAST_SHOWN = 3
"""Cameras that the sentence names: those whose words are right least often."""


def cameras_page(record: RunRecord) -> str:
    """Return the page: how the clips were made, and a table for each set of recordings."""
    sets = sorted(record.numbers.items())
    tables = "\n\n".join(f"## {title}\n\n{_table(rows)}" for title, rows in sets)
    return (
        "# Real turns as other cameras would show them\n\n"
        "Windows of four frames of real recordings, forwards and backwards, evenly chosen among "
        "those of the main table. Each camera changes the frames and the idle gel alike, but for "
        "shaking and flicker, which the idle gel is free of; the turn stays what it was. *Words* "
        "choose among ten motions, and count as wrong where they are withheld; *wrong* is the "
        "share of clips of which they name another motion. Methods with a star choose between "
        "the two turns only. Simulated clips under damage that rises until nothing can be told "
        "are in [stability.md](stability.md).\n\n"
        f"{tables}\n\n{provenance(record)}\n"
    )


def cameras_headline(record: RunRecord) -> str:
    """Return how words and flow fare, as recorded and as other cameras show it, set by set."""
    said = [_said(title, rows) for title, rows in sorted(record.numbers.items())]
    return "\n".join(said) + f"\n\n{provenance(record)}"


def _said(title: str, rows: list[dict[str, Any]]) -> str:
    words, lean, _, flow = METHODS
    [told] = (row for row in rows if row["camera"] == AS_RECORDED)
    others = [row for row in rows if row is not told]
    least = sorted(others, key=lambda row: row[words])[:LEAST_SHOWN]
    named = ", ".join(f"{row['camera']} {row[words]:.3f}" for row in least)
    return (
        f"- {title}, {told['clips']} clips: words are right on {told[words]:.3f} as recorded and "
        f"on {_mean(others, words):.3f} on average as {len(others)} other cameras show it (least: "
        f"{named}), words or lean on {told[lean]:.3f} and {_mean(others, lean):.3f}, optical "
        f"flow, between two turns, on {told[flow]:.3f} and {_mean(others, flow):.3f}."
    )


def _mean(rows: list[dict[str, Any]], method: str) -> float:
    return sum(row[method] for row in rows) / len(rows)


def _table(rows: list[dict[str, Any]]) -> str:
    return markdown(
        ["camera", "clips", *METHODS.values(), "wrong"],
        [
            [row["camera"], str(row["clips"]), *(f"{row[one]:.3f}" for one in (*METHODS, "wrong"))]
            for row in rows
        ],
    )
