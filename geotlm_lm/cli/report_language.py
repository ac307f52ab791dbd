"""`geotlm-lm report language` and `transcript`: all the model can be asked, and fresh questions."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from geotlm_lm.cli.options import AsJson, BundleFolder, RecordPath, Seed, path_of
from geotlm_lm.cli.recorded import command_line, require_all_writable


def language(
    real: Annotated[
        Path | None,
        typer.Option(
            parser=path_of,
            metavar="<path>",
            help="Folder of labelled recordings to ask about as well.",
        ),
    ] = None,
    clips: Annotated[
        int, typer.Option(min=0, help="Simulated clips; 0 leaves simulation out.")
    ] = 120,
    windows: Annotated[
        int, typer.Option(min=1, help="With --real: windows of each folder, played both ways.")
    ] = 50,
    seed: Seed = 0,
    model: BundleFolder = None,
    out: RecordPath = Path("reports/recorded/language.json"),
    table: Annotated[
        Path,
        typer.Option(parser=path_of, metavar="<path>", help="Where the tables go, as Markdown."),
    ] = Path("reports/language.md"),
    as_json: AsJson = False,
) -> None:
    """Ask every type of question about clips nothing was trained on, and grade the answers.

    Example: geotlm-lm report language --real DIR
    """
    from geotlm_lm.cli.progress import progress_on_stderr
    from geotlm_lm.core.atomic import write_text_atomically
    from geotlm_lm.core.errors import UsageError
    from geotlm_lm.core.record import RunRecord

    if clips == 0 and real is None:
        raise UsageError("nothing to ask about: give --clips above 0, or --real with a folder.")
    require_all_writable(out, table)
    from geotlm_lm.answering import Answerer
    from geotlm_lm.experiments.language_talk import evaluate_talk
    from geotlm_lm.reports.language import language_page, language_tables

    record = evaluate_talk(
        Answerer.load(model),
        clips=clips,
        seed=seed,
        real_folder=real,
        windows=windows,
        model_name="embedded" if model is None else model.name,
        command=command_line(),
        progress=progress_on_stderr(),
    )
    record.save(out)
    # As it is read back: the page must be the one that `report readme` makes of the file.
    record = RunRecord.load(out)
    write_text_atomically(table, language_page(record))
    typer.echo(json.dumps(asdict(record)) if as_json else language_tables(record), nl=as_json)


def transcript(
    model: BundleFolder = None,
    out: RecordPath = Path("reports/recorded/transcript.json"),
    table: Annotated[
        Path,
        typer.Option(
            parser=path_of, metavar="<path>", help="Where the transcript goes, as Markdown."
        ),
    ] = Path("reports/transcript.md"),
) -> None:
    """Ask questions that nobody wrote a template for; write down what was said.

    Example: geotlm-lm report transcript
    """
    from geotlm_lm.core.atomic import write_text_atomically
    from geotlm_lm.core.record import RunRecord

    require_all_writable(out, table)
    from geotlm_lm.answering import Answerer
    from geotlm_lm.experiments.transcript import transcript as ask_all
    from geotlm_lm.reports.transcript import transcript_page

    record = ask_all(
        Answerer.load(model),
        model_name="embedded" if model is None else model.name,
        command=command_line(),
    )
    record.save(out)
    # As it is read back: the page must be the one that `report readme` makes of the file.
    record = RunRecord.load(out)
    write_text_atomically(table, transcript_page(record))
    typer.echo(f"{record.numbers['as_wanted']} of {record.numbers['questions']} as wanted: {table}")
