"""`geotlm-lm train`: make a model bundle from nothing but the simulator."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from geotlm_lm.cli.options import Seed, require_writable


def train(
    out: Annotated[Path, typer.Option(help="Run folder; an interrupted run in it is continued.")],
    preset: Annotated[
        str,
        typer.Option(
            help="smoke (minutes, to see it run) or default (the shipped bundle); with --keep the "
            "kept bundle's own."
        ),
    ] = "default",
    seed: Seed = 0,
    workers: Annotated[int, typer.Option(min=1, help="Processes that simulate.")] = 2,
    keep: Annotated[
        Path | None,
        typer.Option(help="Bundle of which all but the odometer is kept; only that is trained."),
    ] = None,
) -> None:
    """Train a model bundle; its folder is printed at the end, progress goes to stderr.

    Example: geotlm-lm train --preset smoke --out runs/smoke
    """
    require_writable(out, "--out")
    if keep is not None:
        from geotlm_lm.training.anew import train_odometer_anew

        print(f"training the odometer of {keep} into {out}", file=sys.stderr)
        print(train_odometer_anew(keep, out, seed, workers))
        return
    from geotlm_lm.training.train import train as train_bundle

    print(f"training preset {preset} into {out}", file=sys.stderr)
    print(train_bundle(preset, out, seed, workers))
