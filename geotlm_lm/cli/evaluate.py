"""`geotlm-lm evaluate`: judge the model beside its references and print the tables."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import typer

from geotlm_lm.cli.options import (
    BundleFolder,
    DataSets,
    Encoder,
    Seed,
    command_line,
    grouped,
    option,
    require_record_file,
    require_writable,
)
from geotlm_lm.cli.progress import progress_on_stderr
from geotlm_lm.core.errors import BelowMinimum, UsageError


@grouped
def evaluate(
    *,
    real: Path | None = option(
        "Folder of labelled recordings (clips and a CSV of windows) to add."
    ),
    data: DataSets = None,
    clips: int = option("Simulated clips per task; 0 leaves simulation out.", default=120, min=0),
    seed: Seed = 0,
    model: BundleFolder = None,
    out: Path | None = option("Write the record here, as JSON."),
    as_json: bool = option("End with the record as one line of JSON.", "--json", default=False),
    min_accuracy: float | None = option(
        "Exit 6 if the model's own words fall below this in any table.", min=0, max=1
    ),
    encoder: Encoder,
    run_folder: Path | None = option(
        "With --weights: tokens and heads are kept here, to continue from. [default: runs/encoder]"
    ),
    preset: str | None = option(
        "With --weights: smoke or default, how long the encoder's heads learn. [default: default]"
    ),
) -> None:
    """Judge the model on clips it has never seen, beside linear probes, optical flow and alignment.

    With --weights, a released encoder takes the place of the embedded one: DGR, probe and language
    model are first trained on simulated clips as it sees them.
    """
    if clips == 0 and real is None and not data:
        raise UsageError("nothing to judge: give --clips above 0, --real with a folder, or --data.")
    weights = encoder.weights
    encoder.require_alone(model)
    if weights is None and (preset is not None or run_folder is not None):
        raise UsageError("--preset and --run-folder need --weights with the encoder's file.")
    if out is not None:
        require_record_file(out, "--out", inputs=_inputs(real, data or (), weights))
    from geotlm_lm.answering import Answerer

    name, about = "embedded" if model is None else model.name, {}
    if weights is None:
        answerer = Answerer.load(model)
    else:
        folder, chosen = run_folder or Path("runs/encoder"), "default" if preset is None else preset
        name, bundle = _trained_on(encoder, chosen, folder, seed)
        answerer, about = Answerer(bundle), {"encoder": bundle.provenance}
    from geotlm_lm.benchmarks.benches import EVALUATION, run_bench
    from geotlm_lm.benchmarks.harness import Run, rows_of
    from geotlm_lm.benchmarks.rendering import page
    from geotlm_lm.benchmarks.variants import GENERATED

    what = {"seed": seed, "clips": clips, "real": real, "data": tuple(data or ())}
    run = Run(**what, progress=progress_on_stderr(), answerer_given=answerer)
    record = run_bench(EVALUATION, run, command=command_line())
    about = {"model": name, "model_digest": answerer.bundle.digest()} | about
    record = replace(record, config=record.config | about)
    if out is not None:
        record.save(out)
    typer.echo(page(EVALUATION, record), nl=False)
    if as_json:
        typer.echo(json.dumps(asdict(record)))
    worst = min(row.right for row in rows_of(record, "clips") if row.variant == GENERATED)
    if min_accuracy is not None and worst < min_accuracy:
        raise BelowMinimum(
            f"the lowest accuracy of the model's words is {worst:.3f}, expected at least "
            f"{min_accuracy:g}; see the tables above."
        )


def _inputs(real: Path | None, data: Sequence[Path], weights: Path | None) -> list[Path]:
    """Return the files that are read: the record must not take the place of one."""
    tables = [] if real is None else [*real.glob("*.csv"), *real.glob("*/*.csv")]
    return [*data, *tables, *([] if weights is None else [weights])]


def _trained_on(encoder: Encoder, preset: str, folder: Path, seed: int) -> tuple[str, Any]:
    """Train heads on a released encoder; return what the record calls it, and the bundle."""
    import torch

    from geotlm_lm.backbone.released import load_encoder
    from geotlm_lm.training.config import HEADS_PRESETS, preset_named
    from geotlm_lm.training.heads import train_heads

    preset_named(preset, HEADS_PRESETS)  # refused before gigabytes are read
    require_writable(folder, "--run-folder")
    released = load_encoder(encoder.weights, encoder.encoder, heads=encoder.heads)
    released.to("cuda" if torch.cuda.is_available() else "cpu")
    bundle = train_heads(released, preset, folder, seed, progress_on_stderr())
    return f"{released.row.title} ({encoder.weights.name})", bundle
