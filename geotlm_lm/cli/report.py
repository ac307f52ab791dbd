"""`geotlm-lm report`: write recorded numbers into the README, or check that they are there."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(help="Tables from recorded runs.", no_args_is_help=True)


@app.callback()
def report() -> None:
    """Tables from recorded runs."""


@app.command()
def readme(
    check: Annotated[
        bool, typer.Option("--check", help="Change nothing; fail if a number is out of date.")
    ] = False,
    path: Annotated[Path, typer.Option("--readme", help="The file to fill.")] = Path("README.md"),
    records: Annotated[Path, typer.Option(help="Folder of recorded runs.")] = Path(
        "reports/recorded"
    ),
) -> None:
    """Write the numbers of recorded runs into the README's blocks."""
    from geotlm_lm.reports.readme import check_readme, write_readme

    if check:
        check_readme(path, records)
        typer.echo(f"{path}: agrees with {records}")
        return
    changed = write_readme(path, records)
    typer.echo(f"{path}: {'updated' if changed else 'already up to date'}")
