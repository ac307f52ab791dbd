"""What every command that writes a record does: name itself, and replace nothing but a record."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterable
from pathlib import Path

from geotlm_lm.cli.options import require_writable_file
from geotlm_lm.core.errors import UsageError


def command_line() -> str:
    """Return the command as a user would type it, whatever started the interpreter."""
    return shlex.join(["geotlm-lm", *sys.argv[1:]])


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
