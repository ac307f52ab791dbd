"""What every report command does: try where it writes, tell how far it is, save what it made."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from geotlm_lm.cli.options import require_writable_file
from geotlm_lm.core.errors import UsageError

if TYPE_CHECKING:
    from geotlm_lm.core.record import RunRecord


def command_line() -> str:
    """Return the command as a user would type it, whatever started the interpreter."""
    return shlex.join(["geotlm-lm", *sys.argv[1:]])


def require_all_writable(out: Path, table: Path, figure: Path | None = None) -> None:
    """Try to write in the folders of all, so that a place where it fails is told first.

    Raises:
        UsageError: If one cannot be written, or the record would replace something else.
    """
    require_record_file(out, "--out")
    for path, option in ((table, "--table"), (figure, "--figure")):
        if path is not None:
            require_writable_file(path, option)


def require_record_file(path: Path, option: str, *, inputs: Iterable[Path] = ()) -> None:
    """As `require_writable_file`; of files that are there, only an earlier record is replaced.

    Args:
        path: Of the record to write.
        option: That names it.
        inputs: Files that the command reads.

    Raises:
        UsageError: If it cannot be written, or holds something else.
    """
    from geotlm_lm.core.record import RunRecord, UnreadableRecord

    require_writable_file(path, option, inputs=inputs)
    if not path.exists() or path.stat().st_size == 0:
        return
    try:
        RunRecord.load(path)
    except UnreadableRecord as error:
        raise UsageError(
            f"{option}: {path} holds something else than a run's record and would be replaced, "
            f"expected a new file or an earlier record; give another name."
        ) from error


def save_page(record: RunRecord, out: Path, table: Path, page: str) -> None:
    """Write the record as JSON and its page as Markdown."""
    from geotlm_lm.core.atomic import write_text_atomically

    record.save(out)
    write_text_atomically(table, page)


def show(what: str, done: int, total: int) -> None:
    """Tell on stderr how far a run is."""
    typer.echo(f"{what}: {done} of {total}", err=True)
