"""`geotlm-lm report simulator | optics | closed-forms | stability --simulator`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from geotlm_lm.cli.options import RecordPath, Seed, TablePath, path_of
from geotlm_lm.cli.recorded import command_line, require_all_writable, save_page, show


def simulator(
    out: RecordPath = Path("reports/recorded/simulator.json"),
    table: TablePath = Path("reports/simulator.md"),
    figure: Annotated[
        Path | None,
        typer.Option(
            parser=path_of, metavar="<path>", help="Also draw the figure here; needs matplotlib."
        ),
    ] = None,
) -> None:
    """Hold every preset's error against its run time, beside what a user might take instead.

    Example: geotlm-lm report simulator --figure reports/simulator.png
    """
    import time

    from geotlm_lm.core.threads import usable_cores
    from geotlm_lm.experiments.evaluate import one_thread
    from geotlm_lm.experiments.simulator_error import simulator_error
    from geotlm_lm.experiments.simulator_omissions import omission_rows
    from geotlm_lm.experiments.simulator_rate import simulator_rates
    from geotlm_lm.reports.simulator import draw_error, simulator_page

    require_all_writable(out, table, figure)
    begun = time.perf_counter()
    with one_thread():
        record = simulator_error(command=command_line(), progress=show)
        numbers = record.numbers | {"omissions": omission_rows(progress=show)}
    numbers["rates"] = simulator_rates(workers=usable_cores(), progress=show)
    record = replace(record, numbers=numbers, seconds=time.perf_counter() - begun)
    page = simulator_page(record)
    save_page(record, out, table, page)
    typer.echo(page)
    if figure is not None:
        draw_error(record, figure)


def simulator_stability(out: Path, table: Path) -> None:
    """Put the contact solver under stress and write what came of it."""
    from geotlm_lm.experiments import simulator_stability as experiment
    from geotlm_lm.experiments.evaluate import one_thread
    from geotlm_lm.reports.simulator import simulator_stability_page

    require_all_writable(out, table)
    with one_thread():
        record = experiment.simulator_stability(command=command_line(), progress=show)
    page = simulator_stability_page(record)
    save_page(record, out, table, page)
    typer.echo(page)


def optics(
    real: Annotated[
        Path,
        typer.Option(
            parser=path_of,
            metavar="<path>",
            help="Folder of real images: calibration/ and physiclear/.",
        ),
    ],
    clips: Annotated[int, typer.Option(min=1, help="Simulated clips.")] = 600,
    seed: Seed = 0,
    out: RecordPath = Path("reports/recorded/optics.json"),
    table: TablePath = Path("reports/optics.md"),
) -> None:
    """Hold the simulator's images against real ones, statistic by statistic.

    Example: geotlm-lm report optics --real DIR
    """
    from geotlm_lm.cli.progress import progress_on_stderr
    from geotlm_lm.experiments.evaluate import one_thread
    from geotlm_lm.experiments.optics import compare_optics
    from geotlm_lm.reports.optics import optics_report, verdict

    require_all_writable(out, table)
    with one_thread():
        record = compare_optics(
            real,
            clips=clips,
            seed=seed,
            command=command_line(),
            progress=progress_on_stderr(),
        )
    save_page(record, out, table, optics_report(record))
    typer.echo(verdict(record))


def closed_forms(
    out: RecordPath = Path("reports/recorded/closed_forms.json"),
    table: TablePath = Path("reports/closed_forms.md"),
) -> None:
    """Hold the contact solver against every closed form, with its order of convergence.

    Example: geotlm-lm report closed-forms
    """
    from geotlm_lm.experiments import closed_forms as experiment
    from geotlm_lm.experiments.evaluate import one_thread
    from geotlm_lm.reports.simulator import closed_forms_page

    require_all_writable(out, table)
    with one_thread():
        record = experiment.closed_forms(command=command_line(), progress=show)
    page = closed_forms_page(record)
    save_page(record, out, table, page)
    typer.echo(page)
