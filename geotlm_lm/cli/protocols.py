"""`geotlm-lm report protocols`: the paper's tables on simulated clips, beside its own figures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geotlm_lm.cli.options import (
    BundleFolder,
    EncoderHeads,
    EncoderName,
    EncoderWeights,
    Seed,
    path_of,
    require_one_model,
    require_writable,
    require_writable_file,
)
from geotlm_lm.cli.recorded import command_line, require_record_file

if TYPE_CHECKING:
    from geotlm_lm.backbone.tokens import Backbone
    from geotlm_lm.core.record import RunRecord

RECORD, PAGE = Path("reports/recorded/protocols.json"), Path("reports/protocols.md")
"""Where a whole run of the embedded backbone is recorded."""


Clips = Annotated[
    int, typer.Option(min=2, help="Simulated clips of each of 12 objects, in each task.")
]
Epochs = Annotated[int, typer.Option(min=1, help="Epochs of every training.")]
Only = Annotated[
    list[str] | None,
    typer.Option(help="One table: rotation, sliding, ablation or frames. [default: all]"),
]
RunFolder = Annotated[
    Path,
    typer.Option(
        parser=path_of,
        metavar="<path>",
        help="Tokens and finished folds are kept here, to continue from.",
    ),
]
Out = Annotated[
    Path | None,
    typer.Option(
        parser=path_of,
        metavar="<path>",
        help=f"Where the record goes, as JSON. [default: {RECORD} for all tables of the embedded "
        f"backbone, else nowhere]",
    ),
]
Table = Annotated[
    Path | None,
    typer.Option(
        parser=path_of,
        metavar="<path>",
        help=f"Where the page goes, as Markdown. [default: {PAGE} likewise]",
    ),
]


def protocols(
    clips: Clips = 100,
    epochs: Epochs = 30,
    only: Only = None,
    seed: Seed = 42,
    model: BundleFolder = None,
    encoder: EncoderName = None,
    weights: EncoderWeights = None,
    heads: EncoderHeads = None,
    run_folder: RunFolder = Path("runs/protocols"),
    out: Out = None,
    table: Table = None,
) -> None:
    """Run the paper's protocols: five-fold and leave-one-object-out, with its ablations.

    Clips of everyday objects are encoded once by the frozen backbone and kept; a run that was
    stopped continues.

    Example: geotlm-lm report protocols --only rotation
    """
    require_one_model(model, weights, encoder, heads)
    if not only and model is None and weights is None:
        out, table = out or RECORD, table or PAGE
    if out is not None:
        require_record_file(out, "--out")
    if table is not None:
        require_writable_file(table, "--table")
    require_writable(run_folder, "--run-folder")
    from geotlm_lm.cli.progress import progress_on_stderr
    from geotlm_lm.experiments.protocol_rows import TABLES
    from geotlm_lm.experiments.protocols import ProtocolSizes, run_protocols
    from geotlm_lm.reports.protocols import protocol_tables
    from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS

    backbone, name, about = _backbone(model, weights, encoder, heads)
    record = run_protocols(
        backbone,
        ProtocolSizes(tuple(EVERYDAY_OBJECTS), clips, epochs, seed),
        folder=run_folder,
        tables=tuple(dict.fromkeys(only or TABLES)),
        backbone_name=name,
        about=about,
        command=command_line(),
        progress=progress_on_stderr(""),
    )
    _write(record, out, table)
    typer.echo(protocol_tables(record))


def _backbone(
    model: Path | None, weights: Path | None, encoder: str | None, heads: int | None
) -> tuple[Backbone, str, dict[str, Any]]:
    """Return the frozen backbone, what the record calls it, and what else it says of it."""
    if weights is None:
        from geotlm_lm.checkpoint import load_bundle

        name = "embedded" if model is None else model.name
        return load_bundle(model).model.backbone, name, {}
    import torch

    from geotlm_lm.backbone.released import load_encoder

    released = load_encoder(weights, encoder, heads=heads)
    released.to("cuda" if torch.cuda.is_available() else "cpu")
    return released, released.adapter.title, {"encoder": released.describe()}


def _write(record: RunRecord, out: Path | None, table: Path | None) -> None:
    from geotlm_lm.core.atomic import write_text_atomically
    from geotlm_lm.reports.protocols import protocols_page

    if out is not None:
        record.save(out)
    if table is not None:
        write_text_atomically(table, protocols_page(record))
