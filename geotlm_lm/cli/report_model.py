"""What `geotlm-lm report` measures of the model: each function runs and saves one report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from geotlm_lm.cli.options import BundleFolder, RealFolder, RecordPath, Seed, TablePath, path_of
from geotlm_lm.cli.recorded import command_line, require_all_writable, save_page, show


def model_stability(
    model: Path | None, clips: int, seed: int, out: Path, table: Path, figure: Path | None
) -> None:
    """Put the model under stress and write down what came of it."""
    from geotlm_lm.answering import Answerer
    from geotlm_lm.experiments.evaluate import one_thread
    from geotlm_lm.experiments.model_stability import model_stability as run
    from geotlm_lm.reports.stability import draw_fall, stability_page, summary

    require_all_writable(out, table, figure)
    with one_thread():
        record = run(
            Answerer.load(model),
            seed=seed,
            clips=clips,
            command=command_line(),
            progress=show,
        )
    save_page(record, out, table, stability_page(record))
    if figure is not None:
        draw_fall(record, figure)
    typer.echo(summary(record))


def runtime(
    real: RealFolder = None,
    size: Annotated[
        str, typer.Option(help="default, or tiny to see that it runs; tiny proves nothing.")
    ] = "default",
    seed: Seed = 0,
    model: BundleFolder = None,
    out: RecordPath = Path("reports/recorded/runtime.json"),
    table: Annotated[
        Path,
        typer.Option(parser=path_of, metavar="<path>", help="Where the tables go, as Markdown."),
    ] = Path("reports/runtime.md"),
    figure: Annotated[
        Path | None,
        typer.Option(
            parser=path_of, metavar="<path>", help="Also draw the figure here; needs matplotlib."
        ),
    ] = None,
) -> None:
    """Hold every way to name a motion, error against run time; say what to pick for which use.

    Times mean something on an idle machine only.

    Example: geotlm-lm report runtime --real DIR --figure reports/runtime.png
    """
    from geotlm_lm.answering import Answerer
    from geotlm_lm.core.errors import UsageError
    from geotlm_lm.experiments.runtime import SIZES
    from geotlm_lm.experiments.runtime import runtime as run
    from geotlm_lm.reports.runtime import draw_runtime, pick_table, runtime_page

    if size not in SIZES:
        raise UsageError(f"--size '{size[:40]}' is unknown, expected {' or '.join(SIZES)}.")
    require_all_writable(out, table, figure)
    record = run(
        Answerer.load(model),
        sizes=SIZES[size],
        seed=seed,
        real_folder=real,
        model=model,
        command=command_line(),
        progress=show,
    )
    save_page(record, out, table, runtime_page(record))
    if figure is not None:
        draw_runtime(record, figure)
    typer.echo(pick_table(record))


def cameras(
    real: Annotated[
        Path, typer.Option(parser=path_of, metavar="<path>", help="Folder of labelled recordings.")
    ],
    clips: Annotated[int, typer.Option(min=2, help="Windows of each set at most.")] = 200,
    seed: Seed = 0,
    model: BundleFolder = None,
    out: RecordPath = Path("reports/recorded/cameras.json"),
    table: TablePath = Path("reports/cameras.md"),
) -> None:
    """Ask which way real turns go, shown as other cameras would, beside optical flow.

    Example: geotlm-lm report cameras --real DIR
    """
    from geotlm_lm.answering import Answerer
    from geotlm_lm.experiments.other_cameras import other_cameras
    from geotlm_lm.reports.cameras import cameras_headline, cameras_page

    require_all_writable(out, table)
    record = other_cameras(
        Answerer.load(model),
        real,
        clips=clips,
        seed=seed,
        command=command_line(),
        progress=show,
    )
    save_page(record, out, table, cameras_page(record))
    typer.echo(cameras_headline(record))


def odometry(
    clips: Annotated[int, typer.Option(min=2, help="Simulated clips per task.")] = 300,
    real: RealFolder = None,
    seed: Seed = 0,
    model: BundleFolder = None,
    out: RecordPath = Path("reports/recorded/odometry.json"),
    table: TablePath = Path("reports/odometry.md"),
) -> None:
    """Hold how far clips are told to go against how far they went, beside optical flow.

    Example: geotlm-lm report odometry --real DIR
    """
    from geotlm_lm.answering import Answerer
    from geotlm_lm.experiments.how_far import how_far
    from geotlm_lm.reports.odometry import odometry_page, odometry_table

    require_all_writable(out, table)
    record = how_far(
        Answerer.load(model),
        clips=clips,
        seed=seed,
        real_folder=real,
        command=command_line(),
        progress=show,
    )
    save_page(record, out, table, odometry_page(record))
    typer.echo(odometry_table(record))
