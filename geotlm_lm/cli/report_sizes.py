"""What `geotlm-lm report` measures of model sizes: each function trains, judges and saves."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from geotlm_lm.cli.options import (
    BundleFolder,
    RecordPath,
    Seed,
    TablePath,
    path_of,
    require_writable,
)
from geotlm_lm.cli.recorded import command_line, require_all_writable, save_page

Clips = Annotated[int, typer.Option(min=100, help="Simulated clips to learn from.")]
TestClips = Annotated[int, typer.Option(min=20, help="Clips to be asked about.")]
Workers = Annotated[int, typer.Option(min=1, help="Processes that simulate.")]
RunFolder = Annotated[
    Path,
    typer.Option(
        parser=path_of,
        metavar="<path>",
        help="Keeps clips and checkpoints; a stopped run continues there.",
    ),
]


def sizes(
    clips: Clips = 8_000,
    test_clips: TestClips = 500,
    steps: Annotated[int, typer.Option(min=1, help="Steps of every language model.")] = 2_000,
    workers: Workers = 2,
    seed: Seed = 0,
    model: BundleFolder = None,
    run_folder: RunFolder = Path("runs/sizes"),
    out: RecordPath = Path("reports/recorded/sizes.json"),
    table: TablePath = Path("reports/sizes.md"),
) -> None:
    """Train language models of several sizes on one perception: error against run time.

    Example: geotlm-lm report sizes
    """
    require_all_writable(out, table)
    require_writable(run_folder, "--run-folder")
    from geotlm_lm.answering import Answerer
    from geotlm_lm.experiments.sizes import Budget, compare_sizes
    from geotlm_lm.reports.sizes import sizes_page, sizes_table

    record = compare_sizes(
        Answerer.load(model),
        folder=run_folder,
        budget=Budget(clips, test_clips, steps),
        seed=seed,
        workers=workers,
        command=command_line(),
    )
    save_page(record, out, table, sizes_page(record))
    typer.echo(sizes_table(record))


def backbones(
    clips: Clips = 8_000,
    test_clips: TestClips = 500,
    steps: Annotated[int, typer.Option(min=1, help="Steps of every backbone.")] = 600,
    workers: Workers = 2,
    seed: Seed = 0,
    run_folder: RunFolder = Path("runs/sizes"),
    out: RecordPath = Path("reports/recorded/backbones.json"),
    table: TablePath = Path("reports/backbones.md"),
) -> None:
    """Pretrain backbones of several sizes on the same clips: error against run time.

    Example: geotlm-lm report backbones
    """
    require_all_writable(out, table)
    require_writable(run_folder, "--run-folder")
    from geotlm_lm.experiments.backbones import BackboneBudget, compare_backbones
    from geotlm_lm.reports.backbones import backbones_page, backbones_table

    record = compare_backbones(
        folder=run_folder,
        budget=BackboneBudget(clips, test_clips, steps),
        seed=seed,
        workers=workers,
        command=command_line(),
    )
    save_page(record, out, table, backbones_page(record))
    typer.echo(backbones_table(record))
