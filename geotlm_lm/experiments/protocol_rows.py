"""The rows of the paper's tables: what each reads, and which of them stand in which table."""

from __future__ import annotations

from dataclasses import dataclass

from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.dgr.ablations import DGRParts
from geotlm_lm.training.folds import Recipe

FLOW = "optical flow + rigid fit"
CURL = "Curl + LR"
PLAIN = "probe on c"
PAPER = "DGR, paper"
GROUNDED = "DGR, grounded"
NO_MASK = "DGR, region pool only"
NO_REGIONS = "DGR, contact mask only"
NEITHER = "DGR, neither"
OPERATORS = "DGR, differential operators on"
PLAIN_PAIR = "probe on c, 2 frames"
PAPER_PAIR = "DGR, paper, 2 frames"


@dataclass(frozen=True)
class Row:
    """One method.

    Args:
        recipe: What is trained on frozen tokens; None for a classical reference.
        frames: Frames the backbone is given.
    """

    recipe: Recipe | None = None
    frames: int = FRAME_COUNT


ROWS: dict[str, Row] = {
    FLOW: Row(),
    CURL: Row(),
    PLAIN: Row(Recipe()),
    PAPER: Row(Recipe(DGRParts())),
    GROUNDED: Row(Recipe(DGRParts(), "grounded")),
    NO_MASK: Row(Recipe(DGRParts(mask=False))),
    NO_REGIONS: Row(Recipe(DGRParts(regions=False))),
    NEITHER: Row(Recipe(DGRParts(regions=False, mask=False))),
    OPERATORS: Row(Recipe(DGRParts(operators=True))),
    PLAIN_PAIR: Row(Recipe(), frames=2),
    PAPER_PAIR: Row(Recipe(DGRParts()), frames=2),
}
"""Every row by its name."""

TABLES: dict[str, tuple[str, ...]] = {
    "rotation": (CURL, FLOW, PLAIN, PAPER, GROUNDED),
    "sliding": (FLOW, PLAIN, PAPER, GROUNDED),
    "ablation": (PLAIN, NEITHER, NO_MASK, NO_REGIONS, PAPER, OPERATORS),
    "frames": (PLAIN_PAIR, PLAIN, PAPER_PAIR, PAPER),
}
"""Rows of each table, in its order."""

TASKS_OF: dict[str, tuple[str, ...]] = {
    "rotation": ("rotation",),
    "sliding": ("sliding",),
    "ablation": ("rotation", "sliding"),
    "frames": ("rotation", "sliding"),
}
"""Tasks of each table."""

CONTRASTS = (
    (PAPER, PLAIN),
    (PAPER, GROUNDED),
    (PAPER, FLOW),
    (PAPER, CURL),
    (NO_MASK, PAPER),
    (NO_REGIONS, PAPER),
    (NEITHER, PAPER),
    (OPERATORS, PAPER),
    (PLAIN_PAIR, PLAIN),
    (PAPER_PAIR, PAPER),
    (PAPER_PAIR, PLAIN_PAIR),
)
"""Pairs of rows whose difference is taken clip by clip."""


def rows_of(tables: tuple[str, ...], task: str, *, has_truth: bool) -> tuple[str, ...]:
    """Return the rows that some tables show of a task, each once.

    Args:
        tables: Names in `TABLES`.
        task: "rotation" or "sliding".
        has_truth: Whether the true displacement is known; the grounded row needs it.
    """
    shown = [TABLES[name] for name in tables if task in TASKS_OF[name]]
    names = dict.fromkeys(row for rows in shown for row in rows)
    return tuple(name for name in names if has_truth or name != GROUNDED)
