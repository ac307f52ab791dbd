"""Reports on what meets the outside world: damaged files, nonsense questions, people waiting."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from geotlm_lm.cli.options import RecordPath, Seed, TablePath, path_of
from geotlm_lm.cli.recorded import (
    command_line,
    require_all_writable,
    require_record_file,
    save_page,
    show,
)

if TYPE_CHECKING:
    from geotlm_lm.fuzzing.target import Prepare


def fuzz(
    minutes: Annotated[
        float, typer.Option(min=0.01, help="For all targets together, loading them not counted.")
    ] = 10.0,
    target: Annotated[
        list[str] | None, typer.Option(help="Only this one; may be repeated. [default: all]")
    ] = None,
    seed: Seed = 0,
    found: Annotated[
        Path,
        typer.Option(
            parser=path_of, metavar="<path>", help="Folder for inputs that did what none must."
        ),
    ] = Path("runs/fuzz"),
    out: RecordPath = Path("reports/recorded/fuzz.json"),
    table: TablePath = Path("reports/fuzz.md"),
) -> None:
    """Damage files and questions, guided by what they reach, and count what comes of it.

    Example: geotlm-lm report fuzz --minutes 30
    """
    from geotlm_lm.core.errors import BelowMinimum
    from geotlm_lm.fuzzing import run, targets
    from geotlm_lm.reports.fuzz import fuzz_page, verdict

    require_all_writable(out, table)
    record = run.fuzz(
        _chosen(target, targets.TARGETS),
        60 * minutes,
        found,
        seed=seed,
        command=command_line(),
        progress=show,
    )
    save_page(record, out, table, fuzz_page(record))
    typer.echo(verdict(record))
    if record.numbers["findings"]:
        raise BelowMinimum(
            f"Fuzzing found something ({len(record.numbers['findings'])} kinds, listed in "
            f"{table}); the inputs lie in {found}."
        )


def page(
    pictures: Annotated[
        Path | None,
        typer.Option(
            parser=path_of,
            metavar="<path>",
            help="Folder to draw the page's pictures into. [default: none]",
        ),
    ] = None,
    out: RecordPath = Path("reports/recorded/page.json"),
) -> None:
    """Time what a person waits for at the page, in a real browser, and twenty programs at once.

    Example: geotlm-lm report page --pictures reports
    """
    import time
    from importlib import import_module

    from geotlm_lm.cli.app import page_package
    from geotlm_lm.core.record import RunRecord
    from geotlm_lm.reports.page import page_times

    require_record_file(out, "--out")
    began = time.perf_counter()
    numbers = import_module(f"{page_package()}.tour").tour(pictures)
    seconds = time.perf_counter() - began
    record = RunRecord("page", command_line(), 0, seconds, numbers)
    record.save(out)
    typer.echo(page_times(record))


def _chosen(names: list[str] | None, targets: Mapping[str, Prepare]) -> dict[str, Prepare]:
    from geotlm_lm.core.errors import UsageError

    if unknown := sorted(set(names or ()) - set(targets)):
        raise UsageError(
            f"There is no fuzzing target '{unknown[0]}', expected one of {', '.join(targets)}."
        )
    return {name: targets[name] for name in names or targets}
