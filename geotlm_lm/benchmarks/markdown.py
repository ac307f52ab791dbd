"""Markdown tables that read as plain text too."""

from __future__ import annotations

from collections.abc import Sequence


def markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table padded so that it reads as plain text too.

    The first column is set left, all others right.
    """
    cells = [list(header), *(list(row) for row in rows)]
    # A rule cell needs a dash beside its colon.
    widths = [max(2, *(len(line[column]) for line in cells)) for column in range(len(header))]

    def line(values: Sequence[str]) -> str:
        first = values[0].ljust(widths[0])
        others = [value.rjust(width) for value, width in zip(values[1:], widths[1:], strict=True)]
        return "| " + " | ".join([first, *others]) + " |"

    rule = "| " + " | ".join(["-" * widths[0], *("-" * (w - 1) + ":" for w in widths[1:])]) + " |"
    return "\n".join([line(cells[0]), rule, *(line(row) for row in cells[1:])])
