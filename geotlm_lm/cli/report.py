"""`geotlm-lm report`: write recorded numbers into the README, or check that they are there."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from geotlm_lm.cli.options import (
    BundleFolder,
    RecordPath,
    Seed,
    path_of,
    require_writable,
)
from geotlm_lm.cli.protocols import protocols
from geotlm_lm.cli.recorded import command_line, require_record_file
from geotlm_lm.cli.report_language import language, transcript
from geotlm_lm.cli.report_model import cameras, model_stability, odometry, runtime
from geotlm_lm.cli.report_outside import fuzz, page
from geotlm_lm.cli.report_simulator import closed_forms, optics, simulator, simulator_stability
from geotlm_lm.cli.report_sizes import backbones, sizes

EXAMPLE_CLIP = Path("app/examples/bottle_cap_clockwise.npz")
EXAMPLE_QUESTION = "Which way is the cap turning?"

app = typer.Typer(help="Tables from recorded runs.", no_args_is_help=True)
app.command()(protocols)
app.command()(runtime)
app.command()(odometry)
app.command()(cameras)
app.command()(sizes)
app.command()(backbones)
app.command()(simulator)
app.command()(optics)
app.command()(closed_forms)
app.command()(language)
app.command()(fuzz)
app.command()(transcript)
app.command()(page)


@app.callback()
def report() -> None:
    """Tables from recorded runs."""


@app.command()
def readme(
    check: Annotated[
        bool, typer.Option("--check", help="Change nothing; fail if a number is out of date.")
    ] = False,
    path: Annotated[
        Path, typer.Option("--readme", parser=path_of, metavar="<path>", help="The file to fill.")
    ] = Path("README.md"),
    records: Annotated[
        Path, typer.Option(parser=path_of, metavar="<path>", help="Folder of recorded runs.")
    ] = Path("reports/recorded"),
) -> None:
    """Write the numbers of recorded runs into the README's blocks.

    Example: geotlm-lm report readme --check
    """
    from geotlm_lm.reports.readme import check_readme, write_readme

    if check:
        check_readme(path, records)
        typer.echo(f"{path}: agrees with {records}")
        return
    changed = write_readme(path, records)
    typer.echo(f"{path}: {'updated' if changed else 'already up to date'}")


@app.command()
def confusions(
    records: Annotated[
        Path,
        typer.Option("--record", parser=path_of, metavar="<path>", help="The recorded evaluation."),
    ] = Path("reports/recorded/evaluate.json"),
    out: Annotated[
        Path | None,
        typer.Option(
            parser=path_of,
            metavar="<path>",
            help="Folder of the pictures. [default: beside the page that shows them]",
        ),
    ] = None,
) -> None:
    """Draw who is taken for whom, a picture per table of a recorded evaluation.

    Example: geotlm-lm report confusions
    """
    from geotlm_lm.core.errors import UsageError
    from geotlm_lm.core.record import RunRecord
    from geotlm_lm.reports.confusions import FOLDER, draw_confusions

    if not records.is_file():
        raise UsageError(
            f"{records}: no such record; write it with `geotlm-lm evaluate --out {records}`."
        )
    folder = records.parent.parent / FOLDER if out is None else out
    require_writable(folder, "--out")
    for path in draw_confusions(RunRecord.load(records), folder):
        typer.echo(path)


@app.command()
def answer(
    clip: Annotated[
        Path, typer.Option(parser=path_of, metavar="<path>", help="The recording to ask about.")
    ] = EXAMPLE_CLIP,
    question: Annotated[str, typer.Option("--q", help="The question.")] = EXAMPLE_QUESTION,
    out: RecordPath = Path("reports/recorded/answer.json"),
) -> None:
    """Ask the command line in fresh processes; record the answer and the cold start.

    Example: geotlm-lm report answer --clip clip.npz --q 'Which way does it turn?'
    """
    from geotlm_lm.experiments.cold_answer import cold_answer

    require_record_file(out, "--out")
    record = cold_answer(clip, question, command=command_line())
    record.save(out)
    seconds = record.numbers["cold_s"]
    typer.echo(
        f"{record.numbers['answer']['text']} "
        f"(cold: median {seconds[len(seconds) // 2]:.2f} s, {seconds[0]:.2f}-{seconds[-1]:.2f} s)"
    )


@app.command()
def stability(
    is_simulator: Annotated[
        bool, typer.Option("--simulator", help="Stiff scenes of the simulator, without the model.")
    ] = False,
    clips: Annotated[
        int, typer.Option(min=1, help="Simulated clips of every level of damage.")
    ] = 60,
    seed: Seed = 0,
    model: BundleFolder = None,
    out: Annotated[
        Path | None,
        typer.Option(
            parser=path_of,
            metavar="<path>",
            help="The record, as JSON. [default: reports/recorded/stability.json]",
        ),
    ] = None,
    table: Annotated[
        Path | None,
        typer.Option(
            parser=path_of,
            metavar="<path>",
            help="The table, as Markdown. [default: reports/stability.md]",
        ),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(
            parser=path_of,
            metavar="<path>",
            help="Also draw the model's figure here; needs matplotlib.",
        ),
    ] = None,
) -> None:
    """Put the model under stress, or with --simulator the contact solver; write what came of it.

    Example: geotlm-lm report stability --figure reports/stability.png
    """
    name = "simulator_stability" if is_simulator else "stability"
    out, table = out or Path(f"reports/recorded/{name}.json"), table or Path(f"reports/{name}.md")
    if is_simulator:
        simulator_stability(out, table)
    else:
        model_stability(model, clips, seed, out, table, figure)
