"""What every report command does: try where it writes, tell how far it is, save what it made."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from geotlm_lm.cli.options import require_writable_file

if TYPE_CHECKING:
    from geotlm_lm.core.record import RunRecord


def command_line() -> str:
    """Return the command as a user would type it, whatever started the interpreter."""
    return shlex.join(["geotlm-lm", *sys.argv[1:]])


def require_all_writable(out: Path, table: Path, figure: Path | None = None) -> None:
    """Create the folders of all, so that a place that cannot be written is told first.

    Raises:
        UsageError: If one cannot be written.
    """
    for path, option in ((out, "--out"), (table, "--table"), (figure, "--figure")):
        if path is not None:
            require_writable_file(path, option)


def save_page(record: RunRecord, out: Path, table: Path, page: str) -> None:
    """Write the record as JSON and its page as Markdown."""
    from geotlm_lm.core.atomic import write_text_atomically

    record.save(out)
    write_text_atomically(table, page)


def show(what: str, done: int, total: int) -> None:
    """Tell on stderr how far a run is."""
    typer.echo(f"{what}: {done} of {total}", err=True)
