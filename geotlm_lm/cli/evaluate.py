"""`geotlm-lm evaluate`: judge the model beside its references and print the tables."""

from __future__ import annotations

import json
import shlex
import sys
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from geotlm_lm.cli.options import Seed, require_writable_file

REPORT_EVERY_S = 2.0
"""A wait longer than this shows how far it is."""


def evaluate(
    real: Annotated[
        Path | None,
        typer.Option(help="Folder of labelled recordings (clips and a CSV of windows) to add."),
    ] = None,
    clips: Annotated[
        int, typer.Option(min=0, help="Simulated clips per task; 0 leaves simulation out.")
    ] = 120,
    seed: Seed = 0,
    model: Annotated[
        Path | None, typer.Option(help="Model bundle; the one in the package when not given.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Write the record here, as JSON.")] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="End with the record as one line of JSON.")
    ] = False,
    min_accuracy: Annotated[
        float | None,
        typer.Option(
            min=0, max=1, help="Exit 6 if the model's own words fall below this in any table."
        ),
    ] = None,
) -> None:
    """Judge the model on clips it has never seen, beside linear probes and optical flow."""
    from geotlm_lm.core.errors import BelowMinimum, UsageError

    if clips == 0 and real is None:
        raise UsageError("nothing to judge: give --clips above 0, or --real with a folder.")
    if out is not None:
        require_writable_file(out, "--out")
    from geotlm_lm.answering import Answerer
    from geotlm_lm.experiments.evaluate import evaluate as run
    from geotlm_lm.reports.tables import evaluation_tables

    record = run(
        Answerer.load(model),
        clips_per_task=clips,
        seed=seed,
        real_folder=real,
        model_name="embedded" if model is None else model.name,
        command=command_line(sys.argv),
        progress=progress_on_stderr(),
    )
    if out is not None:
        record.save(out)
    typer.echo(evaluation_tables(record), nl=False)
    if as_json:
        typer.echo(json.dumps(asdict(record)))
    worst = record.numbers["minimum"]
    if min_accuracy is not None and worst < min_accuracy:
        raise BelowMinimum(
            f"the lowest accuracy of the model's words is {worst:.3f}, expected at least "
            f"{min_accuracy:g}; see the tables above."
        )


def command_line(arguments: list[str]) -> str:
    """Return the command as a user would type it, whatever started the interpreter."""
    return shlex.join(["geotlm-lm", *arguments[1:]])


def progress_on_stderr() -> Callable[[str, int, int], None]:
    """Return a progress report that prints at most every `REPORT_EVERY_S`, and at each end."""
    last = time.monotonic()

    def report(what: str, done: int, total: int) -> None:
        nonlocal last
        now = time.monotonic()
        if done == total or now - last > REPORT_EVERY_S:
            last = now
            typer.echo(f"{what}: {done} of {total} clips", err=True)

    return report
